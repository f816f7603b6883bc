// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "stiffront/model/model.hpp"
#include "support/grids.hpp"

namespace stiffront {
namespace {

TEST(PlaceTest, LanesStandAtTheirGridPointsAndSpareLanesAtTheLastOne) {
  const Communicator comm(MPI_COMM_SELF);
  Grid grid;
  grid.dimension = 2;
  grid.points = {37, 11};
  grid.lower = {-0.7, 0.3};
  grid.upper = {2.1, 0.9};
  const Decomposition d(comm, grid, {0, 0}, 1);
  for (int i = 0; i < 37; ++i) {
    for (int n = 1; n <= pack_size && i + n <= 37; ++n) {
      const Place<Pack> place = place_of_pack(d, 0.25, i, 7, n);
      for (int l = 0; l < pack_size; ++l) {
        EXPECT_EQ(place.t[l], 0.25);
        EXPECT_EQ(place.x[l], grid.position(0, i + (l < n ? l : n - 1)));
        EXPECT_EQ(place.y[l], grid.position(1, 7));
      }
    }
  }
}

TEST(PlaceTest, LanesStandAtSubCells) {
  const Communicator comm(MPI_COMM_SELF);
  const Grid grid = testing::unit_grid_of_order(8, 37, 0, testing::dirichlet);
  const Decomposition d(comm, grid, {0, 0}, 1);
  for (int i = 0; i < 39; ++i) {
    for (int n = 1; n <= pack_size && i + n <= 39; ++n) {
      const Place<Pack> place = place_of_pack(d, 0.25, i, 0, n);
      for (int l = 0; l < pack_size; ++l) EXPECT_EQ(place.x[l], grid.position(0, i + (l < n ? l : n - 1)));
    }
  }
}

TEST(PlaceTest, HasNoSecondCoordinateInOneDimension) {
  const Communicator comm(MPI_COMM_SELF);
  Grid grid;
  grid.points = {11, 1};
  const Decomposition d(comm, grid, {0, 0}, 1);
  EXPECT_EQ(place_of_pack(d, 0.0, 3, 0).y[0], 0.0);
}

}  // namespace
}  // namespace stiffront
