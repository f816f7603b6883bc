// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "stiffront/mesh/grid.hpp"
#include "stiffront/solvers/work.hpp"

namespace stiffront {

/// What is known of a run at its end. The same on all ranks where it matters; written by root.
struct Summary {
  std::string status;                 ///< "done", "stopped", or the kind of failure
  std::string reason;                 ///< the error or stop in one sentence; left out if empty
  std::string note;                   ///< what the method has to say about the run; left out if empty
  std::optional<double> final_error;  ///< estimate of the error of the final state, in the method's norm
  std::vector<std::string> advice;    ///< what the numbers mean and what to change
  std::string title;                  ///< left out if empty
  std::string model;
  std::string method;
  std::string choice;  ///< what the method "auto" took and why; left out if empty
  Grid grid;
  double time = 0.0;  ///< reached
  std::int64_t accepted = 0;
  std::int64_t rejected = 0;
  Work work;                       ///< summed over the ranks where a count is local
  std::int64_t allreduces = 0;     ///< in the time loop
  std::int64_t halo_messages = 0;  ///< sent in the time loop, by all ranks
  std::int64_t halo_bytes = 0;
  std::vector<std::pair<std::string, double>> wall_seconds;  ///< by phase: diffusion, reaction, quadrature, communication, output, total
  int ranks = 1;
  std::vector<int> processes;  ///< ranks per direction
  double imbalance = 1.0;      ///< largest over mean work of the ranks in the reaction
  /// What balancing the reaction has done; largest over mean counted work of the ranks in a call, averaged over calls by their work.
  struct Balance {
    double before = 1.0;
    double after = 1.0;
    std::int64_t messages = 0;  ///< sent by all ranks
    std::int64_t bytes = 0;
    std::int64_t cells = 0;  ///< that were integrated by another rank than their own
  };
  std::optional<Balance> balance;  ///< left out if there was none
  /// Of each rank in turn: Newton iterations of the reaction, seconds in the phases "diffusion", "reaction" and "communication".
  struct RankWork {
    std::int64_t newton_iterations = 0;
    double diffusion = 0.0;
    double reaction = 0.0;
    double communication = 0.0;
  };
  std::vector<RankWork> rank_work;
  std::int64_t negatives = 0;    ///< accepted steps whose state held a negative value
  double peak_memory_mib = 0.0;  ///< of the largest rank
  std::int64_t output_files = 0;
  std::int64_t checkpoints = 0;
  bool restarted = false;
  std::string checksum;  ///< of the final state
};

/// The summary as JSON, keys in a fixed order. Numbers that are not finite become the strings "nan", "inf" and "-inf".
std::string summary_json(const Summary& summary);

/// Writes summary.json: complete or not at all. On one process. @throws Error(io)
void write_summary(const std::string& path, const Summary& summary);

}  // namespace stiffront
