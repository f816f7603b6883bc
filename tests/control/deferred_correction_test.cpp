// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/deferred_correction.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "stiffront/control/collocation.hpp"
#include "stiffront/control/cvode.hpp"
#include "stiffront/control/evolve.hpp"
#include "stiffront/core/error.hpp"
#include "stiffront/mesh/field_algebra.hpp"
#include "stiffront/solvers/model_registry.hpp"
#include "support/order_fit.hpp"
#include "support/split_brusselator.hpp"

namespace stiffront {
namespace {

class DeferredCorrectionTest : public testing::SplitBrusselator {
 protected:
  Field evolved(Method& method, double end) {
    Field u = u_.similar();
    u.copy_interior(u_);
    Schedule schedule;
    schedule.end = end;
    Progress progress;
    Observer nobody;
    evolve(method, schedule, u, progress, nobody);
    accepted_ = progress.accepted;
    rejected_ = progress.rejected;
    return u;
  }

  Field reference(double end) {
    Cvode cvode(u_, rhs_, {1e-13, {1e-14, 1e-14}, CvodeOptions::LinearSolver::band});
    return evolved(cvode, end);
  }

  Field fixed(double step, int iterations, bool strang, double end, int stages = 3) {
    DeferredCorrectionOptions o;
    o.fixed_step = step;
    o.iterations = iterations;
    o.strang = strang;
    o.stages = stages;
    DeferredCorrection method(u_, rhs_, reaction_, rock4_, o);
    return evolved(method, end);
  }

  double order(int iterations, bool strang) {
    const Field exact = reference(0.4);
    std::vector<double> h, e;
    for (int n : {10, 20, 40, 80, 160}) {
      const double error = distance(fixed(0.4 / n, iterations, strang, 0.4), exact);
      if (error < 3e-11) continue;  // the inner solvers' floor
      h.push_back(0.4 / n);
      e.push_back(error);
    }
    return testing::observed_order(h, e);
  }

