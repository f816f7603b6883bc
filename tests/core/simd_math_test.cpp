// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/core/simd_math.hpp"

#include <gtest/gtest.h>

#include <cfloat>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace stiffront {
namespace {

constexpr double inf = std::numeric_limits<double>::infinity();
constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double tiny = std::numeric_limits<double>::denorm_min();

std::uint64_t bits_of(double x) {
  std::uint64_t b;
  std::memcpy(&b, &x, sizeof b);
  return b;
}
bool same_bits(double a, double b) { return (std::isnan(a) && std::isnan(b)) || bits_of(a) == bits_of(b); }

/// Distance in units of the last place of the double nearest to the exact value; subnormals have the unit 2^-1074.
double ulp_error(double got, long double exact) {
  if (std::isnan(exact)) return std::isnan(got) ? 0.0 : inf;
  const long double overflow = static_cast<long double>(DBL_MAX) * (1.0L + 0x1p-54L);
  if (std::fabs(exact) >= overflow) return got == std::copysign(inf, static_cast<double>(exact)) ? 0.0 : inf;
  if (std::isnan(got)) return inf;
  if (std::isinf(got)) got = std::copysign(DBL_MAX, got);  // next to overflow: one ulp away
  const int exponent = exact == 0.0L ? -1022 : std::max(std::ilogb(exact), -1022);
  return static_cast<double>(std::fabs(static_cast<long double>(got) - exact) / std::ldexp(1.0L, exponent - 52));
}

struct Function {
  std::string name;
  Pack (*pack)(Pack);
  long double (*exact)(long double);
  double lower, upper;   ///< where uniform arguments are drawn from
  double bound;          ///< the error promised in the header, in ulp
  double largest = inf;  ///< arguments of any exponent are drawn up to here
};

const Function functions[] = {
    {"exp", exp, std::exp, -750.0, 712.0, 1.5},    {"expm1", expm1, std::expm1, -40.0, 712.0, 2.0},
    {"log", log, std::log, 0.0, 3.0, 1.0},         {"log1p", log1p, std::log1p, -1.0, 3.0, 1.5},
    {"log10", log10, std::log10, 0.0, 20.0, 0.51}, {"sin", sin, std::sin, -1e5, 1e5, 1.0, 1e5},
    {"cos", cos, std::cos, -1e5, 1e5, 1.0, 1e5},   {"tan", tan, std::tan, -1e5, 1e5, 2.5, 1e5},
    {"asin", asin, std::asin, -1.001, 1.001, 1.5}, {"acos", acos, std::acos, -1.001, 1.001, 1.5},
    {"atan", atan, std::atan, -4.0, 4.0, 2.0},     {"sinh", sinh, std::sinh, -711.0, 711.0, 2.5},
    {"cosh", cosh, std::cosh, -711.0, 711.0, 2.0}, {"tanh", tanh, std::tanh, -22.0, 22.0, 3.0},
};

class ElementaryFunction : public testing::TestWithParam<Function> {
 protected:
  /// The largest error over packs of arguments made by draw().
  template <class Draw>
  double largest_error(Draw draw, int packs, double& where) {
    const Function& f = GetParam();
    double worst = 0.0;
    for (int k = 0; k < packs; ++k) {
      Pack x;
      for (int l = 0; l < pack_size; ++l) x.set(l, draw());
      const Pack y = f.pack(x);
      for (int l = 0; l < pack_size; ++l) {
        const double e = ulp_error(y[l], f.exact(static_cast<long double>(x[l])));
        if (e > worst) {
          worst = e;
          where = x[l];
        }
      }
    }
    return worst;
  }
  std::mt19937_64 random_{20};
};

TEST_P(ElementaryFunction, KeepsItsErrorBoundWhereItVaries) {
  const Function& f = GetParam();
  std::uniform_real_distribution<double> uniform(f.lower, f.upper);
  std::uniform_real_distribution<double> unit(std::max(f.lower, -2.0), std::min(f.upper, 2.0));
  double where = 0.0;
  const double wide = largest_error([&] { return uniform(random_); }, 40000, where);
  EXPECT_LT(wide, f.bound) << "at " << std::hexfloat << where;
  const double narrow = largest_error([&] { return unit(random_); }, 40000, where);
  EXPECT_LT(narrow, f.bound) << "at " << std::hexfloat << where;
  RecordProperty("ulp", std::to_string(std::max(wide, narrow)));
}

TEST_P(ElementaryFunction, KeepsItsErrorBoundForArgumentsOfAnyExponent) {
  const Function& f = GetParam();
  double where = 0.0;
  const auto any_double = [&] {
    for (;;) {
      const std::uint64_t b = random_();
      double x;
      std::memcpy(&x, &b, sizeof x);
      if (!(std::abs(x) > f.largest)) return x;
    }
  };
  EXPECT_LT(largest_error(any_double, 40000, where), f.bound) << "at " << std::hexfloat << where;
}

TEST_P(ElementaryFunction, KeepsItsErrorBoundNextToMultiplesOfPiAndPowersOfTwo) {
  const Function& f = GetParam();
  double where = 0.0;
  std::vector<double> points;
  for (int k = 1; k < 63000; k += 7) points.push_back(static_cast<double>(k * (0.5L * 3.14159265358979323846264338327950288L)));
  for (int e = -1074; e < 1024; ++e) points.push_back(std::ldexp(1.0, e));
  std::vector<double> arguments;
  for (double p : points) {
    for (double x : {p, std::nextafter(p, 0.0), std::nextafter(p, inf)}) {
      if (x > f.largest) continue;
      arguments.push_back(x);
      arguments.push_back(-x);
    }
  }
  std::size_t next = 0;
  const auto draw = [&] { return arguments[next++ % arguments.size()]; };
  EXPECT_LT(largest_error(draw, static_cast<int>(arguments.size()) / pack_size + 1, where), f.bound) << "at " << std::hexfloat << where;
}

TEST_P(ElementaryFunction, GivesTheSameBitsInEveryLane) {
  const Function& f = GetParam();
  std::uniform_real_distribution<double> uniform(f.lower, f.upper);
  for (int k = 0; k < 500; ++k) {
    const double x = uniform(random_);
    const Pack alone = f.pack(Pack(x));
    for (int l = 0; l < pack_size; ++l) {
      Pack mixed;
      for (int i = 0; i < pack_size; ++i) mixed.set(i, uniform(random_));
      mixed.set((l + 1) % pack_size, k % 3 == 0 ? nan : k % 3 == 1 ? inf : -tiny);
      mixed.set(l, x);
      EXPECT_TRUE(same_bits(f.pack(mixed)[l], alone[0])) << x;
    }
  }
}

TEST_P(ElementaryFunction, AgreesWithTheStandardAtSpecialArguments) {
  const Function& f = GetParam();
  for (double x : {0.0, -0.0, 1.0, -1.0, 0.5, -0.5, inf, -inf, nan, tiny, -tiny, DBL_MIN, -DBL_MIN, DBL_MAX, -DBL_MAX}) {
    if (std::isfinite(x) && std::abs(x) > f.largest) continue;
    const double got = f.pack(Pack(x))[0];
    const long double exact = f.exact(static_cast<long double>(x));
    EXPECT_LT(ulp_error(got, exact), f.bound) << x;
    if (std::isnan(exact)) continue;
    EXPECT_EQ(std::signbit(got), std::signbit(exact)) << x;
    if (exact == 0.0L || std::abs(exact) == 1.0L) {
      EXPECT_EQ(got, static_cast<double>(exact)) << x;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(SimdMath, ElementaryFunction, testing::ValuesIn(functions),
                         [](const testing::TestParamInfo<Function>& i) { return i.param.name; });

TEST(SimdMath, LogarithmsToBaseTenOfPowersOfTenAreExact) {
  double power = 1.0;
  for (int n = 0; n <= 22; ++n, power *= 10.0) EXPECT_EQ(log10(Pack(power))[0], n);
}

TEST(SimdMath, AnglesBeyondTheReductionAreThoseOfTheLibrary) {
  for (double x : {1.0001e5, -3e7, 1e22, 1.7e308}) {
    Pack p(0.25);
    p.set(1, x);
    EXPECT_EQ(sin(p)[1], std::sin(x));
    EXPECT_EQ(cos(p)[1], std::cos(x));
    EXPECT_EQ(tan(p)[1], std::tan(x));
    EXPECT_EQ(sin(p)[0], sin(Pack(0.25))[0]);
  }
}

double power_error(double x, double y) {
  return ulp_error(pow(Pack(x), Pack(y))[0], std::pow(static_cast<long double>(x), static_cast<long double>(y)));
}

TEST(SimdMath, PowersKeepTheirErrorBound) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> base(0.0, 4.0);
  std::uniform_real_distribution<double> small(-8.0, 8.0);
  std::uniform_real_distribution<double> wide(-1080.0, 1080.0);
  double worst = 0.0;
  for (int k = 0; k < 60000; ++k) {
    worst = std::max(worst, power_error(base(random), small(random)));
    worst = std::max(worst, power_error(base(random), wide(random)));
    const double near_one = 1.0 + std::ldexp(small(random), -20 - k % 30);
    worst = std::max(worst, power_error(near_one, wide(random) * std::ldexp(1.0, 5 + k % 30)));
    const std::uint64_t b = random() & 0x7fffffffffffffffU;
    double any;
    std::memcpy(&any, &b, sizeof any);
    if (std::isfinite(any)) worst = std::max(worst, power_error(any, small(random) * 0.3));
  }
  EXPECT_LT(worst, 1.5);
}

TEST(SimdMath, PowersOfNegativeNumbersFollowTheParityOfTheExponent) {
  for (double x : {-0.5, -1.0, -2.0, -3.7, -1e-300, -tiny}) {
    for (int n = -9; n <= 9; ++n) EXPECT_LT(power_error(x, n), 1.5) << x << "^" << n;
    for (double y : {0.5, -0.5, 1.5, 2.0000000000000004}) EXPECT_TRUE(std::isnan(pow(Pack(x), Pack(y))[0])) << x << "^" << y;
  }
  EXPECT_EQ(pow(Pack(-1.0), Pack(9007199254740991.0))[0], -1.0);
  EXPECT_EQ(pow(Pack(-1.0), Pack(9007199254740992.0))[0], 1.0);
  EXPECT_EQ(pow(Pack(-1.0), Pack(1e300))[0], 1.0);
  EXPECT_EQ(pow(Pack(-2.0), Pack(3.0))[0], -8.0);
}

TEST(SimdMath, PowersAgreeWithTheStandardAtSpecialArguments) {
  const double values[] = {
      0.0, -0.0, 1.0, -1.0, 2.0, -2.0, 0.5, -0.5, 3.0, -3.0, inf, -inf, nan, tiny, -tiny, DBL_MAX, -DBL_MAX, 1e-3, 9007199254740993.0};
  for (double x : values) {
    for (double y : values) {
      const double expected = std::pow(x, y);
      const double got = pow(Pack(x), Pack(y))[0];
      if (std::isnan(expected) || std::isinf(expected) || expected == 0.0 || expected == 1.0) {
        EXPECT_TRUE(same_bits(got, expected)) << x << "^" << y << " gives " << got;
      } else {
        EXPECT_LT(power_error(x, y), 1.5) << x << "^" << y;
      }
    }
  }
}

TEST(SimdMath, SmallIntegerPowersOfSmallIntegersAreExact) {
  for (int x = 1; x <= 12; ++x) {
    double expected = 1.0;
    for (int n = 0; n <= 14; ++n, expected *= x) EXPECT_EQ(pow(Pack(x), Pack(n))[0], expected) << x << "^" << n;
  }
}

TEST(SimdMath, PowersGiveTheSameBitsInEveryLane) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> draw(-3.0, 3.0);
  for (int k = 0; k < 300; ++k) {
    Pack x;
    Pack y;
    for (int l = 0; l < pack_size; ++l) {
      x.set(l, draw(random));
      y.set(l, l % 2 == 0 ? std::round(draw(random)) : draw(random));
    }
    const Pack r = pow(x, y);
    for (int l = 0; l < pack_size; ++l) EXPECT_TRUE(same_bits(r[l], pow(Pack(x[l]), Pack(y[l]))[pack_size - 1 - l]));
  }
}

}  // namespace
}  // namespace stiffront
