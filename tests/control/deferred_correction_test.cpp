// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/deferred_correction.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "stiffront/control/cvode.hpp"
#include "stiffront/control/evolve.hpp"
#include "stiffront/core/error.hpp"
#include "stiffront/mesh/field_algebra.hpp"
#include "stiffront/solvers/model_registry.hpp"
#include "stiffront/solvers/rock4.hpp"
#include "support/order_fit.hpp"

namespace stiffront {
namespace {

/// The Brusselator on a line, smooth data, with inner solvers far finer than the errors measured. Diffusion is strong enough for the
/// splitting error to stand above the quadrature's.
class DeferredCorrectionTest : public ::testing::Test {
 protected:
  DeferredCorrectionTest()
      : comm_(MPI_COMM_SELF),
        decomposition_(comm_, Grid{1, {33, 1}}, {1, 1}, 1),
        boundary_(Boundary::natural(decomposition_.grid())),
        model_(make_model()),
        diffusion_(decomposition_.grid(), boundary_, {0.05, 0.025}, 2),
        rhs_(decomposition_, diffusion_, *model_),
        reaction_(decomposition_, boundary_, model_->make_radau5({1e-13, {1e-13, 1e-13}})),
        rock4_(decomposition_, diffusion_, {1e-13, {1e-13, 1e-13}}),
        u_(decomposition_, 2, 1) {
    for (int i = 0; i < u_.n_x(); ++i) {
      const double x = decomposition_.grid().position(0, i);
      u_.at(0, i) = 1.0 + 0.5 * std::cos(M_PI * x);
      u_.at(1, i) = 3.0 + 0.5 * std::cos(2 * M_PI * x);
    }
  }

  static std::unique_ptr<ModelKernels> make_model() {
    ModelRegistry registry;
    register_builtin_models(registry);
    return registry.make("brusselator", {{"A", 1.0}, {"B", 3.0}});
  }

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

  static double distance(const Field& a, const Field& b) {
    double e = 0.0;
    for (int s = 0; s < 2; ++s) {
      for (int i = 0; i < a.n_x(); ++i) e = std::max(e, std::abs(a.at(s, i) - b.at(s, i)));
    }
    return e;
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

  Communicator comm_;
  Decomposition decomposition_;
  Boundary boundary_;
  std::unique_ptr<ModelKernels> model_;
  DiffusionOperator diffusion_;
  CoupledRhs rhs_;
  ReactionFlow reaction_;
  Rock4 rock4_;
  Field u_;
  std::int64_t accepted_ = 0;
  std::int64_t rejected_ = 0;
};

TEST_F(DeferredCorrectionTest, EveryIterationAddsAnOrderToLie) {
  for (int k = 0; k <= 3; ++k) EXPECT_NEAR(order(k, false), 1.0 + k, 0.25) << "k = " << k;
}

TEST_F(DeferredCorrectionTest, EveryIterationAddsAnOrderToStrangUpToTheQuadratures) {
  for (int k = 0; k <= 2; ++k) EXPECT_NEAR(order(k, true), 2.0 + k, 0.3) << "k = " << k;
}

TEST_F(DeferredCorrectionTest, ConvergesToTheRadauIIAStep) {
  // The residual of the collocation equations: the last iterate differs from its own quadrature by round-off only.
  DeferredCorrectionOptions o;
  o.tolerance = 1e-30;
  o.max_iterations = 40;
  o.initial_step = 1e-2;
  o.predict = false;
  DeferredCorrection method(u_, rhs_, reaction_, rock4_, o);
  Field u = u_.similar();
  u.copy_interior(u_);
  Field u_new = u_.similar();
  method.first_step(0.0, 1.0, u);
  std::uint64_t flags = 0;
  method.attempt(0.0, 1e-2, u, u_new, flags);
  ASSERT_GT(method.error_estimates().size(), 5U);
  double least = 1.0;
  for (double e : method.error_estimates()) least = std::min(least, e);
  EXPECT_LT(least, 1e-14);
}

TEST_F(DeferredCorrectionTest, MoreStagesHaveAHigherQuadratureOrder) {
  const Field exact = reference(0.4);
  // With enough corrections the quadrature decides: order 3 for two stages, 5 for three.
  EXPECT_GT(distance(fixed(0.02, 5, true, 0.4, 2), exact), 20.0 * distance(fixed(0.02, 5, true, 0.4, 3), exact));
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

TEST_F(DeferredCorrectionTest, AFixedStepBeyondTheLimitIsAnErrorThatNamesIt) {
  ModelRegistry registry;
  register_builtin_models(registry);
  const auto stiff = registry.make("bz", {});
  const DiffusionOperator diffusion(decomposition_.grid(), boundary_, {2.5e-3, 2.5e-3, 1.5e-3}, 2);
  CoupledRhs rhs(decomposition_, diffusion, *stiff);
  Field u(decomposition_, 3, 1);
  stiff->initialise("bz-front", u);
  ReactionFlow reaction(decomposition_, boundary_, stiff->make_radau5({1e-8, {1e-8, 1e-8, 1e-8}}));
  Rock4 rock4(decomposition_, diffusion, {1e-8, {1e-8, 1e-8, 1e-8}});
  DeferredCorrectionOptions o;
  o.fixed_step = 5e-3;
  o.iterations = 4;
  DeferredCorrection method(u, rhs, reaction, rock4, o);
  Schedule schedule;
  schedule.end = 1.0;
  Progress progress;
  Observer nobody;
  try {
    evolve(method, schedule, u, progress, nobody);
    FAIL() << "reached t = " << progress.t;
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::numerics);
    EXPECT_NE(std::string(e.what()).find("7.8"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace stiffront
