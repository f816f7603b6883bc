// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/adaptive_strang.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "stiffront/control/cvode.hpp"
#include "stiffront/control/evolve.hpp"
#include "stiffront/control/travelling_wave.hpp"
#include "stiffront/model/builtin/kpp.hpp"
#include "stiffront/solvers/model_kernels.hpp"
#include "stiffront/solvers/rock4.hpp"
#include "support/diffusion_problem.hpp"
#include "support/order_fit.hpp"
#include "support/stored_state.hpp"

namespace stiffront {
namespace {

using testing::DiffusionProblem;
using testing::StoredState;

constexpr double inner_tolerance = 1e-13;

/// The KPP wave with k = D = 1 in the middle of [-30, 30], and the two flows far more exact than their splitting.
struct KppWave {
  explicit KppWave(int points = 1201)
      : comm(MPI_COMM_SELF),
        problem(comm, Grid{1, {points, 1}, {-30.0, 0.0}, {30.0, 1.0}}, {}, {1.0}, 2),
        model({{"k", 1.0}}),
        reaction(problem.decomposition, problem.boundary, model.make_radau5({inner_tolerance, {inner_tolerance}})),
        diffusion(problem.decomposition, problem.diffusion, Rock4Tolerances{inner_tolerance, {inner_tolerance}}),
        u(problem.field()) {
    model.initialise("kpp-front", u);
  }

  std::unique_ptr<AdaptiveStrang> method(const AdaptiveStrangOptions& options) {
    return std::make_unique<AdaptiveStrang>(u, problem.boundary, model, reaction, diffusion, options);
  }
  Field copy() const {
    Field v = u.similar();
    v.copy_interior(u);
    return v;
  }
  Field split(const Composition& composition, double dt) {
    Field v = u.similar();
    Work work;
    advance({&reaction, &diffusion}, composition, 0.0, dt, u, v, work);
    return v;
  }
  /// By a coupled solver with tight tolerances.
  Field exact(double dt) {
    CoupledRhs rhs(problem.decomposition, problem.diffusion, model);
    Field v = copy();
    CvodeOptions options;
    options.relative_tolerance = 1e-12;
    options.absolute_tolerance = {1e-14};
    options.linear_solver = CvodeOptions::LinearSolver::band;
    Cvode cvode(v, rhs, options);
    Schedule schedule;
    schedule.end = dt;
    Progress progress;
    Observer nobody;
    evolve(cvode, schedule, v, progress, nobody);
    return v;
  }
  /// L2 norm on the line.
  double distance(const Field& a, const Field& b) const {
    double sum = 0.0;
    for (int i = 0; i < a.n_x(); ++i) sum += (a.at(0, i) - b.at(0, i)) * (a.at(0, i) - b.at(0, i));
    return std::sqrt(sum * problem.grid.spacing(0));
  }
  /// From the norm of the methods, root mean square over maximum, to the L2 norm; the maximum is 1.
  double l2_from_rms() const { return std::sqrt(static_cast<double>(u.n_x()) * problem.grid.spacing(0)); }

