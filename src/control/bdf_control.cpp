// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/bdf_control.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace stiffront {
namespace {

/// The tolerance over the error aimed at; at low order while the step still grows from the first one. Those few steps,
/// each longer than all before, would otherwise leave half of the error of a run of thousands of steps.
constexpr double bias = 3.0;
constexpr double bias_of_start = 30.0;
constexpr double end_of_start = 0.1;
constexpr int highest_order_of_start = 3;
constexpr double worth_raising = 1.2;
constexpr double worth_lowering = 0.9;
/// Largest ratio of a step to the one before, by order, if held for order + 1 steps: disturbances then grow by factors
/// below 4 (docs/sbdf-stability.md).
constexpr std::array<double, 6> max_growth{0.0, 4.0, 2.2, 1.7, 1.45, 1.35};

/// What max_growth makes of a step in eight, by order: where the step may grow much, a low order gets there sooner.
constexpr std::array<double, 7> reach{0.0, 256.0, 8.19, 2.89, 1.81, 1.49, 0.0};

/// Ringing: the error at order 2, over the tolerance, up to which it may pay to use quiet orders; steps at order 1
/// before that, and steps after which it must have paid; the growth of the step that counts as such.
constexpr double worth_a_trial = 2.0;
constexpr int damping_steps = 20;
constexpr double first_damping_error = 60.0;
constexpr double damping_factor = 0.85;
constexpr int trial_steps = 100;
constexpr double growing = 1.3;

}  // namespace

double BdfControl::aim_of_start() { return 1.0 / bias_of_start; }

double BdfControl::ratio_for(double error, int order) const {
  if (std::isnan(error)) return 0.0;
  const double aim = is_starting_ && order <= highest_order_of_start ? bias_of_start : bias;
  return error > 0.0 ? std::pow(aim * error, -1.0 / (order + 1)) : std::numeric_limits<double>::infinity();
}

double BdfControl::accepted(double dt, const BdfErrors& errors, const std::function<double(int, double)>& limit) {
  rejections_ = 0;
  ++held_;
  if (phase_ == Phase::damping) {
    watch_for_ringing(dt);
    return std::min(dt, limit(order_, std::numeric_limits<double>::infinity()));
  }
  if (errors.same > end_of_start) is_starting_ = false;
  double ratio = ratio_for(errors.same, order_);
  int next = order_;
  const double lower = order_ > 1 ? ratio_for(errors.lower, order_ - 1) : 0.0;
  const double upper = order_ < highest_order() ? ratio_for(errors.upper, order_ + 1) : 0.0;
  const auto reached = [](double wanted, int order) { return std::min(wanted, reach[static_cast<std::size_t>(order)]); };
  const double here = reached(ratio, order_);
  const double below = reached(lower, order_ - 1);
  const double above = reached(upper, order_ + 1);
  if (below > here && below > above) {
    next = order_ - 1;
    ratio = lower;
  } else if (above > here) {
    next = order_ + 1;
    ratio = upper;
  }
  if (std::isfinite(errors.second)) {
    suspicion_ = errors.second <= worth_a_trial ? Suspicion::of_modes : Suspicion::none;
  }
  if (errors.quiet_order > 0) {
    suspicion_ = Suspicion::none;
    if (errors.quiet_order < order_) {
      quiet_order_ = errors.quiet_order;
      phase_ = Phase::damping;
      watched_ = 0;
      watched_dt_ = dt;
      order_ = 1;
      return std::min(std::max(dt, suspected_dt_), limit(order_, std::numeric_limits<double>::infinity()));
    }
    patience_ *= 2;
  }
  const double target = limit(next, dt * ratio);
  watch_for_ringing(dt);
  const bool may_raise = held_ > order_;
  double dt_next = dt;
  if (next != order_ || target < worth_lowering * dt || (may_raise && target > worth_raising * dt)) {
    held_ = 0;
    order_ = next;
    dt_next = std::min(std::max(target, 0.5 * dt), max_growth[static_cast<std::size_t>(order_)] * dt);
  } else if (may_raise) {
    is_starting_ = false;
  }
  room_ = target / dt_next;
  // A step that need not grow any more may be dearer than a somewhat shorter one.
  const bool grows = target > worth_raising * dt_next;
  const double economic = std::min(dt_next, limit(order_, grows ? std::numeric_limits<double>::infinity() : dt_next));
  if (economic != dt_next && economic != dt) held_ = 0;
  return economic;
}

