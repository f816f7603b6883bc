// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "stiffront/core/mpi.hpp"

namespace stiffront {

/// What to do with results that are already there.
enum class ExistingResults {
  refuse,   ///< an error
  replace,  ///< they are removed (--force)
  keep      ///< they belong to the run that is being continued
};

/// The folder a run writes into: made if needed, proved writable, and guarded against overwriting another run, all before the first
/// step.
class OutputDirectory {
 public:
  /// @throws Error(io) on every rank: cannot be created or written, not seen by a rank (no shared file system), or holds the results of
  ///         another run, with the remedy. @mpi collective; comm must outlive the directory.
  OutputDirectory(const Communicator& comm, std::string path, ExistingResults existing);

  const Communicator& comm() const { return *comm_; }
  const std::string& path() const { return path_; }
  std::string file(const std::string& name) const;
  std::string checkpoints() const { return file("checkpoints"); }

  /// fields-NNNNNN.h5; a positive index distinguishes further states within one step (fields-NNNNNN-K.h5, earlier in time than the
  /// one without).
  static std::string state_name(std::int64_t step, int index = 0);
  /// What a run that failed leaves behind: its last good state, and a case file in which the failed cell is alone.
  static std::string failed_state_name(std::int64_t step);
  static constexpr const char* failed_cell = "failed-cell.toml";
  /// Names of the result files, ascending in step and time. On one process.
  std::vector<std::string> state_names() const;
  /// Removes result files of steps beyond `step`: a continued run will write them again. On one process.
  void remove_states_after(std::int64_t step) const;
  /// Removes what an earlier failure left behind. On one process.
  void remove_failures() const;

 private:
  const Communicator* comm_;
  std::string path_;
};

/// The results of a run that are in a folder, by name; empty if there are none or there is no such folder.
std::vector<std::string> results_in(const std::string& path);

}  // namespace stiffront