  std::int64_t accepted_ = 0;
  std::int64_t rejected_ = 0;
};

TEST_F(DeferredCorrectionTest, EveryIterationAddsAnOrderToLie) {
  for (int k = 0; k <= 3; ++k) EXPECT_NEAR(order(k, false), 1.0 + k, 0.25) << "k = " << k;
}

TEST_F(DeferredCorrectionTest, EveryIterationAddsAnOrderToStrangUpToTheQuadratures) {
  for (int k = 0; k <= 2; ++k) EXPECT_NEAR(order(k, true), 2.0 + k, 0.3) << "k = " << k;
}

/// One step of Radau IIA, coupled, by fixed-point iteration: converges where |z| is small.
Field radau_iia_step(CoupledRhs& rhs, Field& u, double dt, int stages) {
  const CollocationNodes nodes = collocation_nodes(NodeFamily::gauss_radau, stages);
  std::vector<Field> v, f;
  for (int i = 0; i < stages; ++i) {
    v.push_back(u.similar());
    f.push_back(u.similar());
    v.back().copy_interior(u);
  }
  for (int iteration = 0; iteration < 60; ++iteration) {
    for (std::size_t i = 0; i < v.size(); ++i) rhs.evaluate(nodes.c[i] * dt, v[i], f[i]);
    for (std::size_t i = 0; i < v.size(); ++i) {
      std::vector<Term> terms{{1.0, &u}};
      for (std::size_t j = 0; j < v.size(); ++j) terms.push_back({dt * nodes.s[i][j], &f[j]});
      combine(terms, v[i]);
    }
  }
  Field last = u.similar();
  last.copy_interior(v.back());
  return last;
}

TEST_F(DeferredCorrectionTest, ConvergesToTheRadauIIAStepToRoundOff) {
  // Values are about 3, with units in the last place of 4e-16.
  for (int stages : {2, 3, 4, 5}) {
    const Field exact = radau_iia_step(rhs_, u_, 1e-3, stages);
    for (bool strang : {false, true}) EXPECT_LT(distance(fixed(1e-3, 20, strang, 1e-3, stages), exact), 4e-15) << stages;
  }
}

TEST_F(DeferredCorrectionTest, ResidualsOfItsIteratesFallToRoundOff) {
  DeferredCorrectionOptions o;
  o.fixed_step = 1e-2;
  o.iterations = 20;
  DeferredCorrection method(u_, rhs_, reaction_, rock4_, o);
  const auto estimates = method.estimates(0.0, 1e-2, u_, 20);
  ASSERT_EQ(estimates.size(), 21U);
  EXPECT_LT(estimates.back().residual, 1e-14);
  for (std::size_t k = 1; k <= 4; ++k) {
    EXPECT_LT(estimates[k].error, estimates[k - 1].error);
    EXPECT_GT(estimates[k].step_limit, 1e-2);
  }
}

TEST_F(DeferredCorrectionTest, MoreStagesHaveAHigherQuadratureOrder) {
  const Field exact = reference(0.4);
  // With enough corrections the quadrature decides: order 3 for two stages, 5 for three.
  EXPECT_GT(distance(fixed(0.01, 5, true, 0.4, 2), exact), 20.0 * distance(fixed(0.01, 5, true, 0.4, 3), exact));
}

TEST_F(DeferredCorrectionTest, AdaptiveErrorsFollowTheTolerance) {
  const Field exact = reference(1.0);
  double before = 1.0;
  // The estimate sees how far the iteration is from collocation, not collocation's own error, which is below 1e-7 here.
  for (double tolerance : {1e-3, 1e-4, 1e-5, 1e-6}) {
    DeferredCorrectionOptions o;
    o.tolerance = tolerance;
    DeferredCorrection method(u_, rhs_, reaction_, rock4_, o);
    const double e = distance(evolved(method, 1.0), exact);
    EXPECT_LT(e, 10.0 * tolerance * std::sqrt(static_cast<double>(accepted_)) * 3.0) << tolerance;
    EXPECT_LT(e, before) << tolerance;
    EXPECT_LE(rejected_, accepted_ / 6 + 2) << tolerance;
    before = e;
  }
}

/// The wave of Belousov and Zhabotinsky with fixed steps and so many corrections: what the error says.
std::string refusal_of_wave(const Decomposition& decomposition, const Boundary& boundary, double step, int iterations) {
  ModelRegistry registry;
  register_builtin_models(registry);
  const auto stiff = registry.make("bz", {});
  const DiffusionOperator diffusion(decomposition.grid(), boundary, {2.5e-3, 2.5e-3, 1.5e-3}, 2);
  CoupledRhs rhs(decomposition, diffusion, *stiff);
  Field u(decomposition, 3, 1);
  stiff->initialise("bz-front", u);
  ReactionFlow reaction(decomposition, boundary, stiff->make_radau5({1e-8, {1e-8, 1e-8, 1e-8}}));
  Rock4 rock4(decomposition, diffusion, {1e-8, {1e-8, 1e-8, 1e-8}});
  DeferredCorrectionOptions o;
  o.fixed_step = step;
  o.iterations = iterations;
  DeferredCorrection method(u, rhs, reaction, rock4, o);
  Schedule schedule;
  schedule.end = 1.0;
  Progress progress;
  Observer nobody;
  try {
    evolve(method, schedule, u, progress, nobody);
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::numerics);
    return e.what();
  }
  return "none";
}

TEST_F(DeferredCorrectionTest, AFixedStepBeyondTheLimitIsAnErrorThatNamesIt) {
  EXPECT_NE(refusal_of_wave(decomposition_, boundary_, 5e-3, 4).find("limit of stability is |z| = 7.8"), std::string::npos);
}

TEST_F(DeferredCorrectionTest, ASingleCorrectionAsLargeAsTheSolutionIsAnError) {
  EXPECT_NE(refusal_of_wave(decomposition_, boundary_, 0.5, 1).find("far from improving anything"), std::string::npos)
      << refusal_of_wave(decomposition_, boundary_, 0.5, 1);
  EXPECT_EQ(refusal_of_wave(decomposition_, boundary_, 0.5, 0), "none");
}

TEST_F(DeferredCorrectionTest, OscillatingModesThatDivergeWithinTheLimitOfDecayingOnesAreAnErrorToo) {
  ModelRegistry registry;
  register_builtin_models(registry);
  const auto oscillator = registry.make("slaved-oscillator", {{"damping", 1.0}, {"omega", 200.0}});
  const DiffusionOperator diffusion(decomposition_.grid(), boundary_, {1e-3, 0.0, 0.0}, 2);
  CoupledRhs rhs(decomposition_, diffusion, *oscillator);
  Field u(decomposition_, 3, 1);
  oscillator->initialise("slaved-oscillator-front", u);
  for (int i = 0; i < u.n_x(); ++i) u.at(1, i) += 0.1;
  ReactionFlow reaction(decomposition_, boundary_, oscillator->make_radau5({1e-8, {1e-8, 1e-8, 1e-8}}));
  Rock4 rock4(decomposition_, diffusion, {1e-8, {1e-8, 1e-8, 1e-8}});
  DeferredCorrectionOptions o;
  o.fixed_step = 5.0 / 200.0;  // |z| = 5, below the 7.8 of modes that decay
  o.iterations = 4;
  DeferredCorrection method(u, rhs, reaction, rock4, o);
  Schedule schedule;
  schedule.end = 10.0;
  Progress progress;
  Observer nobody;
  EXPECT_THROW(evolve(method, schedule, u, progress, nobody), Error);
}

TEST_F(DeferredCorrectionTest, CorrectionsLargerThanTheSolutionAreAnErrorAlsoIfTheyShrink) {
  // Two corrections of a mode that turns by 32: within the limit of modes that decay, 54, the second one is smaller, and both are hundreds of solutions.
  ModelRegistry registry;
  register_builtin_models(registry);
  const auto turning = registry.make("dahlquist", {});
  const DiffusionOperator diffusion(decomposition_.grid(), boundary_, {0.0, 0.0}, 2);
  CoupledRhs rhs(decomposition_, diffusion, *turning);
  Field u(decomposition_, 2, 1);
  turning->initialise("dahlquist-uniform", u);
  ReactionFlow reaction(decomposition_, boundary_, turning->make_radau5({1e-8, {1e-8, 1e-8}}));
  Rock4 rock4(decomposition_, diffusion, {1e-8, {1e-8, 1e-8}});
  DeferredCorrectionOptions o;
  o.fixed_step = 5.1;
  o.iterations = 2;
  DeferredCorrection method(u, rhs, reaction, rock4, o);
  Schedule schedule;
  schedule.end = 5.1;
  Progress progress;
  Observer nobody;
  EXPECT_THROW(evolve(method, schedule, u, progress, nobody), Error);
}

}  // namespace
}  // namespace stiffront
