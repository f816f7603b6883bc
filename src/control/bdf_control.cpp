// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/bdf_control.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace stiffront {
namespace {

/// The tolerance over the error aimed at.
constexpr double bias = 3.0;
constexpr double worth_raising = 1.2;
constexpr double worth_lowering = 0.9;
/// Largest ratio of a step to the one before, by order, if held for order + 1 steps: disturbances then grow by factors
/// below 4 (docs/sbdf-stability.md).
constexpr std::array<double, 6> max_growth{0.0, 3.0, 1.8, 1.4, 1.25, 1.2};

/// Ringing: the error at order 2, over the tolerance, up to which order 2 is tried; for how many steps; and the growth of
/// the step that counts as such.
constexpr double worth_a_trial = 0.95;
constexpr int trial_steps = 60;
constexpr double growing = 1.3;

/// The step ratio that brings the error to the one aimed at.
double ratio_for(double error, int order) {
  if (std::isnan(error)) return 0.0;
  return error > 0.0 ? std::pow(bias * error, -1.0 / (order + 1)) : std::numeric_limits<double>::infinity();
}

}  // namespace

double BdfControl::accepted(double dt, const BdfErrors& errors, const std::function<double(int, double)>& limit) {
  rejections_ = 0;
  ++held_;
  double ratio = ratio_for(errors.same, order_);
  int next = order_;
  const double lower = order_ > 1 ? ratio_for(errors.lower, order_ - 1) : 0.0;
  const double upper = order_ < highest_order() ? ratio_for(errors.upper, order_ + 1) : 0.0;
  if (lower > ratio && lower > upper) {
    next = order_ - 1;
    ratio = lower;
  } else if (upper > ratio) {
    next = order_ + 1;
    ratio = upper;
  }
  if (suspects_ringing_ && order_ > 2 && errors.second <= worth_a_trial) {
    next = 2;
    suspects_ringing_ = false;
    phase_ = Phase::trial;
    watched_ = 0;
    watched_dt_ = dt;
  }
  // The damping of order 2 falls with the fourth power of the step: a trial is made with the step that rings.
  if (phase_ == Phase::trial && ratio < 1.0 && errors.same <= worth_a_trial) ratio = 1.0;
  const double target = limit(next, dt * ratio);
  watch_for_ringing(dt, target < 0.9 * dt * ratio);
  const bool may_raise = held_ > order_;
  double dt_next = dt;
  if (next != order_ || target < worth_lowering * dt || (may_raise && target > worth_raising * dt)) {
    held_ = 0;
    order_ = next;
    dt_next = std::min(std::max(target, 0.5 * dt), max_growth[static_cast<std::size_t>(order_)] * dt);
  }
  return std::min(dt_next, limit(order_, std::numeric_limits<double>::infinity()));
}

/// @param is_limited whether something else than the error keeps the step from growing
void BdfControl::watch_for_ringing(double dt, bool is_limited) {
  ++watched_;
  const bool grows = dt > growing * watched_dt_;
  const auto watch_anew = [&] {
    watched_ = 0;
    watched_dt_ = dt;
  };
  switch (phase_) {
    case Phase::free:
      if (is_limited) return watch_anew();
      if (watched_ < patience_) return;
      suspects_ringing_ = !grows;
      return watch_anew();
    case Phase::trial:
      if (watched_ < trial_steps) return;
      phase_ = grows ? Phase::low : Phase::free;
      if (!grows) patience_ *= 4;
      return watch_anew();
    case Phase::low:
      if (watched_ < low_patience_) return;
      if (!grows) {
        phase_ = Phase::free;
        low_patience_ *= 4;
      }
      return watch_anew();
  }
}

double BdfControl::rejected(double dt, double error) {
  held_ = 0;
  ++rejections_;
  const double ratio = ratio_for(error, order_);
  if (rejections_ > 1 && order_ > 1) --order_;
  return dt * std::clamp(ratio, 0.2, 0.9);
}

std::vector<double> BdfControl::state() const {
  return {static_cast<double>(order_),
          static_cast<double>(held_),
          static_cast<double>(rejections_),
          static_cast<double>(phase_),
          suspects_ringing_ ? 1.0 : 0.0,
          static_cast<double>(watched_),
          watched_dt_,
          static_cast<double>(patience_),
          static_cast<double>(low_patience_)};
}

void BdfControl::set_state(const std::vector<double>& numbers) {
  const auto integer = [&](std::size_t i) { return static_cast<int>(numbers.at(i)); };
  order_ = integer(0);
  held_ = integer(1);
  rejections_ = integer(2);
  phase_ = static_cast<Phase>(integer(3));
  suspects_ringing_ = integer(4) != 0;
  watched_ = integer(5);
  watched_dt_ = numbers.at(6);
  patience_ = integer(7);
  low_patience_ = integer(8);
}

}  // namespace stiffront
