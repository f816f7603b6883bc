// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/diagonal_preconditioner.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace stiffront {
namespace {

TEST(DiagonalPreconditionerTest, SweepsOfTheStiffLimitReachCollocationInAsManyAsThereAreNodes) {
  for (int m = 1; m <= 8; ++m) {
    const std::vector<double> d = min_sr_s(m);
    const CollocationNodes nodes = collocation_nodes(NodeFamily::gauss_radau, m);
    const auto n = static_cast<std::size_t>(m);
    ASSERT_EQ(d.size(), n);
    // (1 - diag(1/d) S)^m, column by column.
    double largest = 0.0;
    for (std::size_t column = 0; column < n; ++column) {
      std::vector<double> v(n, 0.0);
      v[column] = 1.0;
      for (int sweep = 0; sweep < m; ++sweep) {
        std::vector<double> next = v;
        for (std::size_t i = 0; i < n; ++i) {
          for (std::size_t a = 0; a < n; ++a) next[i] -= nodes.s[i][a] / d[i] * v[a];
        }
        v = next;
      }
      for (double x : v) largest = std::max(largest, std::abs(x));
    }
    EXPECT_LT(largest, 1e-9) << m << " nodes";
  }
}

TEST(DiagonalPreconditionerTest, CoefficientsArePositiveAndGrowWithTheNodesButStayBelowThem) {
  for (int m = 2; m <= 8; ++m) {
    const std::vector<double> d = min_sr_s(m);
    const std::vector<double> c = collocation_nodes(NodeFamily::gauss_radau, m).c;
    EXPECT_GT(d[0], 0.0);
    for (std::size_t i = 0; i < d.size(); ++i) EXPECT_LT(d[i], c[i]) << m << " nodes";
    EXPECT_TRUE(std::is_sorted(d.begin(), d.end())) << m << " nodes";
  }
}

// Two nodes, 1/3 and 1: with x_i = 1/d_i the equations 5 x_1/12 + x_2/4 = 2 and x_1 x_2/6 = 1.
TEST(DiagonalPreconditionerTest, TwoNodesHaveTheSolutionOfTheirQuadraticEquation) {
  const std::vector<double> d = min_sr_s(2);
  const double x_1 = (2.0 + std::sqrt(1.5)) / (5.0 / 6.0);  // 5 x^2/12 - 2 x + 3/2 = 0
  EXPECT_NEAR(d[0], 1.0 / x_1, 1e-14);
  EXPECT_NEAR(d[1], x_1 / 6.0, 1e-14);
}

}  // namespace
}  // namespace stiffront
