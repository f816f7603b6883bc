// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/solvers/rock4_coefficients.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "stiffront/core/error.hpp"

namespace stiffront {
namespace {

using Vector = std::vector<long double>;

/// The method as one ordinary Runge-Kutta tableau, with long arithmetic on the rounded coefficients.
struct Tableau {
  std::vector<Vector> a;          // s rows
  Vector b, embedded_difference;  // weights of the solution, and of the error estimate

  explicit Tableau(const Rock4Coefficients& m) {
    const std::size_t s = static_cast<std::size_t>(m.stages);
    const std::size_t n = s - 4;
    std::vector<Vector> g(n + 1, Vector(s, 0.0L));
    for (std::size_t j = 1; j <= n; ++j)
      for (std::size_t k = 0; k < s; ++k)
        g[j][k] = m.nu[j - 1] * g[j - 1][k] + (j > 1 ? m.kappa[j - 1] * g[j - 2][k] : 0.0L) + (k == j - 1 ? m.mu[j - 1] : 0.0L);
    a.assign(g.begin(), g.begin() + static_cast<std::ptrdiff_t>(n));
    for (std::size_t i = 0; i < 4; ++i) {
      Vector row = g[n];
      for (std::size_t k = 0; k < i; ++k) row[n + k] += m.a[i][k];
      a.push_back(row);
    }
    b = g[n];
    embedded_difference.resize(s);
    for (std::size_t k = 0; k < n; ++k) embedded_difference[k] = -m.d0 * g[n][k];
    for (std::size_t i = 0; i < 4; ++i) {
      b[n + i] += m.b[i];
      embedded_difference[n + i] = static_cast<long double>(m.d0) * m.e[i];
    }
  }

