// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "stiffront/solvers/implicit_part.hpp"
#include "stiffront/solvers/model_kernels.hpp"
#include "support/coupled_model.hpp"
#include "support/diffusion_problem.hpp"
#include "support/grids.hpp"

namespace stiffront {
namespace {

using testing::Coupled;
using testing::scatter;
using testing::Sides;

Field solution(const Decomposition& d, const Boundary& boundary, double tolerance) {
  const DiffusionOperator diffusion(d.grid(), boundary, {3.0, 0.4}, 2);
  const ModelKernelsOf<Coupled> model({});
  Field at(d, 2, 1);
  Field b(d, 2, 1);
  for (int s = 0; s < 2; ++s) {
    for (int j = 0; j < b.n_y(); ++j) {
      for (int i = 0; i < b.n_x(); ++i) {
        at.at(s, i, j) = scatter(d.offset_x() + i, d.offset_y() + j, s);
        b.at(s, i, j) = scatter(d.offset_x() + i, d.offset_y() + j, s + 7) - 0.3;
      }
    }
  }
  const auto part = make_multigrid_part(b, diffusion, model, {true, 2.0}, tolerance);
  Work work;
  part->solve(0.0, 0.02, at, b, work);
  return b;
}

TEST(ImplicitPlaneTest, SolutionsHaveTheSameBitsOnEveryLayout) {
  const Communicator world(MPI_COMM_WORLD);
  const Communicator self(MPI_COMM_SELF);
  for (const auto& [n_x, n_y] : {std::pair{101, 90}, {17, 22}}) {
    for (const Sides& x : testing::all_sides) {
      for (const Sides& y : testing::all_sides) {
        const Grid grid = testing::unit_grid(n_x, n_y, x, y);
        const Boundary boundary = testing::boundary_of(x, y, 2, testing::zero);
        const Decomposition alone(self, grid, {0, 0}, 1);
        for (double tolerance : {100.0, 1e-8}) {  // 100: a single V-cycle
          const Field expected = solution(alone, boundary, tolerance);
          for (int px = 1; px <= world.size(); ++px) {
            if (world.size() % px != 0) continue;
            const Decomposition shared(world, grid, {px, world.size() / px}, 1);
            const Field found = solution(shared, boundary, tolerance);
            int different = 0;
            for (int s = 0; s < 2; ++s) {
              for (int j = 0; j < found.n_y(); ++j) {
                for (int i = 0; i < found.n_x(); ++i) {
                  if (found.at(s, i, j) != expected.at(s, static_cast<int>(shared.offset_x()) + i, static_cast<int>(shared.offset_y()) + j))
                    ++different;
                }
              }
            }
            EXPECT_EQ(different, 0) << testing::name_of(x) << " x " << testing::name_of(y) << ", " << n_x << " x " << n_y << " points on "
                                    << px << " x " << world.size() / px << " ranks, tolerance " << tolerance;
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace stiffront