  Communicator comm;
  DiffusionProblem problem;
  ModelKernelsOf<Kpp> model;
  ReactionFlow reaction;
  Rock4 diffusion;
  Field u;
};

TEST(AdaptiveStrang, LocalOrdersAreThreeAndTwoAndTheDistanceIsProportionalToEpsilon) {
  for (SplittingOrder order : {SplittingOrder::reaction_last, SplittingOrder::diffusion_last}) {
    KppWave wave;
    std::vector<double> steps{0.02, 0.04, 0.08};
    std::vector<double> strang_errors, shifted_errors, distances;
    for (double dt : steps) {
      const Field exact = wave.exact(dt);
      const Field v = wave.split(strang(order), dt);
      const Field w = wave.split(shifted_strang(order, 0.05), dt);
      strang_errors.push_back(wave.distance(exact, v));
      shifted_errors.push_back(wave.distance(exact, w));
      distances.push_back(wave.distance(v, w));
    }
    EXPECT_NEAR(testing::observed_order(steps, strang_errors), 3.0, 0.05);
    EXPECT_NEAR(testing::observed_order(steps, shifted_errors), 2.0, 0.05);
    EXPECT_NEAR(testing::observed_order(steps, distances), 2.0, 0.05);

    std::vector<double> shifts{0.001, 0.01, 0.1};
    distances.clear();
    for (double epsilon : shifts) {
      distances.push_back(wave.distance(wave.split(strang(order), 0.02), wave.split(shifted_strang(order, epsilon), 0.02)));
    }
    EXPECT_NEAR(testing::observed_order(shifts, distances), 1.0, 0.05);

    // The leading constants are those of the theory.
    const SplittingConstants c = kpp_splitting_constants();
    if (order == SplittingOrder::reaction_last) {
      EXPECT_NEAR(strang_errors[0], c.m2 * std::pow(0.02, 3), 0.02 * strang_errors[0]);
    }
    EXPECT_NEAR(distances[1], c.m1 * 0.01 * 0.02 * 0.02, 0.02 * distances[1]);
  }
}

TEST(AdaptiveStrang, EstimatesTheConstantsAndTheCriticalStepOfTheTheory) {
  const SplittingConstants c = kpp_splitting_constants();
  for (double epsilon : {0.05, 0.005}) {
    KppWave wave;
    AdaptiveStrangOptions options;
    options.epsilon = epsilon;
    const auto method = wave.method(options);
    Field v = wave.u.similar();
    std::uint64_t flags = 0;
    const Attempt a = method->attempt(0.0, 0.02, wave.u, v, flags);
    EXPECT_TRUE(a.accepted);
    EXPECT_NEAR(method->c0() * wave.l2_from_rms(), c.m2, 0.02 * c.m2);
    EXPECT_NEAR(method->c_epsilon() * wave.l2_from_rms(), c.m1, 0.02 * c.m1);
    EXPECT_NEAR(method->critical_dt(), options.critical_safety * critical_splitting_step(c, epsilon, 1.0), 0.02 * method->critical_dt());
    EXPECT_EQ(a.critical_dt, method->critical_dt());
    EXPECT_EQ(method->epsilon(), epsilon) << "nothing has been accepted yet";
  }
}

TEST(AdaptiveStrang, TheErrorOfAnAttemptIsTheDistanceToTheEmbeddedScheme) {
  KppWave wave;
  AdaptiveStrangOptions options;
  options.critical_step = false;
  options.epsilon = 0.2;
  const auto method = wave.method(options);
  Field v = wave.u.similar();
  std::uint64_t flags = 0;
  const Attempt a = method->attempt(0.0, 0.1, wave.u, v, flags);
  const Field expected = wave.split(strang(SplittingOrder::reaction_last), 0.1);
  const Field w = wave.split(shifted_strang(SplittingOrder::reaction_last, 0.2), 0.1);
  EXPECT_NEAR(a.error * wave.l2_from_rms(), wave.distance(expected, w), 1e-11);
  EXPECT_LT(wave.distance(v, expected), 1e-12);
}

TEST(AdaptiveStrang, ARejectedAttemptLeavesTheStateAlone) {
  for (bool critical : {false, true}) {
    KppWave wave;
    AdaptiveStrangOptions options;
    options.tolerance = 1e-7;
    options.critical_step = critical;
    const auto method = wave.method(options);
    const Field before = wave.copy();
    Field v = wave.u.similar();
    std::uint64_t flags = 0;
    const Attempt a = method->attempt(0.0, 1.0, wave.u, v, flags);
    EXPECT_FALSE(a.accepted);
    EXPECT_LT(a.dt_next, 1.0);
    EXPECT_FALSE(a.reason.empty());
    for (int i = 0; i < before.n_x(); ++i) ASSERT_EQ(wave.u.at(0, i), before.at(0, i));
  }
}

TEST(AdaptiveStrang, AStepBeyondTheCriticalOneIsRejectedHoweverSmallItsError) {
  KppWave wave;
  AdaptiveStrangOptions options;
  options.tolerance = 1.0;
  options.epsilon = options.epsilon_max = 1e-3;  // dt* = 0.02
  const auto method = wave.method(options);
  Field v = wave.u.similar();
  std::uint64_t flags = 0;
  const Attempt a = method->attempt(0.0, 0.2, wave.u, v, flags);
  EXPECT_FALSE(a.accepted);
  EXPECT_NEAR(a.critical_dt, options.critical_safety * critical_splitting_step(kpp_splitting_constants(), 1e-3, 1.0), 0.1 * a.critical_dt);
  EXPECT_LE(a.dt_next, a.critical_dt);
}

TEST(AdaptiveStrang, EpsilonPutsTheStepIntoTheWorkingRegion) {
  for (double tolerance : {1e-4, 1e-6, 1e-8}) {
    KppWave wave(601);
    AdaptiveStrangOptions options;
    options.tolerance = tolerance;
    options.initial_step = 1e-3;
    const auto method = wave.method(options);
    Schedule schedule;
    schedule.end = tolerance > 1e-5 ? 10.0 : 0.5;
    Progress progress;
    Observer nobody;
    evolve(*method, schedule, wave.u, progress, nobody);
    const double epsilon = method->epsilon();
    const double dt = std::sqrt(tolerance / (epsilon * method->c_epsilon()));
    EXPECT_LE(epsilon, options.epsilon_max);
    EXPECT_TRUE(epsilon == options.epsilon_max || 0.8 * dt < method->critical_dt()) << tolerance;
    // beta keeps it from being far too large, up to the changes between two estimates
    EXPECT_GT(dt, 0.5 * options.beta * method->critical_dt()) << tolerance;
  }
}

TEST(AdaptiveStrang, DifferencesTheFlowsMayHaveMadeDoNotCountAsSplittingErrors) {
  KppWave wave;
  AdaptiveStrangOptions options;
  options.tolerance = 1e-5;
  options.inner_tolerance = 1e-7;  // reached by the Strang error of a step of about 0.08
  const auto method = wave.method(options);
  Field v = wave.u.similar();
  std::uint64_t flags = 0;
  double estimated_from = 0.0;
  double dt = 1e-3;
  for (double t = 0.0; estimated_from == 0.0 && dt < 1.0;) {
    const Attempt a = method->attempt(t, dt, wave.u, v, flags);
    ASSERT_TRUE(a.accepted);
    method->accept(wave.u, v);
    if (method->c0() > 0.0) {
      estimated_from = dt;
    } else {
      EXPECT_GE(method->critical_dt(), 2.0 * dt) << "the step may grow";
    }
    t += dt;
    dt = std::min(a.dt_next, 2.0 * dt);
  }
  EXPECT_GT(estimated_from, 0.05);
  EXPECT_LT(estimated_from, 0.2) << "estimates are repeated as the step grows";
  EXPECT_NEAR(method->c0() * wave.l2_from_rms(), kpp_splitting_constants().m2, 0.1 * kpp_splitting_constants().m2);
}

TEST(AdaptiveStrang, SmallDifferencesThatAreCubicLowerTheConstantOfTheStrangErrorAndDoNotRaiseIt) {
  KppWave wave;
  const Field steep = wave.copy();
  Field low = wave.copy();
  for (int i = 0; i < low.n_x(); ++i) low.at(0, i) *= 0.2;
  AdaptiveStrangOptions options;
  options.tolerance = 1e-2;
  options.period = 1;
  Field v = wave.u.similar();
  std::uint64_t flags = 0;
  const auto c0_after = [&](AdaptiveStrang& method, const Field& state, double dt) {
    wave.u.copy_interior(state);
    EXPECT_TRUE(method.attempt(0.0, dt, wave.u, v, flags).accepted);
    method.accept(wave.u, v);
    return method.c0();
  };
  const double c0_low = c0_after(*wave.method(options), low, 0.02);
  options.inner_tolerance = 1e-7;  // above the Strang error of a step of 0.02
  const auto method = wave.method(options);
  ASSERT_GT(c0_after(*method, steep, 0.5), 2.0 * c0_low);
  EXPECT_NEAR(c0_after(*method, low, 0.02), c0_low, 0.05 * c0_low);
  EXPECT_NEAR(c0_after(*method, steep, 0.02), c0_low, 0.05 * c0_low);
}

TEST(AdaptiveStrang, GrowthOfTheStepIsLimited) {
  KppWave wave;
  AdaptiveStrangOptions options;
  options.max_growth = 3.0;
  options.critical_step = false;
  const auto method = wave.method(options);
  Field v = wave.u.similar();
  std::uint64_t flags = 0;
  const Attempt a = method->attempt(0.0, 1e-4, wave.u, v, flags);
  EXPECT_TRUE(a.accepted);
  EXPECT_EQ(a.dt_next, 3.0 * 1e-4);
}

TEST(AdaptiveStrang, ARestartedMethodIsAsGoodAsNew) {
  KppWave wave;
  AdaptiveStrangOptions options;
  options.tolerance = 1e-7;
  options.initial_step = 1e-2;
  const auto used = wave.method(options);
  const auto fresh = wave.method(options);
  Field v = wave.u.similar();
  std::uint64_t flags = 0;
  const Field before = wave.copy();
  double dt = 1e-2;
  for (int n = 0; n < 12; ++n) {
    const Attempt a = used->attempt(0.0, dt, wave.u, v, flags);
    if (a.accepted) used->accept(wave.u, v);
    dt = a.dt_next;
  }
  ASSERT_NE(used->epsilon(), options.epsilon);
  used->restart(0.0);
  EXPECT_EQ(used->epsilon(), options.epsilon);
  EXPECT_TRUE(std::isinf(used->critical_dt()));
  wave.u.copy_interior(before);
  const Attempt a = used->attempt(0.0, 1e-2, wave.u, v, flags);
  wave.u.copy_interior(before);
  const Attempt b = fresh->attempt(0.0, 1e-2, wave.u, v, flags);
  EXPECT_EQ(a.accepted, b.accepted);
  // The inner solvers remember their steps, so that the bits may differ.
  EXPECT_NEAR(a.error, b.error, 1e-6 * b.error);
  EXPECT_NEAR(used->c0(), fresh->c0(), 1e-2 * fresh->c0());
}

/// Multiplies every cell by exp(-dt) and notes for how long.
class CountedReaction final : public ReactionSolver {
 public:
  explicit CountedReaction(double& time) : time_(&time) {}
  void begin(const Grid&, double, double dt) override {
    EXPECT_GE(dt, 0.0) << "a flow runs backwards";
    *time_ += dt;
    dt_ = dt;
  }
  void run(const CellRun& cells) override {
    for (int i = 0; i < cells.n; ++i) cells.to[i] = cells.from[i] * std::exp(-dt_);
  }
  std::optional<CellFailure> finish(Work&) override { return std::nullopt; }

