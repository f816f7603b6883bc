// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <functional>
#include <limits>
#include <vector>

namespace stiffront {

/// Errors of a step at its own and the neighbouring orders, relative to the tolerance.
struct BdfErrors {
  double same = 0.0;
  double lower = std::numeric_limits<double>::infinity();   ///< at order - 1; infinite if unknown
  double upper = std::numeric_limits<double>::infinity();   ///< at order + 1; infinite if unknown
  double second = std::numeric_limits<double>::infinity();  ///< at order 2; infinite if unknown
  int quiet_order = 0;                                      ///< the highest that does not ring; 0 if unknown
};

/// Step size and order of a variable-step, variable-order BDF method, from error estimates alone.
///
/// It aims at a third of the tolerance, and at a thirtieth at the low orders of a start. A changed step is held for
/// order + 1 steps before it is raised again, and raised only if that gains a fifth; it is lowered at once if the next
/// error would come close to the tolerance. The order with the largest step is taken; it is reconsidered every order + 1
/// steps.
///
/// Orders above 2 are unstable for decaying oscillations near the imaginary axis within some range of the step. The
/// ringing shows in the errors, which keep the step at the edge of that range, but looks there much like a solution that
/// varies fast. If the step has not grown for a while and order 2 would not make it much shorter, the control therefore
/// asks for the highest order that does not ring (control/bdf_ringing.hpp). If a higher one is in use, some
/// steps of the same size at order 1 damp what rings, and then only quiet orders are used. If that lets the step grow, it
/// remains so until it stops growing; if not, all orders are allowed again for four times as many steps.
class BdfControl {
 public:
  explicit BdfControl(int max_order) : max_order_(max_order) {}

  /// The error of a step, over the tolerance, that is aimed at while the step grows from the first one.
  static double aim_of_start();

  int order() const { return order_; }
  /// Whether the next step should come with the errors at the neighbouring orders; or the one after `ahead` more, if these
  /// are accepted and change neither size nor order.
  bool wants_order_test(int ahead = 0) const { return max_order_ > 1 && (held_ + ahead) % (order_ + 1) == order_; }
  /// Whether that test should have the error at order 2 instead of that at order + 1.
  bool wants_second_order() const { return suspicion_ == Suspicion::of_errors && order_ > 2; }
  /// Whether that test should have the highest quiet order.
  bool wants_quiet_order() const { return suspicion_ == Suspicion::of_modes && order_ > 2; }
  /// The step for which it should be found: the largest of those that did not grow.
  double suspected_dt() const { return suspected_dt_; }
  /// How many of the next steps are likely to have the size and order of the first of them; at most the last is a test of
  /// other orders. A guess, for work that may be done ahead and thrown away.
  int likely_alike() const;
  /// The highest order that may be used next.
  int highest_order() const;
  /// The largest error of a step to be taken. Steps that damp ringing may miss the tolerance by a factor: the error at
  /// order 1 then is what rings, and to lose it is their purpose; shorter steps would not.
  double largest_error() const;
  /// Whether high orders are given up since they would ring.
  bool avoids_ringing() const { return phase_ != Phase::free; }

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
  enum class Suspicion { none, of_errors, of_modes };
  enum class Phase { free, damping, trial, quiet };
  /// The step ratio that brings the error to the one aimed at.
  double ratio_for(double error, int order) const;
  void watch_for_ringing(double dt);

  int max_order_;
  int order_ = 1;
  int held_ = 0;             ///< accepted steps since step or order changed
  int rejections_ = 0;       ///< in a row
  bool is_starting_ = true;  ///< the step has grown whenever it might, since the first one
  double room_ = 0.0;        ///< the step the last error would allow, over the step chosen

  Phase phase_ = Phase::free;
  Suspicion suspicion_ = Suspicion::none;
  int watched_ = 0;  ///< accepted steps since watched_dt_ was the step
  double watched_dt_ = 0.0;
  double largest_dt_ = 0.0;  ///< of the steps watched
  double suspected_dt_ = 0.0;
  int quiet_order_ = 0;      ///< highest order outside of the phase `free`
  int patience_ = 24;        ///< steps without growth before a test for ringing
  int quiet_patience_ = 40;  ///< ... before all orders are allowed again
};

}  // namespace stiffront
