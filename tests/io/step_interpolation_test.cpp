// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/io/step_interpolation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "stiffront/solvers/model_registry.hpp"
#include "support/diffusion_problem.hpp"

namespace stiffront {
namespace {

TEST(StepInterpolationTest, IsOfFourthOrderOnASmoothOscillation) {
  double previous = 0.0;
  for (double dt : {0.4, 0.2, 0.1, 0.05}) {
    double worst = 0.0;
    for (double t = 0.013; t < 6.5; t += dt) {
      for (double theta : {0.2, 0.5, 0.9}) {
        const double p = interpolate_in_step(theta, std::sin(t), dt * std::cos(t), std::sin(t + dt), dt * std::cos(t + dt));
        worst = std::max(worst, std::abs(p - std::sin(t + theta * dt)));
      }
    }
    if (previous > 0.0) {
      EXPECT_GT(previous / worst, 14.0) << dt;
    }
    previous = worst;
  }
  EXPECT_LT(previous, 3e-8);
}

TEST(StepInterpolationTest, ReproducesTheEndsAndCubicsThatRise) {
  EXPECT_EQ(interpolate_in_step(0.0, 0.1, 3.0, 0.7, -2.0), 0.1);
  EXPECT_NEAR(interpolate_in_step(1.0, 0.1, 3.0, 0.7, -2.0), 0.7, 1e-16);
  const auto cubic = [](double s) { return s * s * s + 0.5 * s; };
  for (double theta : {0.1, 0.4, 0.8}) EXPECT_NEAR(interpolate_in_step(theta, 0.0, 0.5, 1.5, 3.5), cubic(theta), 1e-15);
}

TEST(StepInterpolationTest, SlopesOffTheSlowManifoldDoNotMakeTheInterpolantOvershoot) {
  // What a splitting leaves behind: both ends have the true slope plus the same large relaxation rate.
  const double u0 = 1.0, u1 = 1.1, relaxation = 50.0;
  for (double theta = 0.1; theta < 1.0; theta += 0.1) {
    const double p = interpolate_in_step(theta, u0, 0.1 + relaxation, u1, 0.1 + 1.02 * relaxation);
    EXPECT_GE(p, u0);
    EXPECT_LE(p, u1);
  }
  // One end only, bending the right way: no more than four times the other end's bend.
  EXPECT_LT(interpolate_in_step(0.5, 1.0, 1e6, 1.0, -0.01), 1.01);
}

TEST(StepInterpolationTest, AnInfiniteSlopeGivesTheLine) {
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(interpolate_in_step(0.5, 1.0, infinity, 2.0, -1.0), 1.5);
  EXPECT_EQ(interpolate_in_step(0.5, 1.0, std::numeric_limits<double>::quiet_NaN(), 2.0, 1.0), 1.5);
}

TEST(StepInterpolationTest, AFieldGetsEachPointsInterpolantAndDirichletValuesOfItsTime) {
  const Communicator comm(MPI_COMM_SELF);
  const auto value = [](double t, double, double) { return 2.0 + t * t; };
  testing::DiffusionProblem problem(
      comm, testing::unit_grid(9, 7),
      {testing::both_sides(BoundaryKind::dirichlet, 1, value, true), testing::both_sides(BoundaryKind::neumann, 1)}, {0.0}, 2);
  ModelRegistry registry;
  register_builtin_models(registry);
  const auto kpp = registry.make("kpp", {{"k", 3.0}});
  CoupledRhs rhs(problem.decomposition, problem.diffusion, *kpp);
  const auto rate = [](double u) { return 3.0 * u * u * (1.0 - u); };

  const double t = 0.5, t_new = 0.7, time = 0.58;
  Field u = problem.field([](int, double x, double y) { return 0.1 + 0.5 * x + 0.1 * y; });
  Field u_new = problem.field([](int, double x, double y) { return 0.15 + 0.55 * x + 0.1 * y; });
  problem.boundary.impose(u, t);
  problem.boundary.impose(u_new, t_new);
  const StepInterpolation interpolation(rhs, t, u, t_new, u_new);
  Field result = problem.field();
  interpolation.at(time, result);
  const double theta = (time - t) / (t_new - t);
  for (int j = 0; j < 7; ++j) {
    EXPECT_EQ(result.at(0, 0, j), value(time, 0.0, 0.0));
    EXPECT_EQ(result.at(0, 8, j), value(time, 1.0, 0.0));
    for (int i = 1; i < 8; ++i) {
      const double u0 = u.at(0, i, j), u1 = u_new.at(0, i, j);
      EXPECT_NEAR(result.at(0, i, j), interpolate_in_step(theta, u0, 0.2 * rate(u0), u1, 0.2 * rate(u1)), 1e-15);
    }
  }
}

}  // namespace
}  // namespace stiffront
