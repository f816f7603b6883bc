// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/core/dual.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <string>

namespace stiffront {
namespace {

using Complex = std::complex<double>;

/// d f(x): the complex step has no cancellation, so it is exact to rounding.
template <class F>
double complex_step(F f, double x) {
  constexpr double h = 1e-30;
  return f(Complex(x, h)).imag() / h;
}
template <class F>
double central_difference(F f, double x) {
  const double h = 1e-5 * std::max(1.0, std::abs(x));
  return (f(x - 2 * h) - 8 * f(x - h) + 8 * f(x + h) - f(x + 2 * h)) / (12 * h);
}

/// The derivative of f by duals, over doubles and in every lane of a pack, against a reference.
template <class F>
void expect_derivative(F f, double x, double reference, double tolerance, const std::string& what) {
  using D = Dual<double, 2>;
  using P = Dual<Pack, 2>;
  const D d = f(D::variable(x, 1));
  EXPECT_EQ(d.derivative[0], 0.0) << what;
  EXPECT_NEAR(d.derivative[1], reference, tolerance * std::max(1.0, std::abs(reference))) << what << " at " << x;
  EXPECT_EQ(d.value, f(D(x)).value) << what;
  const P p = f(P::variable(Pack(x), 1));
  for (int l = 0; l < pack_size; ++l) {
    EXPECT_EQ(p.derivative[0][l], 0.0) << what;
    EXPECT_NEAR(p.derivative[1][l], d.derivative[1], 1e-13 * std::max(1.0, std::abs(reference))) << what << " at " << x;
    EXPECT_NEAR(p.value[l], d.value, 1e-14 * std::max(1.0, std::abs(d.value))) << what << " at " << x;
  }
}

#define EXPECT_ANALYTIC(expression, ...)                                                        \
  for (double at : {__VA_ARGS__}) {                                                             \
    const auto f = [](auto x) -> decltype(x) {                                                  \
      using std::exp, std::log, std::log10, std::sin, std::cos, std::tan, std::asin, std::acos; \
      using std::atan, std::sinh, std::cosh, std::tanh, std::sqrt, std::pow;                    \
      return expression;                                                                        \
    };                                                                                          \
    expect_derivative(f, at, complex_step(f, at), 1e-13, #expression);                          \
    expect_derivative(f, at, central_difference(f, at), 1e-7, #expression);                     \
  }

TEST(Dual, DerivativesOfElementaryFunctionsAreThoseOfTheComplexStep){
    EXPECT_ANALYTIC(exp(x), -3.0, 0.1, 2.0) EXPECT_ANALYTIC(log(x), 0.02, 1.0, 30.0) EXPECT_ANALYTIC(log10(x), 0.02, 1.0, 30.0)
        EXPECT_ANALYTIC(sin(x), -2.0, 0.3, 40.0) EXPECT_ANALYTIC(cos(x), -2.0, 0.3, 40.0) EXPECT_ANALYTIC(tan(x), -1.0, 0.3, 2.0)
            EXPECT_ANALYTIC(asin(x), -0.9, 0.1, 0.6) EXPECT_ANALYTIC(acos(x), -0.9, 0.1, 0.6) EXPECT_ANALYTIC(atan(x), -3.0, 0.1, 0.9)
                EXPECT_ANALYTIC(sinh(x), -1.5, 0.2, 3.0) EXPECT_ANALYTIC(cosh(x), -1.5, 0.2, 3.0) EXPECT_ANALYTIC(tanh(x), -1.5, 0.2, 3.0)
                    EXPECT_ANALYTIC(sqrt(x), 0.04, 1.0, 90.0) EXPECT_ANALYTIC(pow(x, 3.0), 0.1, 0.7, 5.0)
                        EXPECT_ANALYTIC(pow(x, -1.5), 0.3, 4.0) EXPECT_ANALYTIC(pow(x, x), 0.3, 1.0, 2.5)
                            EXPECT_ANALYTIC(pow(2.5, x), -1.0, 0.3, 2.0)}

TEST(Dual, DerivativesOfArithmeticAreThoseOfTheComplexStep){
    EXPECT_ANALYTIC(x * x / (1.0 + x), -0.4, 2.0) EXPECT_ANALYTIC(2.0 * x - x * 3.0 + (1.0 - x) * (x - 1.0), -0.4, 2.0)
        EXPECT_ANALYTIC(1.0 / x + x / 3.0 - +x, -0.4, 2.0) EXPECT_ANALYTIC((x += 1.0, x *= x, x -= 0.5, x /= 1.0 + x, -x), 0.4, 2.0)
            EXPECT_ANALYTIC(exp(-x * x) * sin(3.0 * x) / (1.0 + x * x), -0.4, 2.0)}

TEST(Dual, DerivativesOfWhatHasNoComplexFormAreThoseOfDifferences) {
  const auto check = [](auto f, std::initializer_list<double> points, const char* what) {
    for (double x : points) expect_derivative(f, x, central_difference(f, x), 1e-7, what);
  };
  check([](auto x) { return abs(x); }, {-2.0, 0.3}, "abs");
  check([](auto x) { return min(x, x * x); }, {0.4, 1.5}, "min");
  check([](auto x) { return max(x, x * x); }, {0.4, 1.5}, "max");
  check([](auto x) { return max(x, 0.5) * min(x, 0.5); }, {0.4, 1.5}, "with a number");
  check([](auto x) { return pow(x, 3.0); }, {-1.3}, "pow of a negative number");
  check([](auto x) { return expm1(x); }, {-2.0, 1e-3}, "expm1");
  check([](auto x) { return log1p(x); }, {-0.5, 1e-3}, "log1p");
  check([](auto x) { return select(x < decltype(x)(1.0), x * x, 2.0 * x); }, {0.5, 1.5}, "select");
}

TEST(Dual, PartialDerivativesKeepTheirPlaces) {
  using D = Dual<Pack, 3>;
  const D x = D::variable(Pack(2.0), 0);
  const D y = D::variable(Pack(3.0), 1);
  const D z = D::variable(Pack(0.5), 2);
  const D f = x * y * y + pow(y, z) / x;
  EXPECT_NEAR(f.derivative[0][1], 9.0 - std::sqrt(3.0) / 4.0, 1e-14);
  EXPECT_NEAR(f.derivative[1][1], 12.0 + 0.5 / std::sqrt(3.0) / 2.0, 1e-14);
  EXPECT_NEAR(f.derivative[2][1], std::sqrt(3.0) * std::log(3.0) / 2.0, 1e-14);
}

TEST(Dual, IntegerPowersHaveDerivativesAtZeroAndBelow) {
  using D = Dual<double, 1>;
  EXPECT_EQ(pow(D::variable(0.0, 0), 2.0).derivative[0], 0.0);
  EXPECT_EQ(pow(D::variable(0.0, 0), 1.0).derivative[0], 1.0);
  EXPECT_EQ(pow(D::variable(-2.0, 0), 3.0).derivative[0], 12.0);
  const D three = D(3.0);
  EXPECT_EQ(pow(D::variable(0.0, 0), three).derivative[0], 0.0);
  EXPECT_EQ(pow(D::variable(-2.0, 0), three).derivative[0], 12.0);
}

TEST(Dual, ConstantsHaveNoDerivativeAndValuesComeThrough) {
  using D = Dual<Pack, 2>;
  const D c = 4;
  EXPECT_EQ(c.derivative[0][0], 0.0);
  EXPECT_EQ(c.derivative[1][0], 0.0);
  EXPECT_EQ(value_of(c * 0.5)[0], 2.0);
  EXPECT_EQ(value_of(1.5), 1.5);
  EXPECT_EQ(value_of(Pack(1.5))[0], 1.5);
  EXPECT_TRUE(all(D(1.0) < D(2.0)) && all(D(2.0) <= D(2.0)) && all(D(3.0) > D(2.0)) && all(D(3.0) >= D(3.0)));
  EXPECT_TRUE(all(D(2.0) == D(2.0)) && none(D(2.0) != D(2.0)));
}

}  // namespace
}  // namespace stiffront
