// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "stiffront/control/evolve.hpp"
#include "stiffront/core/mpi.hpp"

namespace stiffront {

/// history.csv: one line per attempted step.
///
/// step is the number of steps accepted before the attempt and time where it began; iterations is the order for multistep methods;
/// reaction_steps is summed over all ranks; wall_seconds is what the attempt took on root. Lines are kept back and written in batches,
/// with one reduction for all of them.
class History {
 public:
  /// @mpi comm must outlive the history.
  History(const Communicator& comm, std::string path) : comm_(&comm), path_(std::move(path)) {}

  /// A fresh file with its header. @throws Error(io) on every rank. @mpi collective.
  void begin();
  /// Goes on with an existing file: drops what was written after `accepted` steps. @mpi collective.
  void resume(std::int64_t accepted);

  /// Every rank adds the same attempts.
  void add(const StepRecord& record, double wall_seconds);
  /// Whether so many lines are kept back that they should be written.
  bool is_full() const { return records_.size() >= batch; }
  /// @throws Error(io) on every rank. @mpi collective.
  void flush();

 private:
  static constexpr std::size_t batch = 64;

  const Communicator* comm_;
  std::string path_;
  std::vector<StepRecord> records_;
  std::vector<double> wall_seconds_;
};

}  // namespace stiffront
