// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/solvers/halo_depth.hpp"

#include <gtest/gtest.h>

#include "support/diffusion_problem.hpp"

namespace stiffront {
namespace {

using testing::both_sides;
using testing::DiffusionProblem;
using testing::unit_grid;

TEST(HaloDepth, AloneThereIsNothingToExchange) {
  const Communicator self(MPI_COMM_SELF);
  const DiffusionProblem p(self, unit_grid(64, 64), {both_sides(BoundaryKind::neumann, 1), both_sides(BoundaryKind::neumann, 1)}, {1.0}, 2);
  EXPECT_EQ(largest_halo_depth(p.decomposition, p.boundary, 1), 1);
  const HaloCost cost(p.decomposition, 1, 1e-6);
  EXPECT_EQ(cost.best_depth(1, 20, 3), 1);
}

/// A periodic plane on one rank has neighbours on all sides: itself.
class HaloCostOfABox : public ::testing::Test {
 protected:
  int best(std::int64_t points, double exchange, int variables = 3) {
    const Communicator self(MPI_COMM_SELF);
    const DiffusionProblem p(self, unit_grid(points, points, true, true),
                             {both_sides(BoundaryKind::periodic, 1), both_sides(BoundaryKind::periodic, 1)}, {1.0}, 2);
    return HaloCost(p.decomposition, 1, exchange).best_depth(8, 24, variables);
  }
};

TEST_F(HaloCostOfABox, SmallBoxesGoDeepAndLargerOnesDoNot) {
  EXPECT_GE(best(16, 5e-6), 4);
  EXPECT_EQ(best(240, 5e-6), 1) << "work on the interior hides the messages";
  EXPECT_GE(best(64, 20e-6), best(64, 2e-6)) << "slow messages make for depth";
  EXPECT_GE(best(32, 5e-6, 1), best(32, 5e-6, 12)) << "much work per point makes for shallow ones";
}

TEST_F(HaloCostOfABox, BoxesOutOfCacheGoDeepToSparePassesOverMemory) { EXPECT_EQ(best(1024, 5e-6), 8); }

TEST_F(HaloCostOfABox, WithoutLatencyOneStagePerExchangeIsBest) { EXPECT_EQ(best(32, 0.0), 1); }

}  // namespace
}  // namespace stiffront
