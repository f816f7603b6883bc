// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "stiffront/control/method.hpp"

namespace stiffront {

/// When to go from where to where.
struct Schedule {
  double start = 0.0;
  double end = 1.0;
  std::vector<double> breakpoints;  ///< ascending; a step lands on each, then the method restarts
  double restart_period = 0.0;      ///< if positive: every period the method restarts with the step restart_step
  double restart_step = 0.0;
  std::vector<double> landing_times;  ///< ascending; a step lands on each and the method goes on
  std::int64_t max_steps = 0;         ///< attempts; 0: no limit
  bool refuses_negative = false;      ///< an attempt that leaves a negative value anywhere is rejected
};

/// One attempt as the world sees it.
struct StepRecord {
  std::int64_t step = 0;  ///< number of accepted steps before this one
  double t = 0.0;         ///< where it began
  double dt = 0.0;
  double begin = 0.0;  ///< t, or just behind it where the data jump: rates at the beginning of the step are those at this time
  double end = 0.0;    ///< the same at its end: t + dt, or just before
  Attempt attempt;
};

/// Watches a run. All calls are collective.
class Observer {
 public:
  virtual ~Observer() = default;
  /// Requests of this rank that ride in the next agreement (bits from step_flags::first_of_driver upwards).
  virtual std::uint64_t requests() { return 0; }
  /// After every attempt, accepted or not.
  virtual void attempted(const StepRecord& record) { static_cast<void>(record); }
  /// Before an accepted step is taken: both ends of the step are there. Halos may be used as working space.
  virtual void stepped(const StepRecord& record, double t_new, Field& u, Field& u_new) {
    static_cast<void>(record), static_cast<void>(t_new), static_cast<void>(u), static_cast<void>(u_new);
  }
  /// After an accepted step was taken, with the agreed requests of all ranks. @return false to stop here.
  virtual bool carry_on(std::uint64_t requests, std::int64_t step, double t, double dt_next, Field& u) {
    static_cast<void>(requests), static_cast<void>(step), static_cast<void>(t), static_cast<void>(dt_next), static_cast<void>(u);
    return true;
  }
};

/// Where a run stands; what a checkpoint holds besides the fields and the method's own state.
struct Progress {
  std::int64_t accepted = 0;
  std::int64_t rejected = 0;
  double t = 0.0;
  double dt = 0.0;         ///< step to try next; 0: ask the method
  double resume_dt = 0.0;  ///< step planned before one was cut short; 0: none
};

/// The only time loop. Goes from progress.t (schedule.start in a fresh run) to schedule.end, or until the observer stops it.
/// @return whether the end was reached.
/// @throws Error(numerics) on every rank if the step size underflows or max_steps is reached, with the reason of the last rejection.
bool evolve(Method& method, const Schedule& schedule, Field& u, Progress& progress, Observer& observer);

}  // namespace stiffront
