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
  const double upper = order_ < max_order_ ? ratio_for(errors.upper, order_ + 1) : 0.0;
  if (lower > ratio && lower > upper) {
    next = order_ - 1;
    ratio = lower;
  } else if (upper > ratio) {
    next = order_ + 1;
    ratio = upper;
  }
  const double target = limit(next, dt * ratio);
  const bool may_raise = held_ > order_;
  double dt_next = dt;
  if (next != order_ || target < worth_lowering * dt || (may_raise && target > worth_raising * dt)) {
    held_ = 0;
    order_ = next;
    dt_next = std::min(std::max(target, 0.5 * dt), max_growth[static_cast<std::size_t>(order_)] * dt);
  }
  return std::min(dt_next, limit(order_, std::numeric_limits<double>::infinity()));
}

double BdfControl::rejected(double dt, double error) {
  held_ = 0;
  ++rejections_;
  const double ratio = ratio_for(error, order_);
  if (rejections_ > 1 && order_ > 1) --order_;
  return dt * std::clamp(ratio, 0.2, 0.9);
}

void BdfControl::restart() {
  order_ = 1;
  held_ = 0;
  rejections_ = 0;
}

std::vector<double> BdfControl::state() const {
  return {static_cast<double>(order_), static_cast<double>(held_), static_cast<double>(rejections_)};
}

void BdfControl::set_state(const std::vector<double>& numbers) {
  order_ = static_cast<int>(numbers.at(0));
  held_ = static_cast<int>(numbers.at(1));
  rejections_ = static_cast<int>(numbers.at(2));
}

}  // namespace stiffront
