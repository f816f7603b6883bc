// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <functional>
#include <limits>
#include <vector>

namespace stiffront {

/// Errors of a step at its own and the neighbouring orders, relative to the tolerance.
struct BdfErrors {
  double same = 0.0;
  double lower = std::numeric_limits<double>::infinity();  ///< at order - 1; infinite if unknown
  double upper = std::numeric_limits<double>::infinity();  ///< at order + 1; infinite if unknown
};

/// Step size and order of a variable-step, variable-order BDF method, from error estimates alone.
///
/// It aims at a third of the tolerance. A changed step is held for order + 1 steps before it is raised again, and
/// raised only if that gains a fifth; it is lowered at once if the next error would come close to the tolerance. The
/// order with the largest step is taken; it is reconsidered every order + 1 steps.
class BdfControl {
 public:
  explicit BdfControl(int max_order) : max_order_(max_order) {}

  int order() const { return order_; }
  /// Whether the next step should come with the errors at the neighbouring orders.
  bool wants_order_test() const { return max_order_ > 1 && held_ % (order_ + 1) == order_; }

  /// After an accepted step: sets the order and returns the size of the next one.
  /// @param limit (order, dt): the step to make in place of a wanted one for reasons other than accuracy; at most dt
  double accepted(double dt, const BdfErrors& errors, const std::function<double(int, double)>& limit);
  /// After a rejected one. An error that is not finite counts as a step hopelessly too large.
  double rejected(double dt, double error);
  /// Begin again at order 1.
  void restart();

  std::vector<double> state() const;
  void set_state(const std::vector<double>& numbers);

 private:
  int max_order_;
  int order_ = 1;
  int held_ = 0;        ///< accepted steps since step or order changed
  int rejections_ = 0;  ///< in a row
};

}  // namespace stiffront
