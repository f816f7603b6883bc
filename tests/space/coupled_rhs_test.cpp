// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/space/coupled_rhs.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "stiffront/model/builtin/fitzhugh_nagumo.hpp"
#include "stiffront/solvers/model_kernels.hpp"
#include "support/diffusion_problem.hpp"
#include "support/grids.hpp"

namespace stiffront {
namespace {

using testing::Sides;

TEST(CoupledRhsTest, IsDiffusionPlusReactionAtFreePointsAndZeroAtFixedOnes) {
  const Communicator self(MPI_COMM_SELF);
  const ModelKernelsOf<FitzhughNagumo> model(std::map<std::string, double>{});
  for (const int order : {2, 4}) {
    for (const Sides& x : testing::all_sides) {
      for (const Sides& y : testing::all_sides) {
        const Grid grid = testing::unit_grid(17, 12, x, y);
        const Decomposition d(self, grid, {0, 0}, 1);
        const Boundary boundary = testing::boundary_of(x, y, 2, testing::zero);
        const DiffusionOperator diffusion(grid, boundary, {0.3, 0.0}, order);
        CoupledRhs rhs(d, diffusion, model);
        Field u(d, 2, diffusion.halo_width());
        Field du = u.similar();
        for (int s = 0; s < 2; ++s) {
          for (int j = 0; j < 12; ++j) {
            for (int i = 0; i < 17; ++i) u.at(s, i, j) = testing::scatter(i, j, s);
          }
        }
        // Nobody needs the halo of a species that does not diffuse.
        u.at(1, -1, 3) = u.at(1, 17, 3) = std::numeric_limits<double>::quiet_NaN();
        const auto garbage = [&] {
          for (int s = 0; s < 2; ++s) {
            for (int j = 0; j < 12; ++j) std::fill(du.row(s, j), du.row(s, j) + 17, 99.0);
          }
        };
        garbage();
        rhs.evaluate(0.0, u, du);
        Field diffused = u.similar();
        diffusion.apply(u, diffused, boundary.free_box(d));  // the halo of u is up to date now
        for (int j = 0; j < 12; ++j) {
          for (int i = 0; i < 17; ++i) {
            const FreeBox& box = rhs.free_box();
            const bool free = i >= box.i_begin && i < box.i_end && j >= box.j_begin && j < box.j_end;
            const double cell[2] = {u.at(0, i, j), u.at(1, i, j)};
            double rates[2];
            model.rates_at(0.0, grid.position(0, i), grid.position(1, j), cell, rates);
            for (int s = 0; s < 2; ++s) {
              ASSERT_EQ(du.at(s, i, j), free ? diffused.at(s, i, j) + rates[s] : 0.0) << s << " at " << i << ", " << j;
            }
          }
        }
        EXPECT_EQ(rhs.evaluations(), 1);
      }
    }
  }
}

TEST(CoupledRhsTest, AnExactSteadyStateStaysOne) {
  // u = v = 0 is the rest state of the nerve equations.
  const Communicator self(MPI_COMM_SELF);
  const ModelKernelsOf<FitzhughNagumo> model(std::map<std::string, double>{});
  const Grid grid = testing::unit_grid(33, 0, testing::neumann);
  const Decomposition d(self, grid, {0, 0}, 1);
  const Boundary boundary = Boundary::natural(grid);
  const DiffusionOperator diffusion(grid, boundary, {1.0, 0.0}, 4);
  CoupledRhs rhs(d, diffusion, model);
  Field u(d, 2, 2);
  Field du(d, 2, 2);
  rhs.evaluate(0.0, u, du);
  for (int i = 0; i < 33; ++i) {
    EXPECT_EQ(du.at(0, i), 0.0);
    EXPECT_EQ(du.at(1, i), 0.0);
  }
}

}  // namespace
}  // namespace stiffront
