// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "stiffront/core/error.hpp"
#include "stiffront/solvers/crank_nicolson.hpp"
#include "stiffront/solvers/model_kernels.hpp"
#include "stiffront/solvers/trapezoidal_cells.hpp"
#include "support/diffusion_problem.hpp"
#include "support/grids.hpp"

namespace stiffront {
namespace {

struct Square {
  static constexpr int n_species = 1;
  static constexpr const char* name = "square";
  static constexpr const char* source = "test";
  static constexpr std::array<const char*, 1> species{"u"};
  static constexpr std::array<double, 1> diffusion{1.0};
  static constexpr std::array<Parameter<Square>, 0> parameters{};
  static constexpr std::array<Profile<Square>, 0> profiles{};
  template <class T, class P>
  void rates(const T* u, T* du, const P&) const {
    du[0] = u[0] * u[0];
  }
};

TEST(TrapezoidalCellsTest, SolveTheRuleInEveryCellOrNameTheCellThatHasNoSolution) {
  const Communicator self(MPI_COMM_SELF);
  const Grid grid = testing::unit_grid(11, 0, testing::neumann);
  const Decomposition decomposition(self, grid, {0, 0}, 1);
  const ModelKernelsOf<Square> model({});
  Field u(decomposition, 1, 1);
  for (int i = 0; i < u.n_x(); ++i) u.at(0, i) = 0.1 + 0.02 * i;
  u.at(0, 7) = 0.9;  // v = u + h/2 (u^2 + v^2) has no real solution from here
  const double dt = 1.0;
  const auto solver = make_trapezoidal_cells(model, {1e-13, {1e-13}});
  std::vector<double> hints(11, 0.0);
  std::vector<float> cost(11, 0.0F);
  Work work;
  Field v = u.similar();
  const auto failure = solver->advance(0.5, dt, u, v, {0, 11, 0, 1}, hints, cost, work);
  ASSERT_TRUE(failure);
  EXPECT_EQ(failure->i, 7);
  EXPECT_EQ(failure->x, grid.position(0, 7));
  EXPECT_EQ(failure->state, std::vector<double>{0.9});
  for (int i = 0; i < 11; ++i) {
    if (i == 7) continue;
    // The smaller root of v^2/2 - v + u + u^2/2 = 0.
    const double a = u.at(0, i) + 0.5 * u.at(0, i) * u.at(0, i);
    EXPECT_NEAR(v.at(0, i), 1.0 - std::sqrt(1.0 - 2.0 * a), 1e-12) << i;
  }
}

TEST(CrankNicolsonTest, MultipliesModesOfTheDifferencesByTheRulesFactor) {
  const Communicator self(MPI_COMM_SELF);
  const ModelKernelsOf<Square> model({});
  const int n = 33;
  for (int order : {2, 4, 8}) {
    testing::DiffusionProblem p(self, testing::unit_grid(n, 0, testing::neumann),
                                {testing::both_sides(BoundaryKind::neumann, 1), testing::both_sides(BoundaryKind::neumann, 1)}, {0.3},
                                order);
    CoupledRhs rhs(p.decomposition, p.diffusion, model);
    CrankNicolson flow(p.field(), rhs, 1e-14);
    for (int k : {1, 9, 25}) {
      const auto mode = [&](int, double x, double) { return std::cos(M_PI * k * x); };
      Field u = p.field(mode);
      Field slope = u.similar();
      rhs.evaluate_without_rates(0.0, u, slope);
      const double lambda = slope.at(0, 0) / u.at(0, 0);
      const double dt = 0.05;
      Work work;
      ASSERT_FALSE(flow.advance(0.0, dt, u, u, work));
      const double factor = (1.0 + 0.5 * dt * lambda) / (1.0 - 0.5 * dt * lambda);
      for (int i = 0; i < n; ++i)
        EXPECT_NEAR(u.at(0, i), factor * mode(0, p.grid.position(0, i), 0.0), 1e-11) << order << " " << k << " " << i;
    }
  }
}

TEST(CrankNicolsonTest, IsRefusedInTwoDimensions) {
  const Communicator self(MPI_COMM_SELF);
  const ModelKernelsOf<Square> model({});
  testing::DiffusionProblem p(self, testing::unit_grid(9, 9, testing::neumann),
                              {testing::both_sides(BoundaryKind::neumann, 1), testing::both_sides(BoundaryKind::neumann, 1)}, {0.3}, 2);
  CoupledRhs rhs(p.decomposition, p.diffusion, model);
  EXPECT_THROW(CrankNicolson(p.field(), rhs, 1e-10), Error);
}

}  // namespace
}  // namespace stiffront
