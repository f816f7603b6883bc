// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <vector>

#include "stiffront/solvers/block_tridiagonal.hpp"
#include "support/diffusion_problem.hpp"

namespace stiffront {
namespace {

using testing::scatter;
using testing::unit_grid;

/// Solutions of this rank's points for two right sides, one with and one after the factorisation.
template <int m>
std::vector<double> solve(const Decomposition& d, bool periodic, int gather_at_most) {
  BlockTridiagonal<m> solver(d, periodic, gather_at_most);
  const auto n = d.grid().points[0];
  std::vector<double> result;
  const auto right_side = [&](int salt) {
    for (int i = 0; i < d.n_x(); ++i) {
      for (int r = 0; r < m; ++r) solver.right_side(r)[i] = scatter(d.offset_x() + i, r, salt);
    }
  };
  const auto keep = [&] {
    for (int r = 0; r < m; ++r) {
      for (int i = 0; i < d.n_x(); ++i) result.push_back(solver.right_side(r)[i]);
    }
  };
  for (int i = 0; i < d.n_x(); ++i) {
    const auto at = d.offset_x() + i;
    for (int r = 0; r < m; ++r) {
      for (int q = 0; q < m; ++q) solver.diagonal(r, q)[i] = scatter(at, r, q) + (r == q ? 2.5 : 0.0);
      solver.lower(r)[i] = at == 0 && !periodic ? 0.0 : scatter(at, r, 100) - 1.2;
      solver.upper(r)[i] = at == n - 1 && !periodic ? 0.0 : scatter(at, r, 200) - 1.2;
    }
  }
  right_side(300);
  solver.factor_and_solve();
  keep();
  right_side(400);
  solver.solve();
  keep();
  solver.factor();
  right_side(300);
  solver.solve();
  keep();
  return result;
}

template <int m>
void compare(int n, bool periodic) {
  const Communicator world(MPI_COMM_WORLD);
  const Communicator self(MPI_COMM_SELF);
  const Grid grid = unit_grid(n, 1, periodic);
  const Decomposition alone(self, grid, {0, 0}, 1);
  const Decomposition shared(world, grid, {0, 0}, 1);
  const std::vector<double> expected = solve<m>(alone, periodic, 32);
  for (int gather_at_most : {32, 5, 1}) {
    const std::vector<double> got = solve<m>(shared, periodic, gather_at_most);
    const auto n_mine = static_cast<std::size_t>(shared.n_x());
    const auto offset = static_cast<std::size_t>(shared.offset_x());
    for (std::size_t block = 0; block < 3 * m; ++block) {
      for (std::size_t i = 0; i < n_mine; ++i) {
        ASSERT_EQ(got[block * n_mine + i], expected[block * static_cast<std::size_t>(n) + offset + i])
            << n << " points, m = " << m << (periodic ? ", ring" : ", line") << ", gathered at " << gather_at_most << ", array " << block
            << ", point " << offset + i;
      }
    }
  }
}

TEST(BlockTridiagonalMpi, TheBitsDoNotDependOnTheNumberOfRanksNorOnWhereRowsAreGathered) {
  for (bool periodic : {false, true}) {
    for (int n : {4, 5, 6, 7, 8, 9, 13, 16, 31, 33, 64, 101, 203, 512, 1001}) {
      compare<1>(n, periodic);
      compare<3>(n, periodic);
    }
    compare<2>(150, periodic);
    compare<5>(77, periodic);
  }
}

}  // namespace
}  // namespace stiffront