 private:
  double* time_;
  double dt_ = 0.0;
};

/// du_i/dt = -i u_i.
class CountedDiffusion final : public Flow {
 public:
  std::optional<CellFailure> advance(double, double dt, std::span<const Transition> states, Work&) override {
    ++calls;
    time += dt;
    together = std::max(together, states.size());
    for (const Transition& s : states) {
      for (int i = 0; i < s.from->n_x(); ++i) s.to->at(0, i) = s.from->at(0, i) * std::exp(-dt * i);
    }
    return std::nullopt;
  }
  int calls = 0;
  double time = 0.0;
  std::size_t together = 0;
};

TEST(AdaptiveStrang, AnAttemptCostsOneAndAHalfStepsOfReactionAndOneSweepOfDiffusionForTwoStates) {
  KppWave wave(11);
  for (SplittingOrder order : {SplittingOrder::reaction_last, SplittingOrder::diffusion_last}) {
    for (bool critical : {false, true}) {
      double reaction_time = 0.0;
      ReactionFlow reaction(wave.problem.decomposition, wave.problem.boundary, std::make_unique<CountedReaction>(reaction_time));
      CountedDiffusion diffusion;
      AdaptiveStrangOptions options;
      options.critical_step = critical;
      options.order = order;
      options.tolerance = 1e9;
      options.period = 4;
      AdaptiveStrang method(wave.u, wave.problem.boundary, wave.model, reaction, diffusion, options);
      Field v = wave.u.similar();
      std::uint64_t flags = 0;
      const double dt = 1e-3;
      for (int n = 0; n < 9; ++n) {
        reaction_time = diffusion.time = 0.0;
        diffusion.calls = 0;
        diffusion.together = 0;
        const std::int64_t reductions = wave.comm.reductions();
        const Attempt a = method.attempt(n * dt, dt, wave.u, v, flags);
        EXPECT_EQ(wave.comm.reductions() - reductions, 1) << "one agreement per attempt";
        ASSERT_TRUE(a.accepted) << a.reason;
        method.accept(wave.u, v);
        // An estimate adds Strang steps over 1/10, 2/5, 1/2 and 1/2 of the step.
        const bool estimates = critical && n % 4 == 0;
        const double extra = estimates ? 1.5 * dt : 0.0;
        if (order == SplittingOrder::reaction_last) {
          EXPECT_NEAR(reaction_time, 1.5 * dt + extra, 1e-15) << n;
          EXPECT_NEAR(diffusion.time, dt + extra, 1e-15) << n;
          EXPECT_EQ(diffusion.calls, estimates ? 5 : 1);
          EXPECT_EQ(diffusion.together, 2U) << "the two schemes share their sweeps";
        } else {
          EXPECT_NEAR(reaction_time, 2.0 * dt + extra, 1e-15) << n;
          EXPECT_NEAR(diffusion.time, 1.5 * dt + extra, 1e-15) << n;
        }
      }
    }
  }
}

/// Final error of a run, root mean square (the maximum is 1), the method's own estimate of it, and the steps.
struct FinalError {
  double measured = 0.0;
  double estimated = 0.0;
  std::int64_t steps = 0;
};

FinalError final_error(double tolerance, double allowed, double end, Field* result = nullptr) {
  KppWave wave(601);
  const Field exact = wave.exact(end);
  AdaptiveStrangOptions options;
  options.tolerance = tolerance;
  options.final_error = allowed;
  const auto method = wave.method(options);
  Schedule schedule;
  schedule.end = end;
  Progress progress;
  Observer nobody;
  evolve(*method, schedule, wave.u, progress, nobody);
  Work work;
  const std::optional<double> estimate = method->final_error(progress.t, wave.u, work);
  EXPECT_EQ(estimate.has_value(), allowed > 0.0);
  if (result != nullptr) result->copy_interior(wave.u);
  return {wave.distance(exact, wave.u) / wave.l2_from_rms(), estimate.value_or(0.0), progress.accepted};
}

TEST(AdaptiveStrang, EstimatesTheErrorAtTheEnd) {
  for (double tolerance : {1e-4, 1e-5, 1e-6}) {
    const FinalError e = final_error(tolerance, 1e3, 10.0);
    EXPECT_NEAR(e.estimated, e.measured, 0.15 * e.measured) << tolerance;
  }
}

TEST(AdaptiveStrang, KeepsTheErrorAtTheEndWhereErrorsOfStepsAddUp) {
  const FinalError free = final_error(1e-5, 1e3, 15.0);
  ASSERT_GT(free.measured, 1.5e-5) << "there is something to keep";
  const FinalError kept = final_error(1e-5, 1.0, 15.0);
  EXPECT_LT(kept.measured, 1.5e-5);
  EXPECT_GT(kept.steps, free.steps);
  EXPECT_LT(static_cast<double>(kept.steps), 3.0 * std::sqrt(free.measured / kept.measured) * static_cast<double>(free.steps))
      << "the error falls with the square of the step";
}

TEST(AdaptiveStrang, ByDefaultTheErrorAtTheEndFallsLikeThreeTolerancesAndBelowLikeThePowerTwoThirds) {
  for (double tolerance : {1e-2, 1e-4, 1e-6, 3e-7}) EXPECT_EQ(default_final_error(tolerance), 3.0) << tolerance;
  EXPECT_NEAR(1e-8 * default_final_error(1e-8) / (1e-11 * default_final_error(1e-11)), 100.0, 1e-9);
  EXPECT_LT(default_final_error(1e-8), 10.0);
  EXPECT_NEAR(default_final_error(2.96e-7), 3.0, 0.01) << "no jump";
}

TEST(AdaptiveStrang, TheSecondSolutionLeavesStepsOfTheSameSizeAlone) {
  KppWave wave(601);
  AdaptiveStrangOptions options;
  options.initial_step = 0.1;
  const auto without = wave.method(options);
  const Field before = wave.copy();
  Field v = wave.u.similar();
  const auto go = [&](AdaptiveStrang& method) {
    wave.u.copy_interior(before);
    method.first_step(0.0, 10.0, wave.u);
    std::uint64_t flags = 0;
    for (int n = 0; n < 12; ++n) {
      EXPECT_TRUE(method.attempt(0.1 * n, 0.1, wave.u, v, flags).accepted);
      method.accept(wave.u, v);
    }
    return wave.copy();
  };
  // Inner solvers remember their last steps: the first run is for the second and third to begin alike.
  go(*without);
  const std::vector<double> diffusion_state = wave.diffusion.state();
  const Field expected = go(*wave.method(options));
  wave.diffusion.set_state(diffusion_state);
  options.final_error = 1e3;
  const Field measured = go(*wave.method(options));
  for (int i = 0; i < measured.n_x(); ++i) ASSERT_EQ(measured.at(0, i), expected.at(0, i));
}

TEST(AdaptiveStrang, TheFirstStepIsSmallWhereItsErrorsCouldAddUp) {
  KppWave wave(601);
  AdaptiveStrangOptions options;
  options.tolerance = 1e-6;
  options.final_error = 1.0;
  const auto method = wave.method(options);
  const double end = 1000.0;
  const double first = method->first_step(0.0, end, wave.u);
  Field v = wave.u.similar();
  std::uint64_t flags = 0;
  const Attempt a = method->attempt(0.0, first, wave.u, v, flags);
  ASSERT_GT(method->c0(), 0.0);
  const double adds_up_to_the_budget = std::sqrt(1e-6 / (end * method->c0()));
  ASSERT_GT(first, 2.0 * adds_up_to_the_budget);
  EXPECT_FALSE(a.accepted);
  EXPECT_NEAR(a.dt_next, adds_up_to_the_budget, 1e-12 * a.dt_next);
}

TEST(AdaptiveStrang, GoesOnBitwiseFromAStoredState) {
  AdaptiveStrangOptions options;
  options.tolerance = 1e-6;
  options.final_error = 0.1;
  options.initial_step = 1e-2;
  struct StopAfter final : Observer {
    explicit StopAfter(std::int64_t n) : last(n) {}
    bool carry_on(std::uint64_t, std::int64_t step, double, double, Field&) override { return step < last; }
    std::int64_t last;
  };
  const auto go = [](Method& m, Field& u, Progress& p, int last) {
    Schedule schedule;
    schedule.end = 100.0;
    StopAfter stop(last);
    evolve(m, schedule, u, p, stop);
  };
  KppWave whole(301), other(301);
  const auto uninterrupted = whole.method(options);
  Progress p;
  for (int at : {1, 7, 13}) {
    go(*uninterrupted, whole.u, p, at);
    StoredState state;
    state.save(*uninterrupted);
    other.u.copy_interior(whole.u);
    Progress q = p;
    const auto resumed = other.method(options);
    state.load(*resumed);
    go(*resumed, other.u, q, at + 6);
    go(*uninterrupted, whole.u, p, at + 6);
    EXPECT_EQ(q.t, p.t);
    EXPECT_EQ(resumed->epsilon(), uninterrupted->epsilon());
    for (int i = 0; i < whole.u.n_x(); ++i) ASSERT_EQ(other.u.at(0, i), whole.u.at(0, i));
  }
}

}  // namespace
}  // namespace stiffront
