// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/core/simd.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace stiffront {
namespace {

constexpr double inf = std::numeric_limits<double>::infinity();
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Different in each lane, with inexact products and quotients.
Pack numbers(double start) {
  Pack r;
  for (int l = 0; l < pack_size; ++l) r.set(l, start + std::sqrt(2.0) * l - (l % 2 == 0 ? 0.0 : 3.3));
  return r;
}

TEST(Simd, ArithmeticIsThatOfEachLane) {
  const Pack a = numbers(0.7);
  const Pack b = numbers(-1.9);
  Pack compound = a;
  compound += b;
  compound *= a;
  compound -= b;
  compound /= a;
  for (int l = 0; l < pack_size; ++l) {
    EXPECT_EQ((a + b)[l], a[l] + b[l]);
    EXPECT_EQ((a - b)[l], a[l] - b[l]);
    EXPECT_EQ((a * b)[l], a[l] * b[l]);
    EXPECT_EQ((a / b)[l], a[l] / b[l]);
    EXPECT_EQ((-a)[l], -a[l]);
    EXPECT_EQ((+a)[l], a[l]);
    EXPECT_EQ(abs(a)[l], std::abs(a[l]));
    EXPECT_EQ(sqrt(abs(a))[l], std::sqrt(std::abs(a[l])));
    EXPECT_EQ(compound[l], ((a[l] + b[l]) * a[l] - b[l]) / a[l]);
    EXPECT_EQ(min(a, b)[l], std::min(a[l], b[l]));
    EXPECT_EQ(max(a, b)[l], std::max(a[l], b[l]));
  }
}

TEST(Simd, NegationAndBroadcastKeepTheSignOfZero) {
  EXPECT_TRUE(std::signbit((-Pack(0.0))[0]));
  EXPECT_FALSE(std::signbit((-Pack(-0.0))[pack_size - 1]));
  for (int l = 0; l < pack_size; ++l) EXPECT_TRUE(std::signbit(Pack(-0.0)[l]));
}

TEST(Simd, MultiplyAddIsFusedWhereTheTargetFuses) {
  const double x = 1.0 + 0x1p-30;
  const Pack r = mul_add(Pack(x), Pack(x), Pack(-1.0));
  const Pack n = neg_mul_add(Pack(x), Pack(x), Pack(1.0));
#if defined(__FMA__)
  EXPECT_EQ(r[0], std::fma(x, x, -1.0));
  EXPECT_NE(r[0], x * x - 1.0);
#else
  EXPECT_EQ(r[0], x * x - 1.0);
#endif
  for (int l = 0; l < pack_size; ++l) {
    EXPECT_EQ(r[l], mul_add(x, x, -1.0));
    EXPECT_EQ(n[l], -r[l]);
    EXPECT_EQ(n[l], neg_mul_add(x, x, 1.0));
  }
}

TEST(Simd, ComparisonsAndSelectionGoByLaneAndAreFalseForNan) {
  Pack a = numbers(0.0);
  Pack b = Pack(0.5);
  a.set(0, nan);
  a.set(1, 0.5);
  for (int l = 0; l < pack_size; ++l) {
    EXPECT_EQ((a < b)[l], a[l] < b[l]);
    EXPECT_EQ((a <= b)[l], a[l] <= b[l]);
    EXPECT_EQ((a > b)[l], a[l] > b[l]);
    EXPECT_EQ((a >= b)[l], a[l] >= b[l]);
    EXPECT_EQ((a == b)[l], a[l] == b[l]);
    EXPECT_EQ((a != b)[l], a[l] != b[l]);
    EXPECT_EQ(select(a < b, Pack(1.0), Pack(2.0))[l], a[l] < b[l] ? 1.0 : 2.0);
  }
}

TEST(Simd, FinitenessExcludesInfinitiesAndNan) {
  for (double x : {0.0, -1e308, 5e-324}) EXPECT_TRUE(all(is_finite(Pack(x))) && is_finite(x));
  for (double x : {inf, -inf, nan}) EXPECT_TRUE(none(is_finite(Pack(x))) && !is_finite(x));
}

TEST(Simd, MasksCombineLikeBooleans) {
  for (int n = 0; n <= pack_size; ++n) {
    const Mask m = Mask::first(n);
    EXPECT_EQ(bits(m), (1U << n) - 1U);
    EXPECT_EQ(any(m), n > 0);
    EXPECT_EQ(all(m), n == pack_size);
    EXPECT_EQ(none(m), n == 0);
    for (int l = 0; l < pack_size; ++l) {
      EXPECT_EQ(m[l], l < n);
      EXPECT_EQ((!m)[l], l >= n);
      EXPECT_EQ((m & Mask::first(2))[l], l < n && l < 2);
      EXPECT_EQ((m && Mask::first(1))[l], l < n && l < 1);
      EXPECT_EQ(((!m) | Mask::first(1))[l], l >= n || l < 1);
      EXPECT_EQ((!m || Mask::first(1))[l], l >= n || l < 1);
    }
  }
  Mask m(false);
  m.set(1, true);
  EXPECT_EQ(bits(m), 2U);
  m |= Mask::first(1);
  m &= Mask(true);
  EXPECT_EQ(bits(m), 3U);
}

TEST(Simd, PartialLoadsRepeatTheLastNumberAndReadNothingBeyond) {
  for (int n = 1; n <= pack_size; ++n) {
    const std::vector<double> x = [&] {  // exactly n long: the address sanitizer sees a read beyond
      std::vector<double> v;
      for (int i = 0; i < n; ++i) v.push_back(i + 0.5);
      return v;
    }();
    const Pack p = Pack::load_partial(x.data(), n);
    for (int l = 0; l < pack_size; ++l) EXPECT_EQ(p[l], std::min(l, n - 1) + 0.5);
  }
}

TEST(Simd, StoresWriteTheLanesAskedForOnly) {
  double x[pack_size + 2];
  for (int n = 0; n <= pack_size; ++n) {
    for (double& v : x) v = -1.0;
    numbers(1.0).store_partial(x + 1, n);
    EXPECT_EQ(x[0], -1.0);
    for (int l = 0; l <= pack_size; ++l) EXPECT_EQ(x[l + 1], l < n ? numbers(1.0)[l] : -1.0);
  }
  float y[pack_size + 1];
  for (int n = 0; n <= pack_size; ++n) {
    for (float& v : y) v = -1.0F;
    numbers(1.0).store_as_float(y, n);
    for (int l = 0; l <= pack_size; ++l) EXPECT_EQ(y[l], l < n ? static_cast<float>(numbers(1.0)[l]) : -1.0F);
  }
  numbers(2.0).store(x + 1);
  EXPECT_TRUE(all(Pack::load(x + 1) == numbers(2.0)));
}

TEST(Simd, ExtremesGoOverAllLanes) {
  for (int l = 0; l < pack_size; ++l) {
    Pack p(1.0);
    p.set(l, 3.0);
    EXPECT_EQ(max_lane(p), 3.0);
    p.set(l, -3.0);
    EXPECT_EQ(min_lane(p), -3.0);
  }
  EXPECT_EQ(max_lane(2.5), 2.5);
  EXPECT_EQ(min_lane(2.5), 2.5);
}

/// A template over the scalar must do the same for a pack as for each of its numbers alone.
template <class T>
T kernel(T x) {
  const auto m = x > T(0.5);
  const auto n = !m || x < T(2.0);
  return select(m && n, mul_add(x, x, sqrt(abs(x))), min(x, T(0.1)) - max(x, T(-2.0)));
}

TEST(Simd, OneTemplateServesDoublesAndPacks) {
  using P = ScalarTraits<Pack>;
  using D = ScalarTraits<double>;
  static_assert(P::size == pack_size && D::size == 1);
  const Pack x = numbers(-0.4);
  double in[pack_size];
  P::store(x, in);
  const Pack y = kernel(P::load(in));
  for (int l = 0; l < pack_size; ++l) {
    double out = 0.0;
    D::store(kernel(D::load(in + l)), &out);
    EXPECT_EQ(P::lane(y, l), out);
    double z = 0.0;
    D::set_lane(z, 0, D::lane(out, 0));
    EXPECT_EQ(z, out);
  }
  EXPECT_TRUE(D::first(1));
  EXPECT_FALSE(D::first(0));
  EXPECT_EQ(bits(P::first(1)), bits(D::first(1)));
}

}  // namespace
}  // namespace stiffront