  Vector times(const Vector& x) const {
    Vector y(x.size(), 0.0L);
    for (std::size_t i = 0; i < x.size(); ++i)
      for (std::size_t k = 0; k < i; ++k) y[i] += a[i][k] * x[k];
    return y;
  }
  Vector nodes() const {
    Vector sums(b.size(), 0.0L);
    for (std::size_t i = 0; i < b.size(); ++i) {
      for (std::size_t k = 0; k < i; ++k) sums[i] += a[i][k];
    }
    return sums;
  }
};

Vector product(const Vector& x, const Vector& y) {
  Vector z(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) z[i] = x[i] * y[i];
  return z;
}

double dot(const Vector& x, const Vector& y) {
  long double sum = 0.0L;
  for (std::size_t i = 0; i < x.size(); ++i) sum += x[i] * y[i];
  return static_cast<double>(sum);
}

/// R(z), by performing a step on y' = z y.
double stability(const Rock4Coefficients& m, long double z) {
  long double before = 1.0L;
  long double g = 1.0L + m.mu[0] * z;
  for (std::size_t j = 1; j < m.mu.size(); ++j) {
    const long double next = m.mu[j] * z * g + m.nu[j] * g + m.kappa[j] * before;
    before = g;
    g = next;
  }
  std::array<long double, 4> k{};
  for (std::size_t i = 0; i < 4; ++i) {
    long double argument = g;
    for (std::size_t l = 0; l < i; ++l) argument += m.a[i][l] * k[l];
    k[i] = z * argument;
  }
  for (std::size_t i = 0; i < 4; ++i) g += m.b[i] * k[i];
  return static_cast<double>(g);
}

/// |R| at the interior local extrema of R on (-length, -0.05), from right to left.
std::vector<double> ripples(const Rock4Coefficients& m, double length) {
  std::vector<double> found;
  const int samples = 400 * m.stages;
  double two_before = 2.0;
  double before = 2.0;
  for (int i = 0; i <= samples; ++i) {
    // Samples as dense towards both ends as the ripples are.
    const double z = -0.05 - (length - 0.05) * 0.5 * (1.0 - std::cos(std::numbers::pi * i / samples));
    const double value = stability(m, z);
    if (i >= 2 && (before - two_before) * (value - before) < 0.0) found.push_back(std::abs(before));
    two_before = before;
    before = value;
  }
  return found;
}

/// The largest l with |R| <= level on the left part of [-l, 0], by bisection between the formula and 5 % beyond.
double length_at(const Rock4Coefficients& m, double level) {
  double inside = m.interval;
  double outside = 1.05 * m.interval + 0.1;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (inside + outside);
    (std::abs(stability(m, -middle)) <= level ? inside : outside) = middle;
  }
  return inside;
}

/// Calls claim(method) for a sample of the numbers of stages.
template <class Claim>
void for_all_methods(Claim&& claim) {
  for (int stages : {5, 6, 7, 8, 9, 10, 12, 15, 20, 30, 37, 50, 76, 100, 116, 150}) {
    SCOPED_TRACE(::testing::Message() << stages << " stages");
    claim(rock4_coefficients(stages));
  }
}

TEST(Rock4CoefficientsTest, AllEightConditionsOfOrderFourHold) {
  for_all_methods([](const Rock4Coefficients& method) {
    const Tableau t(method);
    const Vector one(t.b.size(), 1.0L);
    const Vector c = t.nodes();
    const double tolerance = 5e-14;
    EXPECT_NEAR(dot(t.b, one), 1.0, tolerance);
    EXPECT_NEAR(dot(t.b, c), 1.0 / 2, tolerance);
    EXPECT_NEAR(dot(t.b, product(c, c)), 1.0 / 3, tolerance);
    EXPECT_NEAR(dot(t.b, t.times(c)), 1.0 / 6, tolerance);
    EXPECT_NEAR(dot(t.b, product(c, product(c, c))), 1.0 / 4, tolerance);
    EXPECT_NEAR(dot(t.b, product(c, t.times(c))), 1.0 / 8, tolerance);
    EXPECT_NEAR(dot(t.b, t.times(product(c, c))), 1.0 / 12, tolerance);
    EXPECT_NEAR(dot(t.b, t.times(t.times(c))), 1.0 / 24, tolerance);
  });
}

TEST(Rock4CoefficientsTest, EstimateVanishesUpToOrderThreeAndNotAtOrderFour) {
  for_all_methods([](const Rock4Coefficients& method) {
    const Tableau t(method);
    const Vector& d = t.embedded_difference;
    const Vector c = t.nodes();
    EXPECT_NEAR(dot(d, Vector(d.size(), 1.0)), 0.0, 5e-14);
    EXPECT_NEAR(dot(d, c), 0.0, 5e-14);
    EXPECT_NEAR(dot(d, product(c, c)), 0.0, 5e-14);
    EXPECT_NEAR(dot(d, t.times(c)), 0.0, 5e-14);
    // For d0 = 1, times gamma, the first coefficient of order 4 is -0.23 for 6 stages and tends to -0.48.
    EXPECT_GT(std::abs(4 * dot(d, product(c, product(c, c)))) / method.d0, method.stages < 20 ? 0.1 : 0.4);
  });
}

TEST(Rock4CoefficientsTest, TimesAreTheRowSumsAndIncreaseAlongTheRecurrence) {
  for_all_methods([](const Rock4Coefficients& method) {
    const Vector c = Tableau(method).nodes();
    const std::size_t n = method.mu.size();
    for (std::size_t j = 0; j < n; ++j) EXPECT_NEAR(method.ct[j], static_cast<double>(c[j]), 1e-14);
    for (std::size_t j = 0; j < n; ++j) EXPECT_LT(method.ct[j], method.ct[j + 1]);
    for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(method.c[i], static_cast<double>(c[n + i]), 1e-14);
    EXPECT_NEAR(method.c[0], method.ct[n], 1e-15);
    EXPECT_LT(method.ct[n], 0.33);
  });
}

TEST(Rock4CoefficientsTest, ConstantsPassTheRecurrenceWithoutRounding) {
  for_all_methods([](const Rock4Coefficients& method) {
    for (std::size_t j = 0; j < method.mu.size(); ++j) {
      EXPECT_EQ(method.nu[j] + method.kappa[j], 1.0);
      EXPECT_EQ(1.0 - method.nu[j], method.kappa[j]);
    }
  });
}

TEST(Rock4CoefficientsTest, IsDampedOnTheWholeIntervalAndUnstableBeyond) {
  for_all_methods([](const Rock4Coefficients& method) {
    const int samples = 200 * method.stages;
    for (int i = 0; i <= samples; ++i) {
      const double z = -0.0514 - (method.interval - 0.0514) * 0.5 * (1.0 - std::cos(std::numbers::pi * i / samples));
      ASSERT_LT(std::abs(stability(method, z)), 0.9501) << "at z = " << z;
    }
    EXPECT_GT(std::abs(stability(method, -1.01 * length_at(method, 1.0))), 1.0);
  });
}

TEST(Rock4CoefficientsTest, HasThreeRipplesFewerThanStagesAllOfTheSameHeightButTheFirst) {
  for_all_methods([](const Rock4Coefficients& method) {
    const std::vector<double> heights = ripples(method, length_at(method, 0.95));
    EXPECT_EQ(heights.size(), static_cast<std::size_t>(method.stages - 3));
    EXPECT_LT(heights.at(0), 0.21);
    EXPECT_NEAR(heights.at(1), 0.95, 2e-5);
    for (std::size_t i = 2; i < heights.size(); ++i) EXPECT_LT(heights[i], 0.95 + 2e-6);
  });
}

/// y' = f(t, y): three coupled non-linear components that depend on time.
template <class Real>
std::array<Real, 3> three_body(Real t, const std::array<Real, 3>& y) {
  return {-y[0] * y[1] + std::cos(2 * t), y[0] * y[0] - y[1] + Real(0.5) * std::sin(t) * y[2], y[0] * y[2] - t * y[2] * y[2] + Real(0.3)};
}

std::array<double, 3> advance(const Rock4Coefficients& m, std::array<double, 3> y, double t, double h) {
  using State = std::array<double, 3>;
  State before = y;
  State g = y;
  for (std::size_t j = 0; j < m.mu.size(); ++j) {
    const State f = three_body(t + m.ct[j] * h, g);
    State next;
    for (std::size_t i = 0; i < 3; ++i) next[i] = h * m.mu[j] * f[i] + m.nu[j] * g[i] + m.kappa[j] * before[i];
    before = g;
    g = next;
  }
  std::array<State, 4> k;
  for (std::size_t i = 0; i < 4; ++i) {
    State argument = g;
    for (std::size_t l = 0; l < i; ++l)
      for (std::size_t c = 0; c < 3; ++c) argument[c] += h * m.a[i][l] * k[l][c];
    k[i] = three_body(t + m.c[i] * h, argument);
  }
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t c = 0; c < 3; ++c) g[c] += h * m.b[i] * k[i][c];
  return g;
}

