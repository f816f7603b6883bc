// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/solvers/rock4.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <numbers>
#include <ostream>
#include <string>
#include <unsupported/Eigen/MatrixFunctions>

#include "stiffront/core/error.hpp"
#include "support/diffusion_problem.hpp"

namespace stiffront {
namespace {

using testing::both_sides;
using testing::DiffusionProblem;
using testing::scatter;
using testing::unit_grid;

constexpr double pi = std::numbers::pi;

const Communicator& self() {
  static const Communicator comm(MPI_COMM_SELF);
  return comm;
}

Rock4Tolerances tolerances(double tolerance, int n_species = 1) {
  return {tolerance, std::vector<double>(static_cast<std::size_t>(n_species), tolerance)};
}

/// So loose that every call is one step, whatever its length (if the degree allows).
Rock4Tolerances no_control(int n_species = 1) { return {1.0, std::vector<double>(static_cast<std::size_t>(n_species), 1e9)}; }

/// One call of the flow, begun with the whole of dt as the first step to try.
Work whole_step(Rock4& flow, double t, double dt, Field& from, Field& to) {
  Work work;
  const double first = dt;
  flow.set_state(std::span<const double>(&first, 1));
  EXPECT_FALSE(flow.advance(t, dt, from, to, work));
  return work;
}

std::vector<double> values(const Field& u) {
  std::vector<double> v;
  for (int s = 0; s < u.n_species(); ++s) {
    for (int j = 0; j < u.n_y(); ++j) v.insert(v.end(), u.row(s, j), u.row(s, j) + u.n_x());
  }
  return v;
}

double distance(const Field& a, const Field& b) {
  const std::vector<double> x = values(a);
  const std::vector<double> y = values(b);
  double largest = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) largest = std::max(largest, std::abs(x[i] - y[i]));
  return largest;
}

/// exp(t L) u of the discrete operator of one species, by the matrix exponential: no error in time.
Field exact_decay(const DiffusionProblem& p, const Field& u, double t) {
  Field probe = p.field();
  Field image = p.field();
  HaloExchange halo(p.decomposition, p.boundary, 1, 1, p.diffusion.halo_width());
  const FreeBox free = p.boundary.free_box(p.decomposition);
  const int n = u.n_x() * u.n_y();
  Eigen::MatrixXd matrix(n, n);
  for (int k = 0; k < n; ++k) {
    probe.at(0, k % u.n_x(), k / u.n_x()) = 1.0;
    halo.exchange(probe);
    p.diffusion.apply(probe, image, free);
    matrix.col(k) = Eigen::Map<const Eigen::VectorXd>(values(image).data(), n);
    probe.at(0, k % u.n_x(), k / u.n_x()) = 0.0;
  }
  const Eigen::VectorXd x = (matrix * t).exp() * Eigen::Map<const Eigen::VectorXd>(values(u).data(), n);
  Field result = p.field();
  for (int k = 0; k < n; ++k) result.at(0, k % u.n_x(), k / u.n_x()) = x[k];
  return result;
}

struct Setting {
  const char* name;
  Grid grid;
  BoundaryKind x, y;
  int order;
};
void PrintTo(const Setting& setting, std::ostream* out) { *out << setting.name; }

class Rock4OnEveryGridTest : public ::testing::TestWithParam<Setting> {
 protected:
  Rock4OnEveryGridTest()
      : problem(self(), GetParam().grid,
                {both_sides(GetParam().x, 1, [](double, double x, double y) { return 1.0 + x - 0.5 * y; }),
                 both_sides(GetParam().y, 1, [](double, double x, double y) { return 1.0 + x - 0.5 * y; })},
                {0.1}, GetParam().order),
        initial(problem.field([](int, double x, double y) {
          return 1.0 + x - 0.5 * y +
                 std::sin(pi * x) * (1.0 + x) * (GetParam().grid.dimension == 1 ? 1.0 : std::cos(2.0 * y) * y * (1 - y));
        })) {
    problem.boundary.impose(initial, 0.0);
  }

