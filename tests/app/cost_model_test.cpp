// SPDX-License-Identifier: BSD-3-Clause
#include "../../src/app/cost_model.hpp"

#include <gtest/gtest.h>

namespace stiffront::app {
namespace {

/// Problem A: D = 2.5e-3 on 1001 points, one time unit.
AutoProblem problem_a(double tolerance) { return {tolerance, 1.0, 1e4, 1, 3}; }

bool takes_sdc(const AutoProblem& problem) { return std::holds_alternative<SdcOptions>(choose_method(problem).method); }

TEST(CostModelTest, PredictsTheStepsOfProblemAThatWereCounted) {
  // sbdf is given 0.3 of the tolerance: relative tolerances 1e-6, 1e-8 and 1e-10 took 2908, 7433 and 18070 steps.
  EXPECT_NEAR(predicted_sbdf(problem_a(1e-6 / 0.3)).steps / 2908.0, 1.0, 0.2);
  EXPECT_NEAR(predicted_sbdf(problem_a(1e-8 / 0.3)).steps / 7433.0, 1.0, 0.1);
  EXPECT_NEAR(predicted_sbdf(problem_a(1e-10 / 0.3)).steps / 18070.0, 1.0, 0.1);
  // sdc with four nodes and tolerances 1e-8, 1e-10 and 1e-12: 3182 (diffusion allows no longer ones), 4603 and 9916.
  EXPECT_NEAR(predicted_sdc(problem_a(1e-8 / 0.3), 4).steps / 3182.0, 1.0, 0.2);
  EXPECT_NEAR(predicted_sdc(problem_a(1e-10 / 0.3), 4).steps / 4603.0, 1.0, 0.1);
  EXPECT_NEAR(predicted_sdc(problem_a(1e-12 / 0.3), 4).steps / 9916.0, 1.0, 0.1);
}

TEST(CostModelTest, PredictsTheRoundingOfProblemAThatWasSeen) {
  // 46403 steps of sbdf: 2.7e-12.
  const PredictedWork work = predicted_sbdf(problem_a(1e-12 / 0.3));
  EXPECT_NEAR(work.round_off / 2.7e-12, 1.0, 0.25);
}

TEST(CostModelTest, TakesSbdfWhileItsRoundingLeavesRoomAndSdcBelow) {
  for (double tolerance : {1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-11}) EXPECT_FALSE(takes_sdc(problem_a(tolerance))) << tolerance;
  for (double tolerance : {2e-12, 1e-12}) EXPECT_TRUE(takes_sdc(problem_a(tolerance))) << tolerance;
}

TEST(CostModelTest, DiffusionTooStiffForParallelNodesLeavesSbdf) {
  AutoProblem stiff = problem_a(1e-12);
  stiff.spectral_radius = 1e7;
  EXPECT_FALSE(takes_sdc(stiff));
}

TEST(CostModelTest, SaysWhatItTookAndWhy) {
  EXPECT_NE(choose_method(problem_a(1e-4)).reason.find("sbdf with relative_tolerance = 3e-05: work of"), std::string::npos);
  EXPECT_NE(choose_method(problem_a(1e-12)).reason.find("rounding in some"), std::string::npos);
}

}  // namespace
}  // namespace stiffront::app
