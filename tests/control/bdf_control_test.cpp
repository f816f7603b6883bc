// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/bdf_control.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace stiffront {
namespace {

double no_limit(int, double dt) { return dt; }

/// Follows u' = lambda u: errors of the neighbouring orders are powers of the step.
struct Exponential {
  double tolerance = 1e-6;
  double error(int order, double dt) const { return order < 1 || order > 5 ? 1e300 : std::pow(dt, order + 1) / (order + 1) / tolerance; }
};

TEST(BdfControl, SettlesAtAThirdOfTheToleranceAndTheHighestOrderThatPays) {
  BdfControl control(5);
  const Exponential problem;
  double dt = 1e-4;
  for (int n = 0; n < 300; ++n) {
    BdfErrors e;
    e.same = problem.error(control.order(), dt);
    if (control.wants_order_test()) {
      e.lower = problem.error(control.order() - 1, dt);
      e.upper = problem.error(control.order() + 1, dt);
    }
    ASSERT_LE(e.same, 1.0) << "a calm controller has no rejection here, step " << n;
    dt = control.accepted(dt, e, no_limit);
  }
  EXPECT_EQ(control.order(), 5);
  EXPECT_GT(problem.error(5, dt), 0.05);
  EXPECT_LT(problem.error(5, dt), 0.5);
}

TEST(BdfControl, HoldsARaisedStepForOrderPlusOneSteps) {
  BdfControl control(1);
  double dt = 1.0;
  int held = 0;
  for (int n = 0; n < 40; ++n) {
    const double next = control.accepted(dt, {0.01}, no_limit);
    ++held;
    if (next > dt) {
      EXPECT_GE(held, 2);
      EXPECT_LE(next, 3.0 * dt);
      held = 0;
    }
    dt = next;
  }
}

TEST(BdfControl, IgnoresSmallGainsAndLowersTheStepBeforeItIsTooLate) {
  BdfControl control(1);
  for (int n = 0; n < 10; ++n) EXPECT_EQ(control.accepted(1.0, {0.3}, no_limit), 1.0);
  const double lowered = control.accepted(1.0, {0.8}, no_limit);
  EXPECT_LT(lowered, 0.7);
  EXPECT_GT(lowered, 0.5);
}

TEST(BdfControl, ARejectionShortensTheStepMoreTheLargerTheErrorAndThenLowersTheOrder) {
  BdfControl control(5);
  std::vector<double> state = control.state();
  state[0] = 4;
  control.set_state(state);
  EXPECT_LT(control.rejected(1.0, 1.01), 0.9);
  EXPECT_EQ(control.order(), 4);
  EXPECT_DOUBLE_EQ(control.rejected(1.0, 1e30), 0.2);
  EXPECT_EQ(control.order(), 3);
  EXPECT_DOUBLE_EQ(control.rejected(1.0, std::nan("")), 0.2);
  EXPECT_DOUBLE_EQ(control.rejected(1.0, INFINITY), 0.2);
  EXPECT_EQ(control.order(), 1);
  EXPECT_LT(control.rejected(1.0, 2.0), 0.9);
  EXPECT_EQ(control.order(), 1);
}

TEST(BdfControl, NeverExceedsALimitFromOutside) {
  BdfControl control(5);
  double dt = 1.0;
  for (int n = 0; n < 60; ++n) {
    dt = control.accepted(dt, {1e-9, 1e-9, 1e-9}, [](int order, double wanted) { return std::min(wanted, 6.0 / order); });
    EXPECT_LE(dt, 6.0 / control.order());
  }
}

/// Ringing as the control sees it: at orders above 2 the error jumps for steps between 1 and 4, at order 2 it does not.
double ringing_error(int order, double dt) {
  return order > 2 && dt < 4.0 ? std::pow(dt, 20.0) * 0.4 : 0.3 * std::pow(dt / 10.0, order + 1.0);
}

/// Makes n steps; `quiet` is the highest order said not to ring.
double run_ringing(BdfControl& control, int n, int quiet, double second) {
  std::vector<double> state = control.state();
  state[0] = 5;
  control.set_state(state);
  double dt = 0.5;
  for (int k = 0; k < n; ++k) {
    BdfErrors e;
    e.same = ringing_error(control.order(), dt);
    if (control.wants_order_test()) {
      e.upper = 0.01 * e.same;
      e.lower = 10.0;
      if (control.wants_second_order()) e.second = second;
      if (control.wants_quiet_order()) e.quiet_order = quiet;
    }
    dt = e.same > 1.0 ? control.rejected(dt, e.same) : control.accepted(dt, e, no_limit);
  }
  return dt;
}

TEST(BdfControl, GivesUpOrdersThatRingOnceTheyKeepTheStepShort) {
  BdfControl control(5);
  EXPECT_LT(run_ringing(control, 50, 2, 0.5), 1.2);
  BdfControl patient(5);
  EXPECT_GT(run_ringing(patient, 400, 2, 0.5), 5.0);
  BdfControl never_told(5);
  EXPECT_LT(run_ringing(never_told, 400, 5, 0.5), 1.2);
}

TEST(BdfControl, KeepsHighOrdersThatDoNotRingOrPayNevertheless) {
  for (const auto& [quiet, second] : {std::pair{5, 0.5}, std::pair{2, 5.0}}) {
    BdfControl control(5);
    run_ringing(control, 300, quiet, second);
    EXPECT_FALSE(control.avoids_ringing());
    EXPECT_GT(control.order(), 2);
  }
}

TEST(BdfControl, StateRestoresEverything) {
  BdfControl a(5);
  for (int n = 0; n < 7; ++n) a.accepted(1.0, {1e-3, 1e-2, 1e-4}, no_limit);
  BdfControl b(5);
  b.set_state(a.state());
  for (int n = 0; n < 20; ++n) {
    EXPECT_EQ(a.accepted(1.0, {1e-3, 1e-2, 1e-4}, no_limit), b.accepted(1.0, {1e-3, 1e-2, 1e-4}, no_limit));
    EXPECT_EQ(a.order(), b.order());
  }
}

}  // namespace
}  // namespace stiffront