  DiffusionProblem problem;
  Field initial;
};

TEST_P(Rock4OnEveryGridTest, ReachesTheExactSemiDiscreteSolutionAtATightTolerance) {
  Rock4 flow(problem.decomposition, problem.diffusion, tolerances(1e-13));
  Field end = problem.field();
  Work work;
  ASSERT_FALSE(flow.advance(0.0, 0.3, initial, end, work));
  EXPECT_LT(distance(end, exact_decay(problem, initial, 0.3)), 1e-12);
}

TEST_P(Rock4OnEveryGridTest, HasOrderFourInTime) {
  Rock4 flow(problem.decomposition, problem.diffusion, no_control());
  // Few points and short steps, so that all runs but the first have five stages: the error constant depends on their
  // number.
  const Field start = exact_decay(problem, initial, 0.1);
  const Field exact = exact_decay(problem, start, 0.4);
  std::vector<double> log_error;
  for (int steps : {16, 32, 64, 128}) {
    Field u = problem.field();
    u.copy_interior(start);
    for (int i = 0; i < steps; ++i) EXPECT_EQ(whole_step(flow, i * 0.4 / steps, 0.4 / steps, u, u).diffusion_steps, 1);
    log_error.push_back(std::log2(distance(u, exact)));
  }
  // Least squares over equidistant abscissae.
  const double slope = (3.0 * (log_error[0] - log_error[3]) + (log_error[1] - log_error[2])) / 10.0;
  EXPECT_NEAR(slope, 4.0, 0.2);
}

TEST_P(Rock4OnEveryGridTest, ErrorIsProportionalToTheTolerance) {
  const Field exact = exact_decay(problem, initial, 0.3);
  for (double tolerance : {1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8}) {
    Rock4 flow(problem.decomposition, problem.diffusion, tolerances(tolerance));
    Field end = problem.field();
    Work work;
    ASSERT_FALSE(flow.advance(0.0, 0.3, initial, end, work));
    const double ratio = distance(end, exact) / tolerance;
    EXPECT_LT(ratio, 5.0) << tolerance;
    EXPECT_GT(ratio, 0.005) << tolerance;
  }
}

TEST_P(Rock4OnEveryGridTest, InPlaceAndIntoAnotherFieldGiveTheSameBits) {
  const std::vector<double> before = values(initial);
  Rock4 flow(problem.decomposition, problem.diffusion, tolerances(1e-6));
  Field apart = problem.field();
  Work work;
  ASSERT_FALSE(flow.advance(0.0, 0.3, initial, apart, work));
  EXPECT_GT(work.diffusion_steps, 2);
  EXPECT_EQ(values(initial), before);

  const double none = 0.0;
  flow.set_state(std::span<const double>(&none, 1));
  ASSERT_FALSE(flow.advance(0.0, 0.3, initial, initial, work));
  EXPECT_EQ(values(initial), values(apart));
}

INSTANTIATE_TEST_SUITE_P(
    Grids, Rock4OnEveryGridTest,
    ::testing::Values(Setting{"line_neumann_2", unit_grid(21, 1), BoundaryKind::neumann, BoundaryKind::neumann, 2},
                      Setting{"line_neumann_4", unit_grid(19, 1), BoundaryKind::neumann, BoundaryKind::neumann, 4},
                      Setting{"line_periodic_2", unit_grid(20, 1, true), BoundaryKind::periodic, BoundaryKind::neumann, 2},
                      Setting{"line_periodic_4", unit_grid(17, 1, true), BoundaryKind::periodic, BoundaryKind::neumann, 4},
                      Setting{"line_dirichlet_2", unit_grid(21, 1), BoundaryKind::dirichlet, BoundaryKind::neumann, 2},
                      Setting{"line_dirichlet_4", unit_grid(18, 1), BoundaryKind::dirichlet, BoundaryKind::neumann, 4},
                      Setting{"plane_neumann_2", unit_grid(19, 11), BoundaryKind::neumann, BoundaryKind::neumann, 2},
                      Setting{"plane_periodic_neumann_4", unit_grid(18, 11, true), BoundaryKind::periodic, BoundaryKind::neumann, 4},
                      Setting{"plane_dirichlet_periodic_2", unit_grid(18, 11, false, true), BoundaryKind::dirichlet, BoundaryKind::periodic,
                              2},
                      Setting{"plane_neumann_dirichlet_4", unit_grid(17, 12), BoundaryKind::neumann, BoundaryKind::dirichlet, 4}),
    [](const auto& test) { return std::string(test.param.name); });

std::array<std::array<BoundarySide, 2>, 2> neumann() {
  return {both_sides(BoundaryKind::neumann, 1), both_sides(BoundaryKind::neumann, 1)};
}
std::array<std::array<BoundarySide, 2>, 2> periodic() {
  return {both_sides(BoundaryKind::periodic, 1), both_sides(BoundaryKind::periodic, 1)};
}

TEST(Rock4Test, DecaysADiscreteEigenmodeByItsEigenvalue) {
  const int n = 65;
  const double D = 2e-3;
  for (int order : {2, 4}) {
    DiffusionProblem p(self(), unit_grid(n, 1), neumann(), {D}, order);
    const int mode = 7;
    const Field u = p.field([](int, double x, double) { return std::cos(mode * pi * x); });
    const double theta = mode * pi / (n - 1);
    const double symbol = order == 2 ? 2.0 * std::cos(theta) - 2.0 : -2.5 + 8.0 / 3.0 * std::cos(theta) - std::cos(2.0 * theta) / 6.0;
    const double decay = std::exp(D * (n - 1) * (n - 1) * symbol);
    Rock4 flow(p.decomposition, p.diffusion, tolerances(1e-13));
    Field end = p.field();
    Work work;
    ASSERT_FALSE(flow.advance(0.0, 1.0, const_cast<Field&>(u), end, work));
    for (int i = 0; i < n; ++i) EXPECT_NEAR(end.at(0, i), decay * u.at(0, i), 1e-12);
  }
}

TEST(Rock4Test, HasOrderFourWithDirichletValuesThatDependOnTime) {
  const auto value = [](double t, double x, double) { return std::cos(3.0 * t) + x * std::sin(2.0 * t); };
  for (int order : {2, 4}) {
    DiffusionProblem p(self(), unit_grid(13, 1),
                       {both_sides(BoundaryKind::dirichlet, 1, value, true), both_sides(BoundaryKind::neumann, 1)}, {0.02}, order);
    Rock4 flow(p.decomposition, p.diffusion, no_control());
    Field start = p.field([&](int, double x, double) { return value(1.0, x, 0.0) + 0.3 * std::sin(pi * x); });
    const auto run = [&](int steps) {
      Field u = p.field();
      u.copy_interior(start);
      for (int i = 0; i < steps; ++i) whole_step(flow, 1.0 + i * 1.0 / steps, 1.0 / steps, u, u);
      return u;
    };
    const Field reference = run(2000);
    EXPECT_EQ(reference.at(0, 0), value(1.0 + 1999 * 1.0 / 2000 + 1.0 / 2000, 0.0, 0.0));
    std::vector<double> log_error;
    for (int steps : {20, 40, 80, 160}) log_error.push_back(std::log2(distance(run(steps), reference)));
    EXPECT_NEAR((3.0 * (log_error[0] - log_error[3]) + (log_error[1] - log_error[2])) / 10.0, 4.0, 0.2);
  }
}

TEST(Rock4Test, StagesTakeDirichletValuesAtTheirOwnTimes) {
  // x^2 + 2 D t is reproduced by every stage, at its own time, by differences of any order.
  constexpr double D = 0.1;
  const auto value = [](double t, double x, double) { return x * x + 2.0 * D * t; };
  for (int order : {2, 4}) {
    DiffusionProblem p(self(), unit_grid(41, 1),
                       {both_sides(BoundaryKind::dirichlet, 1, value, true), both_sides(BoundaryKind::neumann, 1)}, {D}, order);
    const double rho = p.diffusion.spectral_radius();
    for (double h_rho : {4.0, 8.0, 30.0, 100.0}) {
      Rock4 flow(p.decomposition, p.diffusion, no_control());
      Field u = p.field([&](int, double x, double) { return value(0.5, x, 0.0); });
      whole_step(flow, 0.5, h_rho / rho, u, u);
      const Field exact = p.field([&](int, double x, double) { return value(0.5 + h_rho / rho, x, 0.0); });
      EXPECT_LT(distance(u, exact), 1e-9) << h_rho;
    }
    // Several steps in one call.
    Rock4 flow(p.decomposition, p.diffusion, {1e-8, {1e9}});
    const double dt = 3.4 * flow.largest_step();
    Field u = p.field([&](int, double x, double) { return value(0.5, x, 0.0); });
    EXPECT_EQ(whole_step(flow, 0.5, dt, u, u).diffusion_steps, 4);
    EXPECT_LT(distance(u, p.field([&](int, double x, double) { return value(0.5 + dt, x, 0.0); })), 1e-7);
  }
}

TEST(Rock4Test, TakesDirichletValuesAtTheStartFromTheBoundaryNotFromTheField) {
  const auto value = [](double t, double, double) { return std::cos(3.0 * t); };
  DiffusionProblem p(self(), unit_grid(13, 1), {both_sides(BoundaryKind::dirichlet, 1, value, true), both_sides(BoundaryKind::neumann, 1)},
                     {0.1}, 2);
  Rock4 flow(p.decomposition, p.diffusion, no_control());
  Field u = p.field([](int, double x, double) { return 1.0 + 0.3 * std::sin(pi * x); });
  Field ahead = p.field();
  ahead.copy_interior(u);
  p.boundary.impose(ahead, 0.25);
  const std::vector<double> before = values(ahead);
  Field a = p.field();
  Field b = p.field();
  whole_step(flow, 0.0, 0.1, u, a);
  whole_step(flow, 0.0, 0.1, ahead, b);
  EXPECT_EQ(values(a), values(b));
  EXPECT_EQ(values(ahead), before);
  whole_step(flow, 0.0, 0.1, ahead, ahead);
  EXPECT_EQ(values(a), values(ahead));
}

TEST(Rock4Test, KeepsTheIntegralToRoundingError) {
  for (int order : {2, 4}) {
    for (bool is_periodic : {false, true}) {
      DiffusionProblem p(self(), unit_grid(48, 33, is_periodic, is_periodic), is_periodic ? periodic() : neumann(), {1e-2}, order);
      Field u = p.field([](int, double x, double y) { return 1.0 + scatter(std::lround(1e6 * x), std::lround(1e6 * y)); });
      const auto integral = [&] {
        double sum = 0.0;
        for (int j = 0; j < u.n_y(); ++j) {
          for (int i = 0; i < u.n_x(); ++i) {
            const bool half_x = !is_periodic && (i == 0 || i == u.n_x() - 1);
            const bool half_y = !is_periodic && (j == 0 || j == u.n_y() - 1);
            // Mirroring about the end point is conservative with trapezoidal weights, at order 4 as well.
            sum += u.at(0, i, j) * (half_x ? 0.5 : 1.0) * (half_y ? 0.5 : 1.0);
          }
        }
        return sum;
      };
      const double before = integral();
      Rock4 flow(p.decomposition, p.diffusion, tolerances(1e-5));
      Work work;
      for (int i = 0; i < 50; ++i) ASSERT_FALSE(flow.advance(0.02 * i, 0.02, u, u, work));
      EXPECT_NEAR(integral() / before, 1.0, 1e-13);
    }
  }
}

TEST(Rock4Test, AConstantStaysTheSameToTheLastBit) {
  for (int order : {2, 4}) {
    DiffusionProblem p(self(), unit_grid(21, 19), neumann(), {0.3}, order);
    Field u = p.field([](int, double, double) { return 0.1; });
    const std::vector<double> before = values(u);
    Rock4 flow(p.decomposition, p.diffusion, tolerances(1e-4));
    Work work;
    ASSERT_FALSE(flow.advance(0.0, 10.0, u, u, work));
    EXPECT_EQ(values(u), before);
  }
}

TEST(Rock4Test, TransposedDataGiveTransposedBits) {
  for (int order : {2, 4}) {
    DiffusionProblem p(self(), unit_grid(29, 29), neumann(), {0.02}, order);
    const auto value = [](int i, int j) { return scatter(i, j); };
    Field u = p.field();
    Field v = p.field();
    for (int j = 0; j < 29; ++j) {
      for (int i = 0; i < 29; ++i) {
        u.at(0, i, j) = value(i, j);
        v.at(0, i, j) = value(j, i);
      }
    }
    Rock4 flow(p.decomposition, p.diffusion, no_control());
    whole_step(flow, 0.0, 0.5, u, u);
    whole_step(flow, 0.0, 0.5, v, v);
    for (int j = 0; j < 29; ++j) {
      for (int i = 0; i < 29; ++i) EXPECT_EQ(u.at(0, i, j), v.at(0, j, i));
    }
  }
}

TEST(Rock4Test, RejectsAStepTooLongForTheDataAndStillMeetsTheTolerance) {
  DiffusionProblem p(self(), unit_grid(101, 1), neumann(), {0.01}, 2);
  Field u = p.field([](int, double x, double) { return x < 0.3 ? 1.0 : 0.0; });
  const std::vector<double> before = values(u);
  Rock4 flow(p.decomposition, p.diffusion, tolerances(1e-6));
  Field end = p.field();
  const Work work = whole_step(flow, 0.0, 1.0, u, end);
  EXPECT_GT(work.diffusion_rejections, 0);
  EXPECT_GT(work.diffusion_steps, 1);
  EXPECT_EQ(values(u), before);
  EXPECT_LT(distance(end, exact_decay(p, u, 1.0)), 5e-6);
  // The next call begins where this one should have begun.
  EXPECT_LT(flow.state()[0], 0.1);
}

TEST(Rock4Test, RespectsTheLargestUsefulDegree) {
  DiffusionProblem p(self(), unit_grid(401, 1), neumann(), {1.0}, 2);
  Field u = p.field([](int, double x, double) { return 1.0 + 1e-9 * std::cos(pi * x); });
  Rock4 flow(p.decomposition, p.diffusion, tolerances(1e-8));
  EXPECT_EQ(rock4_stages(flow.largest_step() * p.diffusion.spectral_radius()), rock4_max_stages(1e-8));
  const double dt = 10.3 * flow.largest_step();
  const Work work = whole_step(flow, 0.0, dt, u, u);
  EXPECT_EQ(work.diffusion_rejections, 0);
  EXPECT_EQ(work.diffusion_steps, 11);
  EXPECT_LE(work.diffusion_stages, 11 * rock4_max_stages(1e-8));
  EXPECT_GE(work.diffusion_stages, 11 * (rock4_max_stages(1e-8) - 2));
  // The end of the interval is no reason to exceed it either.
  EXPECT_EQ(whole_step(flow, 0.0, 1.005 * flow.largest_step(), u, u).diffusion_steps, 2);
  EXPECT_EQ(whole_step(flow, 0.0, flow.largest_step(), u, u).diffusion_steps, 1);
}

TEST(Rock4Test, OneStepCostsOneHaloExchangePerStageAndOneReduction) {
  DiffusionProblem p(self(), unit_grid(65, 1), neumann(), {1.0, 0.5}, 2);
  Field u = p.field([](int, double x, double) { return std::cos(pi * x); });
  Rock4 flow(p.decomposition, p.diffusion, no_control(2));
  const std::int64_t reductions = self().reductions();
  const double dt = 100.0 / p.diffusion.spectral_radius();
  const Work work = whole_step(flow, 0.0, dt, u, u);
  EXPECT_EQ(work.diffusion_steps, 1);
  EXPECT_EQ(work.diffusion_stages, rock4_stages(100.0));
  EXPECT_EQ(work.halo_exchanges, rock4_stages(100.0));
  EXPECT_EQ(self().reductions() - reductions, 1);
}

TEST(Rock4Test, StatesAdvancedTogetherEqualThoseAdvancedAloneWithTheSameSteps) {
  DiffusionProblem p(self(), unit_grid(37, 21), neumann(), {0.02, 0.05}, 4);
  // The degree bounds every step, so that all states take the same ones alone as well.
  Rock4 flow(p.decomposition, p.diffusion, {1e-9, {1e9, 1e9}});
  const double dt = 4.5 * flow.largest_step();
  std::vector<Field> from, together, alone;
  for (int k = 0; k < 3; ++k) {
    from.push_back(p.field([k](int s, double x, double y) { return scatter(std::lround(1e6 * x), std::lround(1e6 * y), 2 * k + s); }));
    together.push_back(p.field());
    alone.push_back(p.field());
  }
  std::vector<Transition> all;
  for (std::size_t k = 0; k < 3; ++k) all.push_back({&from[k], &together[k]});
  Work work;
  flow.set_state(std::span<const double>(&dt, 1));
  ASSERT_FALSE(flow.advance(0.0, dt, all, work));
  EXPECT_EQ(work.diffusion_steps, 5);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(whole_step(flow, 0.0, dt, from[k], alone[k]).diffusion_steps, 5);
    EXPECT_EQ(values(together[k]), values(alone[k]));
  }
}

