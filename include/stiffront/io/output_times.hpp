// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <vector>

namespace stiffront {

/// When states are written: at listed times, at start + k * every, and every so many accepted steps; any of them may be unused. The
/// initial and the final state are written besides.
///
/// Without memory: what is due in a step follows from its ends alone, so a continued run needs nothing but its time.
struct OutputTimes {
  double start = 0.0;
  double end = 1.0;
  std::vector<double> times;  ///< ascending
  double every = 0.0;         ///< 0: unused
  std::int64_t steps = 0;     ///< 0: unused

  /// Times inside (start, end), ascending: where steps land in the mode "land".
  std::vector<double> inner() const;
  /// Times in (t, t_new): states to be interpolated.
  std::vector<double> between(double t, double t_new) const;
  /// Whether the state at the end t_new of a step, the accepted one number `accepted`, is due.
  bool due_at(double t_new, std::int64_t accepted) const;

 private:
  /// Whether two times differ by no more than round-off: they are then one.
  bool same(double a, double b) const;
  /// Times in [from, to], ascending, each once.
  std::vector<double> in(double from, double to) const;
};

}  // namespace stiffront
