// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/deferred_correction_control.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <string>
#include <vector>

#include "stiffront/control/deferred_correction_stability.hpp"

namespace stiffront {
namespace {

using Control = DeferredCorrectionControl;
using Verdict = Control::Verdict;

const double infinity = std::numeric_limits<double>::infinity();

std::vector<double> no_limits() { return {infinity, infinity, infinity, infinity, infinity}; }

TEST(DeferredCorrectionStability, LimitsOfThreeStagesAreThoseOfAnIndependentImplementation) {
  const auto limits = deferred_correction_stability_limits(collocation_nodes(NodeFamily::gauss_radau, 3), 6);
  const double expected[] = {infinity, infinity, 54.4, 11.5, 7.8, 6.7, 6.0};
  for (std::size_t k = 0; k < 7; ++k) {
    if (std::isinf(expected[k])) {
      EXPECT_EQ(limits[k], expected[k]) << k;
    } else {
      EXPECT_NEAR(limits[k], expected[k], 0.051) << k;
    }
  }
}

TEST(DeferredCorrectionStability, FarBeyondTheLimitAmplificationGrowsLikeAPower) {
  const CollocationNodes nodes = collocation_nodes(NodeFamily::gauss_radau, 3);
  EXPECT_NEAR(std::abs(deferred_correction_amplification(nodes, 2, -1000.0)), 18.0, 0.5);
  EXPECT_NEAR(std::abs(deferred_correction_amplification(nodes, 3, -1000.0)), 3.7e4, 500.0);
}

TEST(DeferredCorrectionStability, CorrectionsConvergeToTheStabilityFunctionOfRadauIIA) {
  const CollocationNodes nodes = collocation_nodes(NodeFamily::gauss_radau, 3);
  for (const std::complex<double> z : {std::complex<double>(-0.5, 0.0), {-0.3, 0.8}, {0.2, -0.4}}) {
    const std::complex<double> radau = (1.0 + z * (0.4 + z / 20.0)) / (1.0 - z * (0.6 - z * (0.15 - z / 60.0)));
    EXPECT_LT(std::abs(deferred_correction_amplification(nodes, 40, z) - radau), 1e-14);
  }
}

/// Errors exactly as the theory has them: e_k = scale (rate dt)^k dt^(p+1).
struct Model {
  double scale = 1.0;
  double rate = 1.0;
  double p = 1.0;
  Control::Iterate iterate(int k, double dt) const {
    const double first = scale * std::pow(dt, p + 1.0);
    return {std::pow(rate * dt, k) * first, first, 0.0};
  }
};

struct Steps {
  int accepted = 0;
  int rejected = 0;
  int splitting_steps = 0;
  double time = 0.0;
  double dt = 0.0;
};

Steps steps_of(const DeferredCorrectionOptions& options, const Model& model, int attempts, double dt) {
  Control control(options, no_limits());
  Steps r;
  r.dt = dt;
  for (int n = 0; n < attempts; ++n) {
    control.begin(r.dt, 0.0);
    Verdict verdict = Verdict::correct;
    int k = 0;
    for (; verdict == Verdict::correct; ++k) verdict = control.judge(model.iterate(k, r.dt));
    r.splitting_steps += options.stages + (k - 1) * (options.stages - 1);
    (verdict == Verdict::reject ? r.rejected : r.accepted) += 1;
    if (verdict != Verdict::reject) r.time += r.dt;
    r.dt = control.dt_next();
  }
  return r;
}

TEST(DeferredCorrectionControl, ObservedExponentsSettleWithoutRejections) {
  DeferredCorrectionOptions o;
  for (double tolerance : {1e-3, 1e-5, 1e-7, 1e-9}) {
    o.tolerance = tolerance;
    const Steps r = steps_of(o, {1.0, 0.3}, 200, 1e-4);
    EXPECT_EQ(r.rejected, 0) << tolerance;
  }
}

/// Calls f(observed, published, model, name) for both splittings, slow and fast iterations and tolerances between 1e-3 and 1e-9.
template <class Compare>
void for_all_rules(DeferredCorrectionOptions::StepRule rule, Compare&& compare) {
  for (const bool strang : {false, true}) {
    for (const double rate : {0.03, 0.3, 3.0}) {
      for (const double tolerance : {1e-3, 1e-5, 1e-7, 1e-9}) {
        DeferredCorrectionOptions observed;
        observed.strang = strang;
        observed.max_iterations = strang ? 3 : 4;
        observed.tolerance = tolerance;
        observed.step_rule = rule;
        DeferredCorrectionOptions published = observed;
        published.exponent = DeferredCorrectionOptions::Exponent::published;
        const Model model{1.0, rate, strang ? 2.0 : 1.0};
        compare(steps_of(observed, model, 500, 1e-4), steps_of(published, model, 500, 1e-4),
                std::string(strang ? "Strang" : "Lie") + ", rate " + std::to_string(rate) + ", tolerance " +
                    std::to_string(tolerance * 1e9) + "e-9");
      }
    }
  }
}

TEST(DeferredCorrectionControl, TheSameWorkGoesThreePerCentFartherThanWithThePublishedRuleAndLessIsRejected) {
  using Rule = DeferredCorrectionOptions::StepRule;
  for (const Rule rule : {Rule::k, Rule::kmax}) {
    for_all_rules(rule, [](const Steps& ours, const Steps& theirs, const std::string& name) {
      EXPECT_GT(ours.time / ours.splitting_steps, 1.03 * theirs.time / theirs.splitting_steps) << name;
      EXPECT_LE(ours.rejected, theirs.rejected) << name;
    });
  }
}

TEST(DeferredCorrectionControl, WithAllCorrectionsAcceptedStepsAreLongerThanByThePublishedRule) {
  for_all_rules(DeferredCorrectionOptions::StepRule::kmax, [](const Steps& ours, const Steps& theirs, const std::string& name) {
    EXPECT_GT(ours.time / ours.accepted, 1.03 * theirs.time / theirs.accepted) << name;
    EXPECT_GE(ours.accepted, theirs.accepted) << name;
  });
}

TEST(DeferredCorrectionControl, NumbersOfCorrectionsWorthTheSameDoNotTakeTurns) {
  // Where two corrections are worth as much as one, the step must not go up and down between the two.
  DeferredCorrectionOptions o;
  for (double rate = 0.3; rate < 10.0; rate *= 1.1) {
    o.tolerance = 1e-5;
    Control control(o, no_limits());
    double dt = 1e-4, before = 0.0;
    int turns = 0;
    for (int n = 0; n < 200; ++n) {
      control.begin(dt, 0.0);
      Verdict verdict = Verdict::correct;
      for (int k = 0; verdict == Verdict::correct; ++k) {
        // Quotients that grow with the number of the correction and less with the step than they should, as in stiff waves.
        const double first = std::pow(dt, 1.7);
        double e = first;
        for (int j = 1; j <= k; ++j) e *= rate * j * std::pow(dt, 0.7);
        verdict = control.judge({e, first, 0.0});
      }
      if (n > 100 && std::abs(dt / before - 1.0) > 0.1) ++turns;
      before = dt;
      dt = control.dt_next();
    }
    EXPECT_EQ(turns, 0) << rate;
  }
}

TEST(DeferredCorrectionControl, ARejectedPredictionIsFollowedByTheStepForWhichTheNextIsGoodEnough) {
  DeferredCorrectionOptions o;
  o.tolerance = 1e-3;
  Control control(o, no_limits());
  control.begin(0.1, 0.0);
  EXPECT_EQ(control.judge({1.2e-3, 1.2e-3, 0.0}), Verdict::correct);
  EXPECT_EQ(control.judge({2.4e-3, 2.4e-3, 0.0}), Verdict::reject);
  EXPECT_NEAR(control.dt_next(), 0.1 * std::sqrt(0.9e-3 / 1.2e-3), 1e-12);
}

TEST(DeferredCorrectionControl, AfterARejectionTheCorrectionsOfTheLastGoodStepAreTakenAgain) {
  DeferredCorrectionOptions o;
  o.tolerance = 1e-8;
  Control control(o, no_limits());
  // Three corrections were enough for 0.05; with 0.1 the attempt is given up after the first.
  control.begin(0.05, 0.0);
  control.judge({1e-3, 1e-3, 0.0});
  control.judge({2e-5, 1e-3, 0.0});
  control.judge({4e-7, 1e-3, 0.0});
  ASSERT_EQ(control.judge({8e-9, 1e-3, 0.0}), Verdict::accept);
  control.begin(0.1, 0.0);
  control.judge({4e-3, 4e-3, 0.0});
  ASSERT_EQ(control.judge({4e-4, 4e-3, 0.0}), Verdict::reject);
  // Two corrections more bring the error down by 0.1 each, and it goes with the fifth power of the step.
  const double error = 0.1 / 0.9 * 4e-3 * 0.01;
  EXPECT_NEAR(control.dt_next(), 0.1 * std::pow(9e-9 / error, 0.2), 1e-12);
}

TEST(DeferredCorrectionControl, CorrectionsThatDoNotConvergeRejectAStepWhosePredictionIsNotGoodEnough) {
  DeferredCorrectionOptions o;
  o.tolerance = 1e-6;
  Control control(o, no_limits());
  control.begin(0.1, 0.0);
  EXPECT_EQ(control.judge({1e-3, 1e-3, 0.0}), Verdict::correct);
  EXPECT_EQ(control.judge({2e-3, 2e-3, 0.0}), Verdict::reject);
  EXPECT_LE(control.dt_next(), 0.05);
  EXPECT_GT(control.dt_next(), 0.0);
}

TEST(DeferredCorrectionControl, CorrectionsThatDoNotConvergeLeaveAGoodPrediction) {
  DeferredCorrectionOptions o;
  o.tolerance = 1e-2;
  Control control(o, no_limits());
  control.begin(0.1, 0.0);
  EXPECT_EQ(control.judge({1e-3, 1e-3, 0.0}), Verdict::correct);
  EXPECT_EQ(control.judge({2e-1, 2e-1, 0.0}), Verdict::accept_prediction);
  EXPECT_EQ(control.error(), 1e-3);
}

TEST(DeferredCorrectionControl, NumbersThatAreNotFiniteRejectAStep) {
  DeferredCorrectionOptions o;
  Control control(o, no_limits());
  for (double bad : {infinity, std::nan("")}) {
    control.begin(0.1, 0.0);
    EXPECT_EQ(control.judge({bad, 1.0, 0.0}), Verdict::reject);
    EXPECT_EQ(control.dt_next(), 0.05);
  }
}

TEST(DeferredCorrectionControl, StagnationAtRoundOffIsConvergence) {
  DeferredCorrectionOptions o;
  o.tolerance = 1e-12;
  Control control(o, no_limits());
  double dt = 1e-6;
  for (int n = 0; n < 100; ++n) {
    control.begin(dt, 0.0);
    EXPECT_EQ(control.judge({1e-15, 1e-15, 0.0}), Verdict::correct);
    EXPECT_EQ(control.judge({1.1e-15, 1e-15, 0.0}), Verdict::accept);
    EXPECT_GE(control.dt_next(), dt);
    dt = control.dt_next();
  }
  // Exactly 0 leaves no quotients at all.
  control.begin(dt, 0.0);
  EXPECT_EQ(control.judge({0.0, 0.0, 0.0}), Verdict::correct);
  EXPECT_EQ(control.judge({0.0, 0.0, 0.0}), Verdict::accept);
  EXPECT_GE(control.dt_next(), dt);
}

TEST(DeferredCorrectionControl, TheErrorOfTheQuadratureRejectsAStepTheResidualsWouldAccept) {
  DeferredCorrectionOptions o;
  o.tolerance = 1e-8;
  Control control(o, no_limits());
  control.begin(0.1, 0.0);
  control.judge({1e-7, 1e-7, 0.0});
  EXPECT_EQ(control.judge({1e-10, 1e-7, 1e-6}), Verdict::reject);
  // 2 s = 6 powers of the step bring 1e-6 down to half of 1e-8.
  EXPECT_NEAR(control.dt_next(), 0.1 * std::pow(5e-3, 1.0 / 6.0), 1e-12);
}

TEST(DeferredCorrectionControl, TheSplittingAloneFollowsItsOwnError) {
  DeferredCorrectionOptions o;
  o.tolerance = 1e-6;
  o.max_iterations = 0;
  Control control(o, {infinity});
  control.begin(0.1, 0.0);
  EXPECT_EQ(control.judge({4e-6, 4e-6, 0.0}), Verdict::reject);
  EXPECT_NEAR(control.dt_next(), 0.1 * std::sqrt(0.9 / 4.0), 1e-12);
  control.begin(0.05, 0.0);
  EXPECT_EQ(control.judge({9e-7, 9e-7, 0.0}), Verdict::accept);
}

TEST(DeferredCorrectionControl, StepsStayWhereTheirCorrectionsAreStable) {
  DeferredCorrectionOptions o;
  o.predict = false;
  o.tolerance = 1e-4;
  Control control(o, {infinity, infinity, 54.4, 11.5, 7.8});
  // |z| = 20: two corrections are stable, three are not.
  control.begin(0.1, 200.0);
  EXPECT_EQ(control.judge({1e-1, 1e-1, 0.0}), Verdict::correct);
  EXPECT_EQ(control.judge({1e-2, 1e-1, 0.0}), Verdict::correct);
  EXPECT_EQ(control.judge({5e-3, 1e-1, 0.0}), Verdict::reject);
}

TEST(DeferredCorrectionControl, ARejectedStepIsNotTriedAgainAtOnce) {
  DeferredCorrectionOptions o;
  o.tolerance = 1e-4;
  Control control(o, no_limits());
  control.begin(0.1, 0.0);
  control.judge({1e-1, 1e-1, 0.0});
  ASSERT_EQ(control.judge({2e-1, 2e-1, 0.0}), Verdict::reject);
  for (int n = 0; n < 10; ++n) {
    control.begin(0.05, 0.0);
    control.judge({1e-6, 1e-6, 0.0});
    ASSERT_EQ(control.judge({1e-12, 1e-6, 0.0}), Verdict::accept);
    EXPECT_LT(control.dt_next(), 0.1);
  }
}

}  // namespace
}  // namespace stiffront