constexpr std::array<double, 3> initial_value{1.0, 0.5, 0.2};

/// Classical Runge-Kutta steps, 1e4 of them in long arithmetic: error below 1e-16.
std::array<long double, 3> reference(long double end) {
  using State = std::array<long double, 3>;
  State y{initial_value[0], initial_value[1], initial_value[2]};
  const int steps = 10000;
  const long double h = end / steps;
  const auto moved = [](const State& x, const State& k, long double by) {
    State z;
    for (std::size_t c = 0; c < 3; ++c) z[c] = x[c] + by * k[c];
    return z;
  };
  for (int i = 0; i < steps; ++i) {
    const long double t = i * h;
    const State k1 = three_body(t, y);
    const State k2 = three_body(t + h / 2, moved(y, k1, h / 2));
    const State k3 = three_body(t + h / 2, moved(y, k2, h / 2));
    const State k4 = three_body(t + h, moved(y, k3, h));
    for (std::size_t c = 0; c < 3; ++c) y[c] += h / 6 * (k1[c] + 2 * k2[c] + 2 * k3[c] + k4[c]);
  }
  return y;
}

TEST(Rock4CoefficientsTest, ConvergesWithOrderFourOnANonautonomousNonlinearEquation) {
  for_all_methods([](const Rock4Coefficients& method) {
    static const std::array<long double, 3> exact = reference(2.0L);
    std::vector<double> log_step, log_error;
    for (int steps = 16; steps <= 128; steps *= 2) {
      const double h = 2.0 / steps;
      std::array<double, 3> y = initial_value;
      for (int i = 0; i < steps; ++i) y = advance(method, y, i * h, h);
      long double error = 0.0L;
      for (std::size_t c = 0; c < 3; ++c) error = std::max(error, std::abs(y[c] - exact[c]));
      log_step.push_back(std::log(h));
      log_error.push_back(static_cast<double>(std::log(error)));
    }
    const double points = static_cast<double>(log_step.size());
    double x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
    for (std::size_t i = 0; i < log_step.size(); ++i) {
      x += log_step[i];
      y += log_error[i];
      xx += log_step[i] * log_step[i];
      xy += log_step[i] * log_error[i];
    }
    EXPECT_NEAR((points * xy - x * y) / (points * xx - x * x), 4.0, 0.2);
  });
}

