// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <functional>
#include <limits>
#include <vector>

namespace stiffront {

/// Errors of a step at its own and the neighbouring orders, relative to the tolerance.
struct BdfErrors {
  double same = 0.0;
  double lower = std::numeric_limits<double>::infinity();  ///< at order - 1; infinite if unknown
  double upper = std::numeric_limits<double>::infinity();  ///< at order + 1; infinite if unknown
  double second = std::numeric_limits<double>::infinity();  ///< at order 2; infinite if unknown
};

/// Step size and order of a variable-step, variable-order BDF method, from error estimates alone.
///
/// It aims at a third of the tolerance. A changed step is held for order + 1 steps before it is raised again, and
/// raised only if that gains a fifth; it is lowered at once if the next error would come close to the tolerance. The
/// order with the largest step is taken; it is reconsidered every order + 1 steps.
///
/// Orders above 2 are unstable for decaying oscillations near the imaginary axis within some range of the step. The
/// ringing shows in the errors, which keep the step at the edge of that range, but looks there much like a solution that
/// varies fast. So the two are told apart by trial: if the step has not grown for a while and order 2 would not make it
/// much shorter, order 2 is used for some steps. If the step then grows, the high orders were ringing and are given up
/// until it stops growing; if not, the next trial comes after four times as many steps.
class BdfControl {
 public:
  explicit BdfControl(int max_order) : max_order_(max_order) {}

  int order() const { return order_; }
  /// Whether the next step should come with the errors at the neighbouring orders.
  bool wants_order_test() const { return max_order_ > 1 && held_ % (order_ + 1) == order_; }
  /// Whether that test should have the error at order 2 instead of that at order + 1.
  bool wants_second_order() const { return suspects_ringing_ && order_ > 2; }
  /// The highest order that may be used next.
  int highest_order() const { return phase_ == Phase::free ? max_order_ : std::min(max_order_, 2); }
  /// Whether orders above 2 are given up since they would ring.
  bool avoids_ringing() const { return phase_ == Phase::low; }

  /// After an accepted step: sets the order and returns the size of the next one.
  /// @param limit (order, dt): the step to make in place of a wanted one for reasons other than accuracy; at most dt
  double accepted(double dt, const BdfErrors& errors, const std::function<double(int, double)>& limit);
  /// After a rejected one. An error that is not finite counts as a step hopelessly too large.
  double rejected(double dt, double error);
  /// Begin again at order 1.
  void restart() { *this = BdfControl(max_order_); }

  std::vector<double> state() const;
  void set_state(const std::vector<double>& numbers);

 private:
  enum class Phase { free, trial, low };
  void watch_for_ringing(double dt, bool is_limited);

  int max_order_;
  int order_ = 1;
  int held_ = 0;        ///< accepted steps since step or order changed
  int rejections_ = 0;  ///< in a row

  Phase phase_ = Phase::free;
  bool suspects_ringing_ = false;
  int watched_ = 0;          ///< accepted steps since watched_dt_ was the step
  double watched_dt_ = 0.0;
  int patience_ = 24;        ///< steps without growth before order 2 is tried
  int low_patience_ = 40;    ///< ... before the higher orders are tried again
};

}  // namespace stiffront
