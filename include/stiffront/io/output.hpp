// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "stiffront/control/evolve.hpp"
#include "stiffront/io/history.hpp"
#include "stiffront/io/output_directory.hpp"
#include "stiffront/io/output_times.hpp"
#include "stiffront/io/probes.hpp"
#include "stiffront/io/xdmf.hpp"
#include "stiffront/mesh/boundary.hpp"
#include "stiffront/space/coupled_rhs.hpp"

namespace stiffront {

/// What a run leaves in its output folder while it runs: states with their XDMF series, history.csv and probes.csv.
///
/// Output never changes the steps, unless the times are to be landed on: then evolve() gets landing_times().
class Output {
 public:
  struct Options {
    OutputTimes times;
    bool land = false;  ///< steps are shortened to hit the times; otherwise states are interpolated
    std::vector<std::array<double, 2>> probes;
    std::vector<std::string> species;
    std::string case_text;  ///< complete, goes into every result file
  };

  /// @param rhs used where a state is interpolated.
  /// @throws Error(input) for a probe outside the grid. @mpi collective. All references must outlive the output.
  Output(const OutputDirectory& directory, const Decomposition& decomposition, const Boundary& boundary, CoupledRhs& rhs, Options options);

  std::vector<double> landing_times() const;

  /// Begins a fresh run and writes the initial state. @throws Error(io) @mpi collective, like all that follow.
  void begin(double t, const Field& u);
  /// Goes on after `accepted` steps: what an earlier run wrote beyond them is dropped.
  void resume(std::int64_t accepted);

  /// To be called by an Observer: after an attempt, with the seconds it took, and before an accepted step is taken.
  void attempted(const StepRecord& record, double seconds);
  /// @return how many states were written.
  int stepped(const StepRecord& record, double t_new, Field& u, Field& u_new);

  /// Writes the lines held back; before a checkpoint and at the end.
  void flush();

  /// Leaves behind what is known of a failure: the last good state as failed-NNNNNN.h5 and, unless it is empty, the text of
  /// failed-cell.toml. Not part of the series, and removed when the run goes on.
  void record_failure(std::int64_t step, double t, const Field& u, const std::string& cell_case) const;

  /// States written by this object, and the wall-clock seconds this rank spent in it.
  std::int64_t files() const { return files_; }
  double seconds() const { return seconds_; }

 private:
  void write(std::int64_t step, int index, double t, bool interpolated, const Field& u);

  const OutputDirectory* directory_;
  const Boundary* boundary_;
  CoupledRhs* rhs_;
  Options options_;
  History history_;
  Probes probes_;
  XdmfSeries series_;
  std::int64_t files_ = 0;
  double seconds_ = 0.0;
};

}  // namespace stiffront
