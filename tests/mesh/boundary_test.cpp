// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/mesh/boundary.hpp"

#include <gtest/gtest.h>

#include "support/grids.hpp"

namespace stiffront {
namespace {

class BoundaryTest : public ::testing::Test {
 protected:
  const Communicator self{MPI_COMM_SELF};
};

double value(double t, double x, double y) { return 1000.0 * t + 10.0 * x + y; }

TEST_F(BoundaryTest, NaturalIsPeriodicWhereTheGridIsAndElseNeumann) {
  const Boundary b = Boundary::natural(testing::unit_grid(9, 9, testing::periodic, testing::neumann));
  for (int which = 0; which < 2; ++which) {
    EXPECT_EQ(b.side(0, which).kind, BoundaryKind::periodic);
    EXPECT_EQ(b.side(1, which).kind, BoundaryKind::neumann);
  }
  EXPECT_FALSE(b.has_dirichlet());
  EXPECT_FALSE(b.depends_on_time());
}

TEST_F(BoundaryTest, DirichletPointsAreNotFree) {
  for (const testing::Sides& x : testing::all_sides) {
    for (const testing::Sides& y : testing::all_sides) {
      const Grid grid = testing::unit_grid(9, 7, x, y);
      const Decomposition d(self, grid, {0, 0}, 1);
      const Boundary b = testing::boundary_of(x, y, 1, value);
      const FreeBox box = b.free_box(d);
      EXPECT_EQ(box.i_begin, x[0] == BoundaryKind::dirichlet ? 1 : 0);
      EXPECT_EQ(box.i_end, x[1] == BoundaryKind::dirichlet ? 8 : 9);
      EXPECT_EQ(box.j_begin, y[0] == BoundaryKind::dirichlet ? 1 : 0);
      EXPECT_EQ(box.j_end, y[1] == BoundaryKind::dirichlet ? 6 : 7);
      EXPECT_EQ(b.free_points(grid), (box.i_end - box.i_begin) * (box.j_end - box.j_begin));
      EXPECT_EQ(b.has_dirichlet(), b.free_points(grid) != 63);
    }
  }
  // One dimension has no y sides, whatever they are said to be.
  const Grid line = testing::unit_grid(9, 0, testing::mixed);
  const Boundary b = testing::boundary_of(testing::mixed, testing::dirichlet, 1, value);
  const FreeBox box = b.free_box(Decomposition(self, line, {0, 0}, 1));
  EXPECT_EQ(box.j_begin, 0);
  EXPECT_EQ(box.j_end, 1);
  EXPECT_EQ(b.free_points(line), 8);
}

TEST_F(BoundaryTest, ImposeSetsDirichletPointsAndNoOthers) {
  for (const testing::Sides& x : testing::all_sides) {
    for (const testing::Sides& y : testing::all_sides) {
      const Grid grid = testing::unit_grid(9, 7, x, y);
      const Decomposition d(self, grid, {0, 0}, 1);
      const Boundary b = testing::boundary_of(x, y, 2, value);
      const FreeBox box = b.free_box(d);
      Field u(d, 2, 2);
      for (const double t : {0.0, 0.5}) {
        b.impose(u, t);
        for (int s = 0; s < 2; ++s) {
          for (int j = -2; j < 9; ++j) {
            for (int i = -2; i < 11; ++i) {
              const bool in_grid = i >= 0 && i < 9 && j >= 0 && j < 7;
              const bool free = i >= box.i_begin && i < box.i_end && j >= box.j_begin && j < box.j_end;
              ASSERT_EQ(u.at(s, i, j), in_grid && !free ? value(t, grid.position(0, i), grid.position(1, j)) : 0.0) << i << ", " << j;
            }
          }
        }
      }
    }
  }
}

TEST_F(BoundaryTest, EverySpeciesHasItsOwnValueAndCornersBelongToTheXSide) {
  std::array<std::array<BoundarySide, 2>, 2> sides;
  for (std::size_t direction = 0; direction < 2; ++direction) {
    for (std::size_t which = 0; which < 2; ++which) {
      sides[direction][which].kind = BoundaryKind::dirichlet;
      for (int s = 0; s < 2; ++s) {
        sides[direction][which].values.push_back(
            [=](double, double, double) { return 100.0 * static_cast<double>(direction) + 10.0 * static_cast<double>(which) + s; });
      }
    }
  }
  const Boundary b(sides);
  const Decomposition d(self, testing::unit_grid(5, 4, testing::dirichlet, testing::dirichlet), {0, 0}, 1);
  Field u(d, 2, 1);
  b.impose(u, 0.0);
  for (int s = 0; s < 2; ++s) {
    for (int j = 0; j < 4; ++j) {
      EXPECT_EQ(u.at(s, 0, j), 0.0 + s);
      EXPECT_EQ(u.at(s, 4, j), 10.0 + s);
    }
    for (int i = 1; i < 4; ++i) {
      EXPECT_EQ(u.at(s, i, 0), 100.0 + s);
      EXPECT_EQ(u.at(s, i, 3), 110.0 + s);
    }
  }
}

TEST_F(BoundaryTest, DependsOnTimeIfAnySideDoes) {
  std::array<std::array<BoundarySide, 2>, 2> sides;
  sides[1][1].depends_on_time = true;
  EXPECT_FALSE(Boundary(sides).depends_on_time()) << "a Neumann side has no values";
  sides[1][1].kind = BoundaryKind::dirichlet;
  sides[1][1].values = {value};
  EXPECT_TRUE(Boundary(sides).depends_on_time());
}

}  // namespace
}  // namespace stiffront
