// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "stiffront/control/evolve.hpp"
#include "stiffront/control/method.hpp"
#include "stiffront/mesh/decomposition.hpp"

namespace stiffront {

/// What identifies the run a checkpoint belongs to.
struct CheckpointHeader {
  std::int64_t step = 0;  ///< accepted steps
  double time = 0.0;
  std::string model;
  std::vector<std::string> species;
  Grid grid;
  std::string case_text;  ///< the complete case file, TOML
};

/// Shows everything a run must remember to a visitor: the state, the Progress, the method and whatever counts. Called on saving and on
/// loading, with the same names in both; must not communicate.
using VisitState = std::function<void(StateVisitor&)>;

void visit_progress(StateVisitor& visitor, Progress& progress);

/// Writes folder/NNNNNN (the step): a file rank-NNNN.h5 per rank with its box, and manifest.json with the sizes and hashes of all.
///
/// A checkpoint appears complete or not at all, whatever the moment of a crash: everything is written and on the disk under a temporary
/// name before the folder is renamed, and only then are older ones pruned, down to `keep` (those of later steps, left from a run that
/// this one does not continue, go too). After a failure the earlier ones are as they were. Files are built in memory: twice the size of
/// the largest field set is needed for a moment.
/// @throws Error(io) on every rank if it failed on any. @mpi collective.
void write_checkpoint(const std::string& folder, const CheckpointHeader& header, const Decomposition& decomposition, int keep,
                      const VisitState& visit);

struct Manifest;

/// A checkpoint that was found whole.
class Checkpoint {
 public:
  /// The newest valid one in a folder of checkpoints, in an output folder that has one, or the very checkpoint that is named. Each
  /// byte is checked: sizes and hashes of all files, read in parallel. Broken ones are passed over, with a warning that names them.
  /// @throws Error(io) on every rank if there is none, with what is wrong with those that are there.
  /// @mpi collective; comm must outlive the checkpoint.
  Checkpoint(const Communicator& comm, const std::string& path);

  const std::string& path() const { return path_; }
  const CheckpointHeader& header() const { return header_; }
  const std::vector<std::string>& warnings() const { return warnings_; }

  /// @throws Error(input) if the run has another model, other species or another grid.
  void require(const std::string& model, const std::vector<std::string>& species, const Grid& grid) const;

  /// Gives everything back, on any number and layout of ranks; each rank reads what overlaps its box.
  /// @throws Error(input) on every rank if the checkpoint lacks what the run asks for, or holds what it does not ask for: another
  ///         method's memory. @mpi collective.
  void load(const Decomposition& decomposition, const VisitState& visit) const;

 private:
  const Communicator* comm_;
  std::string path_;
  CheckpointHeader header_;
  std::vector<std::string> warnings_;
  std::shared_ptr<const Manifest> manifest_;
};

}  // namespace stiffront
