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

TEST(GridTest, SubCellsAreNoPointsOfTheUniformGrid) {
  const Grid grid = testing::unit_grid_of_order(8, 11, 0, testing::dirichlet);
  ASSERT_EQ(grid.points[0], 13);
  EXPECT_EQ(grid.intervals(0), 10);
  EXPECT_EQ(grid.spacing(0), 0.1);
  const double places[] = {0.0, 0.2, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 9.8, 10.0};
  for (int i = 0; i < 13; ++i) {
    EXPECT_EQ(grid.place(0, i), places[i]);
    EXPECT_EQ(grid.position(0, i), places[i] * 0.1);
    EXPECT_EQ(grid.is_sub_cell(0, i), i == 1 || i == 11);
  }
  EXPECT_EQ(grid.fraction(0, 12), 1.0);
  const Grid uniform = grid.uniform();
  EXPECT_EQ(uniform.points[0], 11);
  for (int k = 0; k < 11; ++k) {
    EXPECT_EQ(grid.uniform_index(0, grid.index_of_uniform(0, k)), k);
    EXPECT_EQ(grid.position(0, grid.index_of_uniform(0, k)), uniform.position(0, k));
  }
  const Grid mixed = testing::unit_grid_of_order(8, 11, 0, testing::mixed);
  EXPECT_EQ(mixed.points[0], 12);
  EXPECT_EQ(mixed.position(0, 11), 1.0);
}

}  // namespace
}  // namespace stiffront
