// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "stiffront/core/error.hpp"
#include "stiffront/mesh/decomposition.hpp"
#include "support/grids.hpp"

namespace stiffront {
namespace {

class DecompositionMpiTest : public ::testing::Test {
 protected:
  /// The message of the input error that the decomposition must be.
  std::string refusal(const Grid& grid, std::array<int, 2> processes, int min_points) const {
    try {
      const Decomposition d(world, grid, processes, min_points);
      ADD_FAILURE() << "was accepted";
    } catch (const Error& e) {
      EXPECT_EQ(e.kind(), ErrorKind::input);
      // Every rank throws the same: what root says is what all say.
      EXPECT_EQ(world.broadcast(e.what()), e.what());
      return e.what();
    }
    return "";
  }

  std::vector<std::array<int, 2>> layouts() const {
    std::vector<std::array<int, 2>> all;
    for (int p = 1; p <= world.size(); ++p) {
      if (world.size() % p == 0) all.push_back({p, world.size() / p});
    }
    return all;
  }

  const Communicator world{MPI_COMM_WORLD};
};

TEST_F(DecompositionMpiTest, BoxesCoverTheGridOnceAndDifferByOnePointAtMost) {
  for (const auto& layout : layouts()) {
    for (int n_x = layout[0]; n_x < layout[0] + 9; ++n_x) {
      for (int n_y = layout[1]; n_y < layout[1] + 9; ++n_y) {
        const Decomposition d(world, testing::unit_grid(n_x, n_y, testing::neumann), layout, 1);
        ASSERT_EQ(d.processes(), layout);
        std::vector<int> covered(static_cast<std::size_t>(n_x * n_y), 0);
        std::array<std::int64_t, 2> smallest{1000, 1000};
        std::array<std::int64_t, 2> largest{0, 0};
        for (int r = 0; r < world.size(); ++r) {
          const auto box = d.box_of(r);
          for (std::size_t k = 0; k < 2; ++k) {
            smallest[k] = std::min(smallest[k], box[2 + k]);
            largest[k] = std::max(largest[k], box[2 + k]);
          }
          for (std::int64_t j = box[1]; j < box[1] + box[3]; ++j) {
            for (std::int64_t i = box[0]; i < box[0] + box[2]; ++i) ++covered.at(static_cast<std::size_t>(j * n_x + i));
          }
        }
        ASSERT_TRUE(std::all_of(covered.begin(), covered.end(), [](int c) { return c == 1; })) << n_x << " x " << n_y;
        for (std::size_t k = 0; k < 2; ++k) ASSERT_LE(largest[k] - smallest[k], 1) << n_x << " x " << n_y;
        const std::array<std::int64_t, 4> mine{d.offset_x(), d.offset_y(), d.n_x(), d.n_y()};
        ASSERT_EQ(d.box_of(world.rank()), mine);
      }
    }
  }
}

TEST_F(DecompositionMpiTest, NeighboursAreWhereTheirBoxesAre) {
  for (const auto& layout : layouts()) {
    for (const testing::Sides& x : {testing::periodic, testing::neumann}) {
      for (const testing::Sides& y : {testing::periodic, testing::neumann}) {
        const Grid grid = testing::unit_grid(23, 17, x, y);
        const Decomposition d(world, grid, layout, 1);
        for (int dy = -1; dy <= 1; ++dy) {
          for (int dx = -1; dx <= 1; ++dx) {
            // The point just beyond this box in that direction, wrapped where the grid is periodic.
            std::int64_t i = dx < 0 ? d.offset_x() - 1 : (dx > 0 ? d.offset_x() + d.n_x() : d.offset_x());
            std::int64_t j = dy < 0 ? d.offset_y() - 1 : (dy > 0 ? d.offset_y() + d.n_y() : d.offset_y());
            if (grid.periodic[0]) i = (i + 23) % 23;
            if (grid.periodic[1]) j = (j + 17) % 17;
            int owner = MPI_PROC_NULL;
            for (int r = 0; r < world.size(); ++r) {
              const auto box = d.box_of(r);
              if (i >= box[0] && i < box[0] + box[2] && j >= box[1] && j < box[1] + box[3]) owner = r;
            }
            ASSERT_EQ(d.neighbour(dx, dy), owner) << dx << ", " << dy;
          }
        }
        for (int side = 0; side < 2; ++side) {
          EXPECT_EQ(d.at_boundary(0, side), d.neighbour(2 * side - 1, 0) == MPI_PROC_NULL);
          EXPECT_EQ(d.at_boundary(1, side), d.neighbour(0, 2 * side - 1) == MPI_PROC_NULL);
        }
      }
    }
  }
}

TEST_F(DecompositionMpiTest, GridProcessesAreHonouredInFullAndInPart) {
  const int p = world.size();
  const Grid grid = testing::unit_grid(100, 50, testing::neumann);
  for (const auto& layout : layouts()) {
    EXPECT_EQ(Decomposition(world, grid, layout, 1).processes(), layout);
    EXPECT_EQ(Decomposition(world, grid, {layout[0], 0}, 1).processes(), layout);
    EXPECT_EQ(Decomposition(world, grid, {0, layout[1]}, 1).processes(), layout);
  }
  EXPECT_EQ(Decomposition(world, testing::unit_grid(100, 0, testing::neumann), {0, 0}, 1).processes(), (std::array<int, 2>{p, 1}));
  EXPECT_EQ(Decomposition(world, testing::unit_grid(100, 0, testing::neumann), {p, 0}, 1).processes(), (std::array<int, 2>{p, 1}));
}

TEST_F(DecompositionMpiTest, TheChosenLayoutHasTheFewestHaloPoints) {
  const int p = world.size();
  // Cuts across the longer direction cost fewer points.
  EXPECT_EQ(Decomposition(world, testing::unit_grid(400, 10, testing::neumann), {0, 0}, 1).processes(), (std::array<int, 2>{p, 1}));
  EXPECT_EQ(Decomposition(world, testing::unit_grid(10, 400, testing::neumann), {0, 0}, 1).processes(), (std::array<int, 2>{1, p}));
  if (p == 4) {
    EXPECT_EQ(Decomposition(world, testing::unit_grid(50, 50, testing::neumann), {0, 0}, 1).processes(), (std::array<int, 2>{2, 2}));
    // One cut each way is 50 + 30 points, three across x are 90, three across y 150.
    EXPECT_EQ(Decomposition(world, testing::unit_grid(50, 30, testing::neumann), {0, 0}, 1).processes(), (std::array<int, 2>{2, 2}));
    // Periodic directions are cut once more, unless they are not cut at all: two each way are 200, four across x 120.
    EXPECT_EQ(Decomposition(world, testing::unit_grid(70, 30, testing::periodic, testing::periodic), {0, 0}, 1).processes(),
              (std::array<int, 2>{4, 1}));
  }
  if (p == 2) {
    // The longest rows win a tie.
    EXPECT_EQ(Decomposition(world, testing::unit_grid(50, 50, testing::neumann), {0, 0}, 1).processes(), (std::array<int, 2>{1, 2}));
  }
}

TEST_F(DecompositionMpiTest, ALayoutWithTooSmallBoxesIsNotChosen) {
  const int p = world.size();
  // The direction that has room is cut.
  EXPECT_EQ(Decomposition(world, testing::unit_grid(4, 4 * p, testing::neumann), {0, 0}, 4).processes(), (std::array<int, 2>{1, p}));
  EXPECT_EQ(Decomposition(world, testing::unit_grid(4 * p, 4, testing::neumann), {0, 0}, 4).processes(), (std::array<int, 2>{p, 1}));
  if (p > 1) {
    const std::string message = refusal(testing::unit_grid(4 * p - 1, 4, testing::neumann), {0, 0}, 4);
    EXPECT_NE(message.find(std::to_string(4 * p - 1) + " x 4 grid points"), std::string::npos) << message;
    EXPECT_NE(message.find(std::to_string(p) + " ranks"), std::string::npos) << message;
    EXPECT_NE(message.find("at least 4 points"), std::string::npos) << message;
    // A layout asked for is not exchanged for one that fits.
    const std::string asked = refusal(testing::unit_grid(4, 4 * p, testing::neumann), {p, 1}, 4);
    EXPECT_NE(asked.find("as [" + std::to_string(p) + ", 1]"), std::string::npos) << asked;
  }
}

TEST_F(DecompositionMpiTest, MoreRanksThanPointsIsAnErrorThatNamesBoth) {
  const int p = world.size();
  if (p == 1) return;
  for (const Grid& grid : {testing::unit_grid(p - 1, 0, testing::periodic), testing::unit_grid(1, p - 1, testing::periodic)}) {
    const std::string message = refusal(grid, {0, 0}, 1);
    EXPECT_NE(message.find(std::to_string(p - 1) + " grid points"), std::string::npos) << message;
    EXPECT_NE(message.find(std::to_string(p) + " ranks"), std::string::npos) << message;
    EXPECT_EQ(message.rfind("grid.points: ", 0), 0U) << message;
  }
}

TEST_F(DecompositionMpiTest, ALayoutForAnotherNumberOfRanksIsAnErrorThatNamesBoth) {
  const int p = world.size();
  const std::string but = " asked for, but the program runs on " + std::to_string(p) + (p == 1 ? " rank" : " ranks");
  const Grid plane = testing::unit_grid(100, 100, testing::neumann);
  EXPECT_EQ(refusal(plane, {2, 3}, 1), "grid.processes: [2, 3]" + but);
  EXPECT_EQ(refusal(plane, {5, 0}, 1), "grid.processes: [5, 0]" + but);
  EXPECT_EQ(refusal(plane, {0, 7}, 1), "grid.processes: [0, 7]" + but);
  EXPECT_EQ(refusal(plane, {-1, 0}, 1), "grid.processes: [-1, 0]" + but);
  EXPECT_EQ(refusal(testing::unit_grid(100, 0, testing::neumann), {p + 1, 0}, 1), "grid.processes: [" + std::to_string(p + 1) + "]" + but);
}

TEST_F(DecompositionMpiTest, ManyPointsDoNotOverflow) {
  // 2^33 points in a grid that is never allocated.
  const Grid grid = testing::unit_grid(1 << 20, 1 << 13, testing::neumann);
  EXPECT_EQ(grid.total_points(), std::int64_t{1} << 33);
  for (const auto& layout : layouts()) {
    const Decomposition d(world, grid, layout, 1);
    std::int64_t points = 0;
    for (int r = 0; r < world.size(); ++r) points += d.box_of(r)[2] * d.box_of(r)[3];
    EXPECT_EQ(points, grid.total_points());
  }
  Grid line;
  line.points = {std::int64_t{1} << 40, 1};
  EXPECT_NE(refusal(line, {0, 0}, 1).find("use more ranks"), std::string::npos);
}

}  // namespace
}  // namespace stiffront
