// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "stiffront/app/options.hpp"
#include "stiffront/app/problem.hpp"
#include "stiffront/control/evolve.hpp"
#include "stiffront/io/summary.hpp"

namespace stiffront::app {

/// What the estimates of a run's attempts add up to.
class ErrorRecord {
 public:
  explicit ErrorRecord(const MethodOptions& method);

  void add(const StepRecord& record);

  /// Size of an estimate of 1 relative to the solution: estimates of multistep methods are in units of their tolerance.
  double unit() const { return unit_; }
  double tolerance() const { return tolerance_; }  ///< 0: the method has none
  double sum() const { return unit_ * sum_; }      ///< of the accepted estimates, relative to the solution
  double largest() const { return unit_ * largest_; }
  std::int64_t estimates() const { return estimates_; }
  /// The longer of the last two accepted steps: the very last may have been cut.
  double recent_step() const { return std::max(last_step_, step_before_); }
  /// Accepted steps that the critical splitting step kept from being longer.
  std::int64_t at_critical_step() const { return at_critical_step_; }

 private:
  double unit_ = 1.0;
  double tolerance_ = 0.0;
  double sum_ = 0.0;
  double largest_ = 0.0;
  double last_step_ = 0.0;
  double step_before_ = 0.0;
  std::int64_t estimates_ = 0;
  std::int64_t at_critical_step_ = 0;
};

/// What the differences in space miss of the diffusion in the present state.
struct SpatialError {
  /// For each species, relative to the largest modulus of its diffusion term over the grid; 0 where nothing diffuses.
  std::vector<double> missed;
  /// Error per unit of time, in the norm of the splitting methods: times a step, the space error of that step in (48) of
  /// Duarte & Emmett 2016.
  double rate = 0.0;
};

/// From the difference between order two and order four. @mpi collective.
SpatialError spatial_error(Problem& problem);

/// What the numbers of a finished run mean, and what to change if they are not good enough. One sentence or two each.
std::vector<std::string> advice(const Case& c, const Summary& summary, const ErrorRecord& errors, const SpatialError& in_space);

}  // namespace stiffront::app