TEST(Rock4Test, TheMostDemandingStateDecidesTheSteps) {
  DiffusionProblem p(self(), unit_grid(201, 1), neumann(), {0.01}, 2);
  Field smooth = p.field([](int, double x, double) { return std::cos(pi * x); });
  Field rough = p.field([](int, double x, double) { return x < 0.5 ? 1.0 : 0.0; });
  Field a = p.field();
  Field b = p.field();
  Rock4 flow(p.decomposition, p.diffusion, tolerances(1e-5));
  const Work alone = whole_step(flow, 0.0, 0.5, rough, b);
  EXPECT_LT(whole_step(flow, 0.0, 0.5, smooth, a).diffusion_steps, alone.diffusion_steps);
  const std::vector<double> rough_alone = values(b);
  const std::vector<Transition> both{{&smooth, &a}, {&rough, &b}};
  const double dt = 0.5;
  flow.set_state(std::span<const double>(&dt, 1));
  Work work;
  ASSERT_FALSE(flow.advance(0.0, dt, both, work));
  EXPECT_EQ(work.diffusion_steps, alone.diffusion_steps);
  EXPECT_EQ(work.diffusion_rejections, alone.diffusion_rejections);
  EXPECT_EQ(values(b), rough_alone);
}

TEST(Rock4Test, SpeciesThatDoNotDiffuseAreKeptToTheLastBit) {
  DiffusionProblem p(self(), unit_grid(45, 1), neumann(), {0.0, 0.02, 0.0}, 2);
  for (int steps : {1, 2, 3}) {
    Field u = p.field([](int s, double x, double) { return scatter(std::lround(1e6 * x), s); });
    const std::vector<double> before = values(u);
    Rock4 flow(p.decomposition, p.diffusion, {1e-9, {1e9, 1e9, 1e9}});
    const double dt = (steps - 0.5) * flow.largest_step();
    Field v = p.field();
    EXPECT_EQ(whole_step(flow, 0.0, dt, u, v).diffusion_steps, steps);
    EXPECT_EQ(values(u), before);
    whole_step(flow, 0.0, dt, u, u);
    EXPECT_EQ(values(u), values(v));
    const std::vector<double> after = values(v);
    EXPECT_TRUE(std::equal(before.begin(), before.begin() + 45, after.begin()));
    EXPECT_FALSE(std::equal(before.begin() + 45, before.begin() + 90, after.begin() + 45));
    EXPECT_TRUE(std::equal(before.begin() + 90, before.end(), after.begin() + 90));
  }
}

