// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/mesh/grid.hpp"

#include <gtest/gtest.h>

#include "support/grids.hpp"

namespace stiffront {
namespace {

TEST(GridTest, EndPointsAreIncludedExceptTheUpperPeriodicOne) {
  Grid grid;
  grid.dimension = 2;
  grid.points = {11, 10};
  grid.lower = {-1.0, 2.0};
  grid.upper = {4.0, 7.0};
  grid.periodic = {false, true};
  EXPECT_EQ(grid.intervals(0), 10);
  EXPECT_EQ(grid.intervals(1), 10);
  EXPECT_EQ(grid.spacing(0), 0.5);
  EXPECT_EQ(grid.spacing(1), 0.5);
  EXPECT_EQ(grid.position(0, 0), -1.0);
  EXPECT_EQ(grid.position(0, 10), 4.0);
  EXPECT_EQ(grid.position(1, 9), 6.5);
  EXPECT_EQ(grid.total_points(), 110);
}

TEST(GridTest, FractionsAreExactAtBothEndsForAnySpacing) {
  for (int n = 2; n < 2000; ++n) {
    const Grid grid = testing::unit_grid(n, 0, testing::neumann);
    ASSERT_EQ(grid.fraction(0, 0), 0.0);
    ASSERT_EQ(grid.fraction(0, n - 1), 1.0);
    if (n % 2 == 1) {
      ASSERT_EQ(grid.fraction(0, n / 2), 0.5);
    }
  }
}

TEST(GridTest, FractionsOfAPeriodicGridStopBeforeTheEnd) {
  const Grid grid = testing::unit_grid(8, 0, testing::periodic);
  EXPECT_EQ(grid.fraction(0, 7), 0.875);
}

}  // namespace
}  // namespace stiffront
