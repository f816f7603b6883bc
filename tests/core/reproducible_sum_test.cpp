// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/core/reproducible_sum.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <span>
#include <vector>

namespace stiffront {
namespace {

std::vector<double> wild_terms(int n, unsigned seed, int exponent_range) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> mantissa(-1.0, 1.0);
  std::uniform_int_distribution<int> exponent(-exponent_range, exponent_range);
  std::vector<double> x(static_cast<std::size_t>(n));
  for (double& v : x) v = std::ldexp(mantissa(random), exponent(random));
  return x;
}

double sum_of(const std::vector<double>& x) {
  ReproducibleSum s;
  for (double v : x) s.add(v);
  return s.value();
}

TEST(ReproducibleSum, IsIndependentOfTheOrderOfTerms) {
  for (int range : {2, 60, 300}) {
    std::vector<double> x = wild_terms(5000, 1, range);
    const double expected = sum_of(x);
    std::mt19937_64 random(7);
    for (int repeat = 0; repeat < 20; ++repeat) {
      std::shuffle(x.begin(), x.end(), random);
      EXPECT_EQ(sum_of(x), expected);
    }
  }
}

TEST(ReproducibleSum, IsIndependentOfThePartitionAlsoThroughTheWire) {
  const std::vector<double> x = wild_terms(4096, 2, 100);
  const double expected = sum_of(x);
  for (std::size_t parts : {1U, 2U, 3U, 4U, 7U, 64U}) {
    std::vector<ReproducibleSum> sums(parts);
    for (std::size_t i = 0; i < x.size(); ++i) sums[(i * i + 3 * i) % parts].add(x[i]);
    ReproducibleSum forward;
    ReproducibleSum backward;
    for (std::size_t p = 0; p < parts; ++p) {
      forward.merge(ReproducibleSum::from_wire(sums[p].wire()));
      backward.merge(sums[parts - 1 - p]);
    }
    EXPECT_EQ(forward.value(), expected);
    EXPECT_EQ(backward.value(), expected);
  }
}

TEST(ReproducibleSum, IsIndependentOfTheLane) {
  const std::vector<double> x = wild_terms(1024, 3, 40);
  const double expected = sum_of(x);
  ReproducibleSum packed;
  for (std::size_t i = 0; i + pack_size <= x.size(); i += pack_size) packed.add(Pack::load(&x[i]));
  EXPECT_EQ(packed.value(), expected);
}

TEST(ReproducibleSum, TakesManyPacksAtOnceAsItTakesThemOneByOne) {
  for (int range : {2, 60, 300}) {
    std::vector<double> x = wild_terms(6001 * pack_size, 5, range);
    for (double& v : x) v = std::abs(v);
    for (double odd : {0.0, 5e-324, 1e300, std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
      x[x.size() / 2] = odd;
      std::vector<Pack> packs;
      for (std::size_t i = 0; i < x.size(); i += pack_size) packs.push_back(Pack::load(&x[i]));
      ReproducibleSum one_by_one;
      for (const Pack& p : packs) one_by_one.add(p);
      ReproducibleSum together;
      std::span<const Pack> rest(packs);
      for (std::size_t n = 0; !rest.empty(); rest = rest.subspan(n)) {
        n = std::min(rest.size(), n % 16 + 1);
        together.add(rest.first(n));
      }
      if (std::isnan(odd)) {
        EXPECT_TRUE(std::isnan(together.value()));
      } else {
        EXPECT_EQ(together.value(), one_by_one.value()) << range << ' ' << odd;
      }
    }
  }
}

TEST(ReproducibleSum, SurvivesCancellationThatDefeatsAPlainSum) {
  EXPECT_EQ(sum_of({1e16, 1.0, -1e16}), 1.0);
  EXPECT_EQ(sum_of({1e200, 1e-200, -1e200, 3e180, -3e180}), 0.0);  // 1e-200 is below 2^-80 of the largest term
}

TEST(ReproducibleSum, IsAsAccurateAsExtendedPrecision) {
  const std::vector<double> x = wild_terms(100000, 4, 3);
  long double reference = 0.0L;
  for (double v : x) reference += v;
  EXPECT_NEAR(sum_of(x), static_cast<double>(reference), 1e-12);
}

TEST(ReproducibleSum, HandlesSubnormalsZerosAndManyDeposits) {
  EXPECT_EQ(ReproducibleSum().value(), 0.0);
  EXPECT_EQ(sum_of({0.0, -0.0}), 0.0);
  const double tiny = std::numeric_limits<double>::min();
  EXPECT_EQ(sum_of({tiny, tiny}), 2 * tiny);
  ReproducibleSum s;
  for (int i = 0; i < 100000; ++i) s.add(Pack(0.75));
  EXPECT_EQ(s.value(), 0.75 * 100000 * pack_size);
}

TEST(ReproducibleSum, PassesOnWhatIsNotFinite) {
  const double inf = std::numeric_limits<double>::infinity();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(std::isnan(sum_of({1.0, nan, 2.0})));
  EXPECT_EQ(sum_of({1.0, inf}), inf);
  EXPECT_EQ(sum_of({1.0, -inf, 5.0}), -inf);
  EXPECT_TRUE(std::isnan(sum_of({inf, -inf})));
}

}  // namespace
}  // namespace stiffront