TEST(Rock4Test, WithoutDiffusionOrTimeTheStateIsCopied) {
  DiffusionProblem still(self(), unit_grid(45, 1), neumann(), {0.0}, 2);
  DiffusionProblem moving(self(), unit_grid(45, 1), neumann(), {1.0}, 2);
  Field u = still.field([](int, double x, double) { return std::exp(x); });
  Field v = still.field();
  Work work;
  ASSERT_FALSE(Rock4(still.decomposition, still.diffusion, tolerances(1e-5)).advance(0.0, 1.0, u, v, work));
  EXPECT_EQ(values(u), values(v));
  Field w = moving.field();
  Field start = moving.field();
  start.copy_interior(u);
  ASSERT_FALSE(Rock4(moving.decomposition, moving.diffusion, tolerances(1e-5)).advance(0.0, 0.0, start, w, work));
  EXPECT_EQ(values(u), values(w));
  EXPECT_EQ(work.diffusion_stages, 0);
}

TEST(Rock4Test, ContinuesFromItsSavedStateToTheSameBits) {
  DiffusionProblem p(self(), unit_grid(65, 1), neumann(), {0.01}, 2);
  Field u = p.field([](int, double x, double) { return std::exp(-80.0 * (x - 0.4) * (x - 0.4)); });
  Rock4 flow(p.decomposition, p.diffusion, tolerances(1e-7));
  Work work;
  ASSERT_FALSE(flow.advance(0.0, 0.1, u, u, work));
  Rock4 restarted(p.decomposition, p.diffusion, tolerances(1e-7));
  restarted.set_state(flow.state());
  Field v = p.field();
  v.copy_interior(u);
  Work of_u, of_v;
  ASSERT_FALSE(flow.advance(0.1, 0.1, u, u, of_u));
  ASSERT_FALSE(restarted.advance(0.1, 0.1, v, v, of_v));
  EXPECT_EQ(values(u), values(v));
  EXPECT_EQ(of_u.diffusion_steps, of_v.diffusion_steps);
  EXPECT_EQ(flow.state(), restarted.state());
}