/// Figures of an independent implementation of ours that solved the equal-ripple problem itself, in quadruple
/// precision.
struct SweepRow {
  int stages;
  double length_at_one, length_at_damping, first_ripple;
  std::array<double, 4> c;
  double largest_coefficient, order_five_error;
};

constexpr std::array<SweepRow, 10> sweep{{
    {5, 6.011950, 5.998269, 0.202280, {0.176296, 0.042111, 0.588148, 0.794074}, 1.2000, 0.006390},
    {6, 9.886303, 9.875036, 0.174456, {0.236996, 0.074103, 0.618498, 0.809249}, 0.9567, 0.004569},
    {7, 14.465551, 14.455127, 0.159864, {0.266251, 0.099109, 0.633126, 0.816563}, 0.8831, 0.003775},
    {8, 19.753944, 19.743923, 0.151832, {0.282836, 0.118872, 0.641418, 0.820709}, 0.8555, 0.003343},
    {12, 47.990264, 47.980771, 0.136774, {0.308785, 0.165209, 0.654392, 0.827196}, 0.8528, 0.002684},
    {20, 138.398521, 138.389218, 0.129969, {0.320235, 0.196173, 0.660118, 0.830059}, 0.8912, 0.002393},
    {37, 480.644373, 480.635134, 0.126888, {0.324480, 0.210268, 0.662240, 0.831120}, 0.9212, 0.002284},
    {76, 2037.192830, 2037.183610, 0.126085, {0.325781, 0.214941, 0.662890, 0.831445}, 0.9333, 0.002250},
    {116, 4749.764132, 4749.754915, 0.125979, {0.326010, 0.215781, 0.663005, 0.831502}, 0.9356, 0.002244},
    {150, 7944.099616, 7944.090400, 0.125956, {0.326079, 0.216036, 0.663040, 0.831520}, 0.9363, 0.002243},
}};

