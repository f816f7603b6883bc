// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/coarse_companion.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>

#include "support/diffusion_problem.hpp"

namespace stiffront {
namespace {

using testing::DiffusionProblem;

class NoReaction final : public ReactionSolver {
 public:
  void begin(const Grid&, double, double) override {}
  void run(const CellRun&) override {}
  std::optional<CellFailure> finish(Work&) override { return std::nullopt; }
};

class NoDiffusion final : public Flow {
 public:
  std::optional<CellFailure> advance(double, double, std::span<const Transition>, Work&) override { return std::nullopt; }
};

struct Outcome {
  double error = 0.0;
  int steps = 0;
};

/// A run over [0, 1] whose errors are made up: `grow` says what a step h adds to an error e. Steps are `tolerated` or what the limit leaves of
/// them; the error at the end is to be within 1.
Outcome spend(double tolerated, double c0, const std::function<double(double e, double h)>& grow) {
  Communicator comm(MPI_COMM_SELF);
  DiffusionProblem problem(comm, Grid{1, {8, 1}, {0.0, 0.0}, {1.0, 1.0}}, {}, {1.0}, 2);
  ReactionFlow reaction(problem.decomposition, problem.boundary, std::make_unique<NoReaction>());
  NoDiffusion diffusion;
  const Field u = problem.field();
  CoarseCompanion companion(reaction, diffusion, SplittingOrder::reaction_last, u, 1.0);
  companion.begin(0.0, 1.0, u, 1e-3 * tolerated);
  companion.expect(c0, 0.0);
  Work work;
  Outcome r;
  double t = 0.0;
  double since = 0.0, fine = 0.0, coarse = 0.0;
  while (t < 1.0) {
    if (companion.due()) {
      companion.catch_up(t, work);
      coarse += since * since * since;
      since = 0.0;
      companion.learn(r.error * (coarse / fine - 1.0), true, c0);
    }
    const double h = std::min({tolerated, companion.step_limit(), 1.0 - t});
    r.error += grow(r.error, h);
    t = 1.0 - t <= h ? 1.0 : t + h;
    since += h;
    fine += h * h * h;
    companion.accepted(h);
    ++r.steps;
  }
  return r;
}

TEST(CoarseCompanion, SpendsTheBudgetOnErrorsThatAddUpWithLittleMoreThanTheLeastNumberOfSteps) {
  for (double too_much : {3.0, 10.0, 50.0}) {
    const double h = 1e-3;
    const double rate = too_much / (h * h);
    const Outcome r = spend(h, 5.0 * rate, [&](double, double step) { return rate * step * step * step; });
    EXPECT_LT(r.error, 1.1) << too_much;
    EXPECT_LT(r.steps, 1.25 * std::sqrt(too_much) / h) << too_much;
  }
}

TEST(CoarseCompanion, AnErrorThatIsMadeAtOnceAndStaysCostsNoSteps) {
  // As in BZ waves: proportional to h^2, there within 1/2000 of the run, a third of what it may be.
  const double h = 3e-5;
  const double stays = 0.3 / (h * h);
  const Outcome r = spend(h, 1e4 * stays, [&](double e, double step) { return (stays * step * step - e) * -std::expm1(-step / 1e-4); });
  EXPECT_LT(r.error, 0.31);
  EXPECT_LT(r.steps, 1.05 / h);
}

TEST(CoarseCompanion, GrowthOfOldErrorsCostsNotManySteps) {
  // Made at once, and grown to most of the budget in the first half of the run whatever the steps are.
  const double h = 1e-3;
  double t = 0.0;
  const Outcome r = spend(h, 20.0 / (h * h), [&](double, double step) {
    t += step;
    return t < 0.01 ? 25.0 * step : t < 0.5 ? 1.2 * step : 0.0;
  });
  EXPECT_LT(r.error, 0.9);
  EXPECT_LT(r.steps, 3.6 / h);
}

TEST(CoarseCompanion, FarAboveTheBudgetErrorsThatGoToAndFroDoNotLetTheStepGrow) {
  // Old errors grow to 2.5 budgets between 0.2 and 0.3, then go to and fro. Steps as tolerated would add 30 to them.
  const double h = 1e-3;
  const double rate = 30.0 / (h * h);
  double t = 0.0;
  double added_late = 0.0;
  const auto sway = [](double at) { return at > 0.3 ? 0.4 * std::sin(100.0 * (at - 0.3)) : 0.0; };
  spend(h, rate, [&](double, double step) {
    const double before = t;
    t += step;
    const double added = rate * step * step * step;
    if (t > 0.3) added_late += added;
    return (t > 0.2 && t < 0.3 ? 25.0 * step : 0.0) + added + sway(t) - sway(before);
  });
  EXPECT_LT(added_late, 0.5);
}

TEST(CoarseCompanion, ErrorsThatArePartOfTheBudgetLeaveTheStepAlone) {
  const double h = 1e-3;
  const Outcome r = spend(h, 20.0 / (h * h), [&](double, double step) { return 0.8 / (h * h) * step * step * step; });
  EXPECT_LT(r.steps, 1.1 / h);
}

}  // namespace
}  // namespace stiffront