TEST(Rock4Test, ReportsAValueThatIsNotFiniteAndLeavesFiniteOnes) {
  DiffusionProblem p(self(), unit_grid(30, 20), neumann(), {0.01, 0.02}, 2);
  for (double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    Field u = p.field([](int, double x, double) { return x; });
    u.at(1, 17, 11) = bad;
    Field v = p.field();
    Rock4 flow(p.decomposition, p.diffusion, tolerances(1e-5, 2));
    Work work;
    const auto failure = flow.advance(3.0, 1.0, u, v, work);
    ASSERT_TRUE(failure);
    EXPECT_EQ(failure->i, 17);
    EXPECT_EQ(failure->j, 11);
    EXPECT_DOUBLE_EQ(failure->x, 17.0 / 29.0);
    EXPECT_EQ(failure->t, 3.0);
    EXPECT_EQ(failure->interval, 1.0);
    EXPECT_EQ(failure->state.at(0), u.at(0, 17, 11));
    EXPECT_NE(failure->reason.find("not finite"), std::string::npos);
    for (double x : values(v)) EXPECT_TRUE(std::isfinite(x));
    EXPECT_EQ(work.diffusion_steps, 0);
  }
}

TEST(Rock4Test, RefusesMeaninglessArguments) {
  DiffusionProblem p(self(), unit_grid(30, 1), neumann(), {0.01}, 4);
  for (double bad : {0.0, -1e-3, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THROW(Rock4(p.decomposition, p.diffusion, Rock4Tolerances{bad, {1e-5}}), Error);
    EXPECT_THROW(Rock4(p.decomposition, p.diffusion, Rock4Tolerances{1e-5, {bad}}), Error);
  }
  EXPECT_THROW(Rock4(p.decomposition, p.diffusion, Rock4Tolerances{1e-15, {1e-5}}), Error);
  EXPECT_THROW(Rock4(p.decomposition, p.diffusion, Rock4Tolerances{1e-5, {1e-5, 1e-5}}), Error);
  Rock4 flow(p.decomposition, p.diffusion, tolerances(1e-5));
  Field u = p.field();
  Work work;
  EXPECT_THROW(flow.advance(0.0, -1.0, u, u, work), Error);
  Field narrow(p.decomposition, 1, 1);
  EXPECT_THROW(flow.advance(0.0, 1.0, narrow, narrow, work), Error);
  EXPECT_THROW(flow.set_state({}), Error);
}

struct Plane {
  const char* name;
  Grid grid;
  BoundaryKind x, y;
};
void PrintTo(const Plane& plane, std::ostream* out) { *out << plane.name; }

class Rock4InOnePassTest : public ::testing::TestWithParam<Plane> {};

// Depth 1 is a pass over memory per stage. Steps are of many stages, some are rejected, and two states go together. With values given in time
// steps are accepted whatever they are, since the test would be one of many short ones otherwise.
TEST_P(Rock4InOnePassTest, BitsDoNotDependOnTheStagesInAPass) {
  double dt = 1.0;
  for (const bool in_time : {false, true}) {
    const auto value = [&](double t, double x, double y) { return 1.0 + x * y + (in_time ? std::cos(t / dt) : 0.0); };
    if (in_time && GetParam().x != BoundaryKind::dirichlet && GetParam().y != BoundaryKind::dirichlet) continue;
    for (const int order : {2, 4}) {
      const DiffusionProblem p(self(), GetParam().grid,
                               {both_sides(GetParam().x, 3, value, in_time), both_sides(GetParam().y, 3, value, in_time)},
                               {0.02, 0.0, 0.05}, order);
      dt = (in_time ? 2e2 : 4e3) / p.diffusion.spectral_radius();
      const auto run = [&](int depth, Work& work) {
        std::vector<Field> states;
        for (int k = 0; k < 2; ++k) {
          states.push_back(p.field([k](int s, double x, double y) {
            return std::floor(3.0 * x + 0.2 * k) + 1e-3 * scatter(std::lround(1e7 * x), std::lround(1e7 * y), 2 * k + s);
          }));
          p.boundary.impose(states.back(), 0.0);
        }
        Rock4 flow(p.decomposition, p.diffusion, in_time ? no_control(3) : tolerances(1e-4, 3), depth);
        const double first = dt;
        flow.set_state(std::span<const double>(&first, 1));
        Field end = p.field();
        for (int call = 0; call < 2; ++call) {
          const Transition transitions[] = {{&states[0], &states[0]}, {&states[1], &end}};
          EXPECT_FALSE(flow.advance(call * dt, dt, transitions, work));
          swap(states[1], end);
        }
        std::vector<double> all = values(states[0]);
        for (double x : values(states[1])) all.push_back(x);
        return all;
      };
      Work plain;
      const std::vector<double> expected = run(1, plain);
      EXPECT_EQ(plain.diffusion_rejections > 0, !in_time);
      EXPECT_GT(plain.diffusion_stages, 12 * plain.diffusion_steps);
      for (int depth = 0; depth <= 16; ++depth) {
        Work work;
        EXPECT_EQ(run(depth, work), expected) << "depth " << depth << ", order " << order;
        EXPECT_EQ(work.diffusion_steps, plain.diffusion_steps);
        EXPECT_EQ(work.diffusion_stages, plain.diffusion_stages);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Grids, Rock4InOnePassTest,
    ::testing::Values(Plane{"line_neumann", unit_grid(9001, 1), BoundaryKind::neumann, BoundaryKind::neumann},
                      Plane{"line_periodic", unit_grid(9001, 1, true), BoundaryKind::periodic, BoundaryKind::neumann},
                      Plane{"line_dirichlet", unit_grid(8194, 1), BoundaryKind::dirichlet, BoundaryKind::neumann},
                      Plane{"short_line_periodic", unit_grid(9, 1, true), BoundaryKind::periodic, BoundaryKind::neumann},
                      Plane{"neumann", unit_grid(37, 61), BoundaryKind::neumann, BoundaryKind::neumann},
                      Plane{"periodic", unit_grid(37, 61, true, true), BoundaryKind::periodic, BoundaryKind::periodic},
                      Plane{"dirichlet", unit_grid(37, 62), BoundaryKind::dirichlet, BoundaryKind::dirichlet},
                      Plane{"dirichlet_periodic", unit_grid(37, 61, false, true), BoundaryKind::dirichlet, BoundaryKind::periodic},
                      Plane{"periodic_dirichlet", unit_grid(37, 62, true, false), BoundaryKind::periodic, BoundaryKind::dirichlet},
                      Plane{"dirichlet_neumann", unit_grid(37, 61), BoundaryKind::dirichlet, BoundaryKind::neumann},
                      Plane{"flat_periodic", unit_grid(61, 7, true, true), BoundaryKind::periodic, BoundaryKind::periodic},
                      Plane{"flat_dirichlet", unit_grid(61, 7), BoundaryKind::dirichlet, BoundaryKind::dirichlet}),
    [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace stiffront
