// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/model/space_expression.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "stiffront/core/mpi.hpp"

namespace stiffront {
namespace {

const std::map<std::string, double> parameters = {{"k", 3.0}};

TEST(SpaceExpressionTest, IsAFunctionOfTimeAndPlace) {
  const std::function<double(double, double, double)> f = SpaceExpression("k*sin(2*pi*x)*exp(-t) + y^2", parameters);
  EXPECT_DOUBLE_EQ(f(0.5, 0.1, 2.0), 3.0 * std::sin(0.2 * 3.141592653589793) * std::exp(-0.5) + 4.0);
  const SpaceExpression number(2.5, parameters);
  EXPECT_EQ(number(1.0, 2.0, 3.0), 2.5);
}

TEST(SpaceExpressionTest, KnowsWhetherTimeMatters) {
  EXPECT_TRUE(SpaceExpression("x*t", parameters).depends_on_time());
  EXPECT_FALSE(SpaceExpression("x + 0*t", parameters).depends_on_time());
}

TEST(SpaceExpressionTest, OperationsAreRoundedAsWritten) {
  // With a fused multiply-add, or x*(1/10) for x/10, these comparisons of equal numbers would fail.
  EXPECT_EQ(SpaceExpression("x*x + y*y <= 0.25", parameters)(0.0, 0.3, 0.4), 0.3 * 0.3 + 0.4 * 0.4 <= 0.25 ? 1.0 : 0.0);
  const SpaceExpression quotient("x/10", parameters);
  const SpaceExpression sum("x*y + k", parameters);
  for (int i = 1; i < 1000; ++i) {
    EXPECT_EQ(quotient(0.0, i, 0.0), i / 10.0);
    EXPECT_EQ(sum(0.0, 0.1 * i, 0.7), (0.1 * i) * 0.7 + 3.0);
  }
}

TEST(SpaceExpressionTest, FieldsTakeTheGridsOwnPositions) {
  const Communicator comm(MPI_COMM_SELF);
  Grid grid;
  grid.dimension = 2;
  grid.points = {11, 7};
  grid.lower = {-1.0, 2.0};
  grid.upper = {1.3, 3.1};
  const Decomposition d(comm, grid, {0, 0}, 1);
  Field u(d, 2, 1);
  evaluate(SpaceExpression("if(x >= 0.15, x, 0) + 1000*y + t", parameters), 0.5, u, 1);
  for (int j = 0; j < 7; ++j) {
    for (int i = 0; i < 11; ++i) {
      const double x = grid.position(0, i);
      EXPECT_EQ(u.at(0, i, j), 0.0);
      EXPECT_EQ(u.at(1, i, j), ((x >= 0.15 ? x : 0.0) + 1000.0 * grid.position(1, j)) + 0.5);
    }
  }
}

TEST(SpaceExpressionTest, SpeciesAreNotKnownThere) {
  try {
    SpaceExpression("u + x", parameters);
    FAIL();
  } catch (const ExpressionError& e) {
    EXPECT_STREQ(e.what(), "column 1: unknown name \"u\"; allowed: t, x, y, k, pi, e");
  }
}

TEST(ConstantExpressionTest, HasParametersOnly) {
  EXPECT_EQ(constant_expression("2*k^2", parameters), 18.0);
  EXPECT_EQ(constant_expression(0.25, parameters), 0.25);
  EXPECT_THROW(constant_expression("x", parameters), ExpressionError);
  EXPECT_THROW(constant_expression("1/(k - 3)", parameters), ExpressionError);
  EXPECT_THROW(constant_expression(INFINITY, parameters), ExpressionError);
}

}  // namespace
}  // namespace stiffront