TEST(Rock4SweepTest, AgreesWithTheSolutionsOfTheEqualRippleProblem) {
  for (const SweepRow& row : sweep) {
    SCOPED_TRACE(::testing::Message() << row.stages << " stages");
    const Rock4Coefficients m = rock4_coefficients(row.stages);
    EXPECT_NEAR(length_at(m, 1.0) / row.length_at_one, 1.0, 2e-7);
    EXPECT_NEAR(length_at(m, 0.95) / row.length_at_damping, 1.0, 2e-7);
    // The other implementation located the first minimum on a coarse grid only: its figure lies up to 7e-4 above.
    const double first_ripple = ripples(m, row.length_at_damping).at(0);
    EXPECT_LE(first_ripple, row.first_ripple + 2e-6);
    EXPECT_GT(first_ripple, row.first_ripple - 1e-3);
    double largest = 0.0;
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_NEAR(m.c[i], row.c[i], 1e-6);
      largest = std::max(largest, std::abs(m.b[i]));
      for (double a : m.a[i]) largest = std::max(largest, std::abs(a));
    }
    EXPECT_NEAR(largest, row.largest_coefficient, 1e-4);
  }
}

TEST(Rock4SweepTest, HasTheErrorConstantsOfTheSolutionsOfTheEqualRippleProblem) {
  for (const SweepRow& row : sweep) {
    SCOPED_TRACE(::testing::Message() << row.stages << " stages");
    const Tableau t(rock4_coefficients(row.stages));
    const Vector c = t.nodes();
    const Vector ac = t.times(c);
    const Vector c2 = product(c, c);
    const auto defect = [&](const Vector& weight, int gamma, int sigma) {
      const double x = (dot(t.b, weight) - 1.0 / gamma) / sigma;
      return x * x;
    };
    const double sum = defect(product(c2, c2), 5, 24) + defect(product(c2, ac), 10, 2) + defect(product(ac, ac), 20, 2) +
                       defect(product(c, t.times(c2)), 15, 2) + defect(product(c, t.times(ac)), 30, 1) +
                       defect(t.times(product(c2, c)), 20, 6) + defect(t.times(product(c, ac)), 40, 1) +
                       defect(t.times(t.times(c2)), 60, 2) + defect(t.times(t.times(ac)), 120, 1);
    EXPECT_NEAR(std::sqrt(sum), row.order_five_error, 2e-6);
  }
}

TEST(Rock4SixStagesTest, AgreeWithAQuadruplePrecisionComputation) {
  const Rock4Coefficients m = rock4_coefficients(6);
  const double tolerance = 1e-9;  // A and L come from ten printed digits
  EXPECT_NEAR(m.mu[0], 0.10671314768332506, tolerance);
  EXPECT_NEAR(m.mu[1], 0.12963197440383703, tolerance);
  EXPECT_NEAR(m.kappa[1], -0.0060979850592648, tolerance);
  EXPECT_NEAR(m.c[0], 0.2369958572673621, tolerance);
  EXPECT_NEAR(m.c[1], 0.07410349733007, tolerance);
  EXPECT_NEAR(m.c[2], 0.61849792863368, tolerance);
  EXPECT_NEAR(m.c[3], 0.80924896431684, tolerance);
  EXPECT_NEAR(m.a[1][0], -0.16289235993729, tolerance);
  EXPECT_NEAR(m.a[2][1], -0.57517071814507, tolerance);
  EXPECT_NEAR(m.a[3][2], 0.42880326126719, tolerance);
  const std::array<double, 4> b{0.50377366909235, -0.22575568061378, 0.04702971144912, 0.43795644280494};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(m.b[i], b[i], tolerance);
  // The finishing procedure on y' = z y is 1 + w_1 z + .. + w_4 z^4.
  const std::array<double, 4> w{0.76300414273264, 0.30533774306549, 0.08374791749440, 0.01759488702978};
  std::array<double, 4> power{1.0, 1.0, 1.0, 1.0};
  for (std::size_t degree = 0; degree < 4; ++degree) {
    double sum = 0.0;
    std::array<double, 4> next{};
    for (std::size_t i = 0; i < 4; ++i) {
      sum += m.b[i] * power[i];
      for (std::size_t l = 0; l < i; ++l) next[i] += m.a[i][l] * power[l];
    }
    EXPECT_NEAR(sum, w[degree], tolerance);
    power = next;
  }
}

