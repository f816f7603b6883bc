// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/travelling_wave.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace stiffront {
namespace {

TEST(TravellingWave, ConstantsOfAQuadraticSourceAreTheirClosedForms) {
  // f = u (1 - u) and u = exp(-x^2 / 2): M1 = 2 |x^2 exp(-x^2)| = 2 sqrt(integral x^4 exp(-2 x^2)), and the second integrand is
  // -(1 - 2u) u_x^2 / 12 + u_xx^2 / 3, with only Gaussian moments in its square.
  const auto f = [](double u) -> std::array<double, 5> { return {u * (1.0 - u), 1.0 - 2.0 * u, -2.0, 0.0, 0.0}; };
  const auto bell = [](double x) -> std::array<double, 3> {
    const double u = std::exp(-0.5 * x * x);
    return {u, -x * u, (x * x - 1.0) * u};
  };
  const SplittingConstants c = splitting_constants(f, bell, -12.0, 12.0, 1200);
  // integral x^(2n) exp(-a x^2) = sqrt(pi / a) (2n-1)!! / (2a)^n
  const auto moment = [](int n, double a) {
    double m = std::sqrt(std::numbers::pi / a);
    for (int k = 1; k <= n; ++k) m *= (2 * k - 1) / (2.0 * a);
    return m;
  };
  // With u^2 = e^(-x^2): second = p(x) e^(-x^2) + q(x) e^(-3x^2/2), p = -x^2/12 + (x^2-1)^2/3, q = x^2/6.
  const double p[] = {1.0 / 3.0, -1.0 / 12.0 - 2.0 / 3.0, 1.0 / 3.0};  // in x^2
  double square = 0.0;
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b < 3; ++b) square += p[a] * p[b] * moment(a + b, 2.0);
    square += 2.0 * p[a] / 6.0 * moment(a + 1, 2.5);
  }
  square += moment(2, 3.0) / 36.0;
  EXPECT_NEAR(c.m1, 2.0 * std::sqrt(moment(2, 2.0)), 1e-14);
  EXPECT_NEAR(c.m2, std::sqrt(square), 1e-14);
}

TEST(TravellingWave, ConstantsOfTheKppWave) {
  const SplittingConstants c = kpp_splitting_constants();
  EXPECT_NEAR(c.m1, 7.106871831e-2, 1e-11);
  EXPECT_NEAR(c.m2, 3.209621819e-3, 1e-12);
  // M1 in closed form: integral f''^2 u_x^4 dx = integral over u of (2 - 6u)^2 |u_x|^3 = (u (1-u))^3 / 2^(3/2).
  // Beta integrals: B(4,4) = 1/140, B(5,4) = 1/280, B(6,4) = 1/504.
  EXPECT_NEAR(c.m1, std::sqrt((4.0 / 140.0 - 24.0 / 280.0 + 36.0 / 504.0) / std::pow(2.0, 1.5)), 1e-14);
}

TEST(TravellingWave, CriticalStepsOfThePaperToAllPrintedDigits) {
  // Table 1 of Descombes et al. 2011, estimated steps for epsilon = 0.05, 0.005, 0.0005.
  const SplittingConstants c = kpp_splitting_constants();
  for (const auto& [k, step] : {std::pair{1.0, 1.107}, {10.0, 0.1107}, {100.0, 0.01107}}) {
    EXPECT_NEAR(critical_splitting_step(c, 0.05, k), step, 5e-4 * step);
    EXPECT_NEAR(critical_splitting_step(c, 0.005, k), 0.1 * step, 5e-5 * step);
    EXPECT_NEAR(critical_splitting_step(c, 0.0005, k), 0.01 * step, 5e-6 * step);
  }
}

TEST(TravellingWave, ScalingAgreesWithTheFormulaAtOtherCoefficients) {
  // The commutators of k f and D Laplacian: k D f'' u_x^2 and the terms of eq. (4.2), on the profile of length sqrt(D/k).
  const double k = 7.0, diffusion = 0.3;
  const double length = std::sqrt(diffusion / k);
  const auto profile = [&](double x) -> std::array<double, 3> {
    const double z = x / length;
    const double u = 1.0 / (1.0 + std::exp(z / std::numbers::sqrt2));
    return {u, -u * (1.0 - u) / (std::numbers::sqrt2 * length), 0.5 * u * (1.0 - u) * (1.0 - 2.0 * u) / (length * length)};
  };
  double first = 0.0, second = 0.0;
  const double dx = 120.0 * length / 2400;
  for (int i = 0; i <= 2400; ++i) {
    const auto [u, ux, uxx] = profile(-60.0 * length + i * dx);
    const double f = u * u * (1.0 - u), f1 = u * (2.0 - 3.0 * u), f2 = 2.0 - 6.0 * u, f3 = -6.0;
    const double a = k * diffusion * f2 * ux * ux;
    const double b = k * k * diffusion / 24.0 * (f1 * f2 + f * f3) * ux * ux - k * diffusion * diffusion / 3.0 * f3 * ux * ux * uxx -
                     k * diffusion * diffusion / 6.0 * f2 * uxx * uxx;
    first += a * a * dx;
    second += b * b * dx;
  }
  const SplittingConstants c = scaled(kpp_splitting_constants(), k, diffusion);
  EXPECT_NEAR(c.m1, std::sqrt(first), 1e-12 * c.m1);
  EXPECT_NEAR(c.m2, std::sqrt(second), 1e-12 * c.m2);
  EXPECT_NEAR(c.m1 / c.m2, critical_splitting_step(kpp_splitting_constants(), 1.0, k), 1e-12);
}

}  // namespace
}  // namespace stiffront
