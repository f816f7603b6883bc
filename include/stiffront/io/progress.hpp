// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <cstdio>
#include <string>

#include "stiffront/control/evolve.hpp"

namespace stiffront {

enum class ProgressMode { automatic, always, never };

/// Whether what is written to the stream reaches a person at a terminal. mpirun hands its processes a pseudo-terminal even when its own
/// output goes to a file; then the launcher's output decides.
bool reaches_terminal(std::FILE* stream);

/// One line on how a run is getting on, on root: rewritten in place on a terminal, else a plain line whenever states are written or ten
/// seconds have passed. No colour is used.
class ProgressLine {
 public:
  /// @param speaks false on all ranks but root, and with --quiet.
  /// always: rewritten in place whatever the stream is; never: silent.
  ProgressLine(bool speaks, ProgressMode mode, std::FILE* stream, double start, double end);
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;
  /// Ends a rewritten line, so that what follows begins on its own.
  ~ProgressLine() { interrupt(); }

  /// The time from which the rate of progress counts; the start, unless the run is continued.
  void begin(double t);
  void attempted(const StepRecord& record);
  /// @param wrote_state whether results were written in this step.
  void stepped(const StepRecord& record, double t_new, bool wrote_state);
  /// Ends a line being rewritten, before something else is printed.
  void interrupt();

 private:
  std::string text(const StepRecord& record, double t_new, double now) const;

  bool speaks_;
  bool in_place_;
  std::FILE* stream_;
  double start_;
  double end_;
  double t_began_;
  double began_;
  double last_shown_;
  std::int64_t rejected_ = 0;
  std::size_t shown_length_ = 0;
};

}  // namespace stiffront
