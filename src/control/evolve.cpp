// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/evolve.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "stiffront/core/error.hpp"

namespace stiffront {
namespace {

/// A time a step must land on, and what happens there.
struct Target {
  double t;
  bool restarts;     // the method forgets its history
  bool resets_step;  // ... and begins with Schedule::restart_step
};

Target next_target(const Schedule& s, double t) {
  // A time already reached, up to round-off, is no target any more.
  const double tiny = 4.0 * std::numeric_limits<double>::epsilon() * std::max({std::abs(t), std::abs(s.end), s.end - s.start});
  Target target{s.end, false, false};
  const auto consider = [&](double time, bool restarts, bool resets) {
    if (time <= t + tiny || time > target.t + tiny) return;
    // Times that differ by round-off are one time: 3 * 1e-6 is not 3e-6, and what happens at the second must not be lost.
    if (std::abs(time - target.t) <= tiny) {
      target.restarts |= restarts;
      target.resets_step |= resets;
    } else {
      target = {time, restarts, resets};
    }
  };
  for (double time : s.breakpoints) consider(time, true, false);
  for (double time : s.landing_times) consider(time, false, false);
  if (s.restart_period > 0.0) {
    const double k = std::floor((t + tiny - s.start) / s.restart_period) + 1.0;
    consider(s.start + k * s.restart_period, true, true);
  }
  return target;
}

/// A step between two jumps of the data must see neither of their other sides, and whether data written as t < b or t <= b jump before or
/// behind b is not known: a step begins this much behind a jump and ends so much before the next, a few units in the last place of its time.
double width_of_jump(const Schedule& s, double t) {
  return 6.0 * std::numeric_limits<double>::epsilon() * std::max({std::abs(t), std::abs(s.start), s.restart_period});
}

bool data_jump_at(const Schedule& s, double t) {
  const double width = width_of_jump(s, t);
  const auto here = [&](double time) { return std::abs(time - t) <= width; };
  if (std::any_of(s.breakpoints.begin(), s.breakpoints.end(), here)) return true;
  if (!(s.restart_period > 0.0)) return false;
  const double k = std::round((t - s.start) / s.restart_period);
  return k >= 0.0 && here(s.start + k * s.restart_period);
}

/// Where a step from t begins.
double inside(const Schedule& s, double t) { return data_jump_at(s, t) ? t + width_of_jump(s, t) : t; }

constexpr double round_off = 16.0 * std::numeric_limits<double>::epsilon();

[[noreturn]] void throw_underflow(const StepRecord& r) {
  throw Error(ErrorKind::numerics,
              fmt::format("the step size underflowed at t = {:.17g} (dt = {:.3g}) after {} accepted steps{}{}; loosen the tolerance or "
                          "check the model and its initial state",
                          r.t, r.dt, r.step, r.attempt.reason.empty() ? "" : ": ", r.attempt.reason));
}

/// Rates or derivatives that are not finite leave nothing to begin with.
double first_step(Method& method, double t, double t_end, Field& u) {
  const double dt = method.first_step(t, t_end, u);
  if (dt > 0.0 && dt < std::numeric_limits<double>::infinity()) return dt;
  throw Error(ErrorKind::numerics, fmt::format("no first step can be chosen at t = {:.17g}: the model's rates or their derivatives are not "
                                               "finite there; check the model and its initial state",
                                               t));
}

}  // namespace

bool evolve(Method& method, const Schedule& schedule, Field& u, Progress& progress, Observer& observer) {
  Field u_new = u.similar();
  if (progress.dt == 0.0) progress.dt = first_step(method, inside(schedule, progress.t), schedule.end, u);
  while (progress.t < schedule.end) {
    if (schedule.max_steps > 0 && progress.accepted + progress.rejected >= schedule.max_steps) {
      throw Error(ErrorKind::numerics, fmt::format("limits.max_steps: {} attempts were made and t = {:.17g} is reached, not {:.17g}",
                                                   schedule.max_steps, progress.t, schedule.end));
    }
    const Target target = next_target(schedule, progress.t);
    StepRecord record;
    record.step = progress.accepted;
    record.t = progress.t;
    // A last step may be a little longer than planned: better than a tiny one after it.
    bool lands = progress.t + 1.01 * progress.dt >= target.t;
    if (!lands && !(progress.dt > round_off * std::abs(progress.t))) {  // accepted steps have shrunk until the time stands still
      record.dt = progress.dt;
      throw_underflow(record);
    }
    const bool cut = lands && target.t - progress.t < 0.999 * progress.dt;
    record.dt = lands ? target.t - progress.t : progress.dt;
    record.begin = inside(schedule, progress.t);
    record.end = lands && target.restarts ? target.t - width_of_jump(schedule, target.t) : progress.t + record.dt;
    const bool shifted = record.begin != progress.t || record.end != progress.t + record.dt;
    const double dt = shifted ? record.end - record.begin : record.dt;
    std::uint64_t flags = observer.requests() | (schedule.refuses_negative ? step_flags::refuse_negative : 0U);
    record.attempt = method.attempt(record.begin, dt, u, u_new, flags);
    if (record.attempt.accepted && record.attempt.dt_taken > 0.0 && record.attempt.dt_taken != dt) {
      record.dt = record.attempt.dt_taken;
      record.end = record.begin + record.dt;
      lands = false;
    }
    observer.attempted(record);
    const Attempt& a = record.attempt;

    if (!a.accepted) {
      ++progress.rejected;
      progress.resume_dt = 0.0;
      if (!(a.dt_next < record.dt)) throw Error(ErrorKind::bug, "a rejected attempt did not ask for a smaller step");
      progress.dt = a.dt_next;
      if (!(progress.dt > round_off * std::max(std::abs(progress.t), schedule.end - schedule.start))) throw_underflow(record);
      continue;
    }

    const double t_new = lands ? target.t : record.begin + record.dt;
    observer.stepped(record, t_new, u, u_new);
    if (cut && progress.resume_dt == 0.0) progress.resume_dt = progress.dt;
    method.accept(u, u_new);
    progress.t = t_new;
    ++progress.accepted;
    progress.dt = a.dt_next;
    if (progress.resume_dt > 0.0) {
      if (method.resumes_after_short_step()) progress.dt = std::max(progress.dt, progress.resume_dt);
      progress.resume_dt = 0.0;
    }
    if (lands && target.restarts) {
      method.restart(progress.t);
      progress.dt = target.resets_step && schedule.restart_step > 0.0 ? schedule.restart_step
                                                                      : first_step(method, inside(schedule, progress.t), schedule.end, u);
    }
    if (!observer.carry_on(flags, progress.accepted, progress.t, progress.dt, u)) return progress.t >= schedule.end;
  }
  return true;
}

}  // namespace stiffront
