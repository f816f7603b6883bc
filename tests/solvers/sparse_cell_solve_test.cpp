// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/solvers/sparse_cell_solve.hpp"

#include <gtest/gtest.h>

#include <random>

namespace stiffront {
namespace {

/// Diagonally dominant systems with a known solution, a third of the entries known to be zero.
template <int m>
void expect_solved() {
  std::mt19937_64 random(m);
  std::uniform_real_distribution<double> entry(-1.0, 1.0);
  for (int repeat = 0; repeat < 50; ++repeat) {
    Sparse<Pack> a[m][m];
    Sparse<Pack> b[m];
    double x[m][pack_size];
    for (int i = 0; i < m; ++i) {
      for (int l = 0; l < pack_size; ++l) x[i][l] = entry(random);
    }
    for (int i = 0; i < m; ++i) {
      Pack right(0.0);
      for (int j = 0; j < m; ++j) {
        if (i != j && (i + 2 * j + repeat) % 3 == 0) {
          a[i][j] = Sparse<Pack>::known_zero();
          continue;
        }
        Pack v;
        for (int l = 0; l < pack_size; ++l) v.set(l, (i == j ? m : 0.0) + entry(random));
        a[i][j] = v;
        right += v * Pack::load(x[j]);
      }
      b[i] = right;
    }
    sparse_cell_solve(a, b);
    for (int i = 0; i < m; ++i) {
      for (int l = 0; l < pack_size; ++l) EXPECT_NEAR(b[i].value[l], x[i][l], 1e-13) << "m = " << m;
    }
  }
}

TEST(SparseCellSolve, SolvesSystemsOfOneToEightUnknowns) {
  expect_solved<1>();
  expect_solved<2>();
  expect_solved<3>();
  expect_solved<4>();
  expect_solved<5>();
  expect_solved<6>();
  expect_solved<7>();
  expect_solved<8>();
}

TEST(SparseCellSolve, ASingularMatrixGivesNoFiniteSolution) {
  Sparse<Pack> a[2][2] = {{Pack(1.0), Pack(2.0)}, {Pack(2.0), Pack(4.0)}};
  Sparse<Pack> b[2] = {Pack(1.0), Pack(1.0)};
  sparse_cell_solve(a, b);
  EXPECT_FALSE(std::isfinite(b[0].value[0]));
}

}  // namespace
}  // namespace stiffront
