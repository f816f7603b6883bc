// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/solvers/block_tridiagonal.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "support/diffusion_problem.hpp"

namespace stiffront {
namespace {

using testing::scatter;
using testing::unit_grid;

/// A system of n points with rough data; `dominance` is added to the diagonal.
template <int m>
void fill(BlockTridiagonal<m>& solver, int n, bool periodic, double dominance, Eigen::MatrixXd& matrix, Eigen::VectorXd& right_side) {
  matrix = Eigen::MatrixXd::Zero(n * m, n * m);
  right_side.resize(n * m);
  for (int i = 0; i < n; ++i) {
    for (int r = 0; r < m; ++r) {
      for (int q = 0; q < m; ++q) {
        const double x = scatter(i, r, q) - 0.5 + (r == q ? dominance : 0.0);
        solver.diagonal(r, q)[i] = x;
        matrix(i * m + r, i * m + q) += x;
      }
      const bool first = i == 0 && !periodic;
      const bool last = i == n - 1 && !periodic;
      const double a = first ? 0.0 : scatter(i, r, 100) - 1.0;
      const double c = last ? 0.0 : scatter(i, r, 200) - 1.0;
      solver.lower(r)[i] = a;
      solver.upper(r)[i] = c;
      matrix(i * m + r, (i + n - 1) % n * m + r) += a;
      matrix(i * m + r, (i + 1) % n * m + r) += c;
      right_side[i * m + r] = scatter(i, r, 300);
    }
  }
}

template <int m>
void expect_solution(BlockTridiagonal<m>& solver, int n, const Eigen::VectorXd& expected, double tolerance) {
  double error = 0.0;
  for (int i = 0; i < n; ++i) {
    for (int r = 0; r < m; ++r) error = std::max(error, std::abs(solver.right_side(r)[i] - expected[i * m + r]));
  }
  EXPECT_LE(error, tolerance * expected.cwiseAbs().maxCoeff()) << n << " points, m = " << m;
}

template <int m>
void compare_with_dense(int n, bool periodic, double dominance, double tolerance) {
  const Communicator comm(MPI_COMM_SELF);
  const Decomposition d(comm, unit_grid(n, 1, periodic), {0, 0}, 1);
  BlockTridiagonal<m> solver(d, periodic);
  Eigen::MatrixXd matrix;
  Eigen::VectorXd b;
  fill(solver, n, periodic, dominance, matrix, b);
  const auto lu = matrix.partialPivLu();
  const auto load = [&](const Eigen::VectorXd& x) {
    for (int i = 0; i < n; ++i) {
      for (int r = 0; r < m; ++r) solver.right_side(r)[i] = x[i * m + r];
    }
  };
  load(b);
  solver.factor_and_solve();
  expect_solution(solver, n, lu.solve(b), tolerance);
  // The factors serve any number of right sides, and are what a separate factorisation makes.
  const Eigen::VectorXd other = b.array().square() - 0.3;
  load(other);
  solver.solve();
  expect_solution(solver, n, lu.solve(other), tolerance);
  load(b);
  solver.factor();
  solver.solve();
  expect_solution(solver, n, lu.solve(b), tolerance);
}

template <int m>
void all_sizes(double dominance, double tolerance) {
  for (bool periodic : {false, true}) {
    for (int n = 2; n <= 20; ++n) compare_with_dense<m>(n, periodic, dominance, tolerance);
    for (int n : {31, 32, 33, 65}) compare_with_dense<m>(n, periodic, dominance, tolerance);
  }
}

TEST(BlockTridiagonal, AgreesWithADenseSolverForAnySizeOnLinesAndRings) {
  all_sizes<1>(2.6, 1e-13);
  all_sizes<2>(3.0, 1e-13);
  all_sizes<3>(3.5, 1e-13);
  all_sizes<5>(4.5, 1e-13);
  all_sizes<8>(6.0, 1e-13);
}

TEST(BlockTridiagonal, NeedsNoDominanceWithinABlock) {
  // Blocks like those of a fast oscillation: nothing on their diagonal, large entries beside it.
  const int n = 77;
  const Communicator comm(MPI_COMM_SELF);
  const Decomposition d(comm, unit_grid(n, 1), {0, 0}, 1);
  BlockTridiagonal<2> solver(d, false);
  Eigen::MatrixXd matrix;
  Eigen::VectorXd b;
  fill(solver, n, false, 0.0, matrix, b);
  for (int i = 0; i < n; ++i) {
    for (int r = 0; r < 2; ++r) {
      for (int q = 0; q < 2; ++q) {
        const double x = r == q ? 0.0 : (r < q ? 5.0 : -5.0);
        solver.diagonal(r, q)[i] = x;
        matrix(i * 2 + r, i * 2 + q) = x;
      }
      solver.right_side(r)[i] = b[i * 2 + r];
    }
  }
  solver.factor_and_solve();
  expect_solution(solver, n, matrix.partialPivLu().solve(b), 1e-13);
}

TEST(BlockTridiagonal, ASingularMatrixGivesNumbersThatAreNotFinite) {
  const int n = 9;
  const Communicator comm(MPI_COMM_SELF);
  const Decomposition d(comm, unit_grid(n, 1), {0, 0}, 1);
  BlockTridiagonal<2> solver(d, false);
  for (int i = 0; i < n; ++i) solver.right_side(0)[i] = solver.right_side(1)[i] = 1.0;
  solver.factor_and_solve();
  EXPECT_FALSE(std::isfinite(solver.right_side(0)[4]));
  // It goes on with a good one.
  Eigen::MatrixXd matrix;
  Eigen::VectorXd b;
  fill(solver, n, false, 3.0, matrix, b);
  for (int i = 0; i < n; ++i) {
    for (int r = 0; r < 2; ++r) solver.right_side(r)[i] = b[i * 2 + r];
  }
  solver.factor_and_solve();
  expect_solution(solver, n, matrix.partialPivLu().solve(b), 1e-13);
}

}  // namespace
}  // namespace stiffront
