// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/core/sparse_dual.hpp"

#include <gtest/gtest.h>

#include "stiffront/core/dual.hpp"

namespace stiffront {
namespace {

/// f(x, y) by sparse duals against f by full ones, in all lanes.
template <class F>
void expect_same(F f, double x, double y, const char* what) {
  using S = SparseDual<Pack, 2>;
  using D = Dual<Pack, 2>;
  Pack px(x);
  px.set(0, 0.75 * x);
  const S s = f(S::variable(px, 0), S::variable(Pack(y), 1));
  const D d = f(D::variable(px, 0), D::variable(Pack(y), 1));
  for (int l = 0; l < pack_size; ++l) {
    EXPECT_EQ(s.value[l], d.value[l]) << what;
    for (int i = 0; i < 2; ++i) {
      const double expected = d.derivative[i][l];
      EXPECT_NEAR(s.derivative[i].value[l], expected, 1e-15 * std::abs(expected)) << what << " derivative " << i;
    }
  }
}

#define EXPECT_SAME(expression) \
  expect_same([](const auto& x, const auto& y) -> std::remove_cvref_t<decltype(x)> { return expression; }, 0.7, 1.9, #expression)

TEST(SparseDual, HasTheDerivativesOfAFullDual) {
  EXPECT_SAME(x + y);
  EXPECT_SAME(x - y);
  EXPECT_SAME(x * y);
  EXPECT_SAME(x / y);
  EXPECT_SAME(-x + +y);
  EXPECT_SAME(2.0 * x + y * 3.0 - 1.0 + (0.5 - x) / 4.0);
  EXPECT_SAME(1.0 / (1.0 + x * x * y));
  EXPECT_SAME(exp(x * y) * sin(x) - cos(y));
  EXPECT_SAME(log(x) + log10(y) + sqrt(x * y));
  EXPECT_SAME(tan(x) + asin(x) - acos(x) + atan(y));
  EXPECT_SAME(sinh(x) * cosh(y) + tanh(x - y));
  EXPECT_SAME(pow(x, 2.5) + pow(1.5, y) + pow(x, y));
  EXPECT_SAME(min(x, y) + max(x * x, y) + abs(x - y));
  EXPECT_SAME(select(x < y, x * y, x + 0.0 * y));
}

TEST(SparseDual, KnowsWhichDerivativesAreZeroOrOneWhateverTheData) {
  using S = SparseDual<Pack, 3>;
  const S x = S::variable(Pack(2.0), 0);
  const S y = S::variable(Pack(3.0), 1);
  const S f = x * y - x;
  EXPECT_EQ(f.derivative[0].kind, Sparse<Pack>::any);
  EXPECT_EQ(f.derivative[1].kind, Sparse<Pack>::any);
  EXPECT_TRUE(f.derivative[2].is_zero());
  EXPECT_EQ((y - x).derivative[1].kind, Sparse<Pack>::one);
  EXPECT_TRUE(S(Pack(5.0)).derivative[0].is_zero());
}

TEST(SparseDual, AZeroHidesInfinitiesThatAFullDualMakesNotANumber) {
  using S = SparseDual<double, 2>;
  const S x = S::variable(1e200, 0);
  const S f = x * x;  // overflows
  EXPECT_EQ(f.derivative[1].value, 0.0);
}

}  // namespace
}  // namespace stiffront