TEST(Rock4SixStagesTest, AreComputedToTheSameBitsEveryTime) {
  const Rock4Coefficients first = rock4_coefficients(23);
  Rock4Table table;
  table[40];
  const Rock4Coefficients& kept = table[23];
  EXPECT_EQ(first.mu, kept.mu);
  EXPECT_EQ(first.nu, kept.nu);
  EXPECT_EQ(first.kappa, kept.kappa);
  EXPECT_EQ(first.ct, kept.ct);
  EXPECT_EQ(first.a, kept.a);
  EXPECT_EQ(first.b, kept.b);
  EXPECT_EQ(first.c, kept.c);
  EXPECT_EQ(first.e, kept.e);
  EXPECT_EQ(&kept, &table[23]);
}

TEST(Rock4StagesTest, EveryNumberUpToTheCapExistsAndTheIntervalFormulaIsASharpLowerBound) {
  for (int s = rock4_min_stages; s <= 150; ++s) {
    const Rock4Coefficients m = rock4_coefficients(s);
    const double length = length_at(m, 0.95);
    EXPECT_LE(m.interval, length) << s << " stages";
    EXPECT_GT(m.interval, length - 0.07) << s << " stages";
  }
}

TEST(Rock4StagesTest, AreTheFewestWhoseIntervalIsLongEnough) {
  EXPECT_EQ(rock4_stages(0.0), 5);
  EXPECT_EQ(rock4_stages(5.9), 5);
  EXPECT_EQ(rock4_stages(5.95), 6);
  for (int s = 5; s <= 1000; ++s) {
    EXPECT_EQ(rock4_stages(rock4_interval(s)), s);
    EXPECT_EQ(rock4_stages(std::nextafter(rock4_interval(s), 1e300)), s + 1);
  }
}

TEST(Rock4StagesTest, GrowWithTheSquareRootOfTheStiffness) {
  EXPECT_NEAR(rock4_stages(4e6) / static_cast<double>(rock4_stages(1e6)), 2.0, 0.002);
}

TEST(Rock4StagesTest, MeaninglessStiffnessOrCountIsABug) {
  EXPECT_THROW(rock4_stages(-1.0), Error);
  EXPECT_THROW(rock4_stages(std::numeric_limits<double>::quiet_NaN()), Error);
  EXPECT_THROW(rock4_stages(std::numeric_limits<double>::infinity()), Error);
  EXPECT_THROW(rock4_coefficients(4), Error);
}

TEST(Rock4StagesTest, CapFollowsTheEighthRootOfTheTolerance) {
  EXPECT_EQ(rock4_max_stages(1e-3), 122);
  EXPECT_EQ(rock4_max_stages(1e-4), 91);
  EXPECT_EQ(rock4_max_stages(1e-6), 51);
  EXPECT_EQ(rock4_max_stages(1e-8), 29);
  EXPECT_EQ(rock4_max_stages(1.0), 150);
  EXPECT_EQ(rock4_max_stages(1e-16), 5);
}

TEST(Rock4StagesTest, AtTheCapAmplifiedRoundingErrorsStayOfTheSizeOfTheTolerance) {
  for (double tolerance : {1e-3, 1e-5, 1e-7, 1e-9}) {
    const Rock4Coefficients m = rock4_coefficients(rock4_max_stages(tolerance));
    // w(-l): what the finishing procedure does to a stiff error of the last recurrence stage.
    std::array<double, 4> k{};
    double y = 1.0;
    for (std::size_t i = 0; i < 4; ++i) {
      double argument = 1.0;
      for (std::size_t l = 0; l < i; ++l) argument += m.a[i][l] * k[l];
      k[i] = -m.interval * argument;
      y += m.b[i] * k[i];
    }
    EXPECT_LT(y * std::numeric_limits<double>::epsilon(), 3.0 * tolerance);
    EXPECT_GT(y * std::numeric_limits<double>::epsilon(), 0.1 * tolerance);
  }
}

}  // namespace
}  // namespace stiffront