int BdfControl::likely_alike() const {
  constexpr double calm = 1.05;  // a step is near enough to the end of its range to leave it
  if (phase_ == Phase::damping || room_ < calm * worth_lowering) return 1;
  if (held_ > order_ && calm * room_ > worth_raising) return 1;
  return order_ - held_ % (order_ + 1) + 1;
}

void BdfControl::watch_for_ringing(double dt) {
  ++watched_;
  largest_dt_ = std::max(largest_dt_, dt);
  const bool grows = dt > growing * watched_dt_;
  const auto watch_anew = [&] {
    watched_ = 0;
    watched_dt_ = largest_dt_ = dt;
  };
  switch (phase_) {
    case Phase::free:
      if (watched_ < patience_) return;
      suspicion_ = grows ? Suspicion::none : Suspicion::of_errors;
      suspected_dt_ = largest_dt_;
      return watch_anew();
    case Phase::damping:
      if (watched_ == damping_steps) phase_ = Phase::trial;
      return;
    case Phase::trial:
      if (watched_ < trial_steps) return;
      phase_ = grows ? Phase::quiet : Phase::free;
      if (!grows) patience_ *= 2;
      return watch_anew();
    case Phase::quiet:
      if (watched_ < quiet_patience_) return;
      if (!grows) {
        phase_ = Phase::free;
        quiet_patience_ *= 4;
      }
      return watch_anew();
  }
}

int BdfControl::highest_order() const {
  switch (phase_) {
    case Phase::free:
      return max_order_;
    case Phase::damping:
      return 1;
    default:
      return quiet_order_;
  }
}

double BdfControl::largest_error() const {
  return phase_ == Phase::damping ? first_damping_error * std::pow(damping_factor, watched_) : 1.0;
}

double BdfControl::rejected(double dt, double error) {
  held_ = 0;
  is_starting_ = false;
  room_ = 0.0;
  ++rejections_;
  if (phase_ == Phase::damping) {
    // Order 1 is too rough for the rest of the solution.
    phase_ = Phase::free;
    watched_ = 0;
    watched_dt_ = largest_dt_ = dt;
    patience_ *= 2;
  }
  const double ratio = ratio_for(error, order_);
  if (rejections_ > 1 && order_ > 1) --order_;
  return dt * std::clamp(ratio, 0.2, 0.9);
}

std::vector<double> BdfControl::state() const {
  return {static_cast<double>(order_),
          static_cast<double>(held_),
          static_cast<double>(rejections_),
          static_cast<double>(phase_),
          static_cast<double>(suspicion_),
          static_cast<double>(watched_),
          watched_dt_,
          largest_dt_,
          suspected_dt_,
          static_cast<double>(quiet_order_),
          static_cast<double>(patience_),
          static_cast<double>(quiet_patience_),
          is_starting_ ? 1.0 : 0.0};
}

void BdfControl::set_state(const std::vector<double>& numbers) {
  const auto integer = [&](std::size_t i) { return static_cast<int>(numbers.at(i)); };
  order_ = integer(0);
  held_ = integer(1);
  rejections_ = integer(2);
  phase_ = static_cast<Phase>(integer(3));
  suspicion_ = static_cast<Suspicion>(integer(4));
  watched_ = integer(5);
  watched_dt_ = numbers.at(6);
  largest_dt_ = numbers.at(7);
  suspected_dt_ = numbers.at(8);
  quiet_order_ = integer(9);
  patience_ = integer(10);
  quiet_patience_ = integer(11);
  is_starting_ = integer(12) != 0;
  room_ = 0.0;
}

}  // namespace stiffront
