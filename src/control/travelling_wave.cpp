// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/travelling_wave.hpp"

#include <cmath>
#include <numbers>

namespace stiffront {

SplittingConstants splitting_constants(const ReactionJet& f, const ProfileJet& profile, double lower, double upper, int n) {
  const double dx = (upper - lower) / n;
  double sum1 = 0.0;
  double sum2 = 0.0;
  for (int i = 0; i <= n; ++i) {
    const auto [u, ux, uxx] = profile(lower + i * dx);
    const auto [f0, f1, f2, f3, f4] = f(u);
    const double g = ux * ux;
    const double first = f2 * g;
    const double second = (f1 * f2 + f0 * f3) / 24.0 * g - f4 / 12.0 * g * g - f3 / 3.0 * g * uxx - f2 / 6.0 * uxx * uxx;
    const double weight = i == 0 || i == n ? 0.5 : 1.0;
    sum1 += weight * first * first;
    sum2 += weight * second * second;
  }
  return {std::sqrt(dx * sum1), std::sqrt(dx * sum2)};
}

SplittingConstants kpp_splitting_constants() {
  const auto f = [](double u) -> std::array<double, 5> { return {u * u * (1.0 - u), u * (2.0 - 3.0 * u), 2.0 - 6.0 * u, -6.0, 0.0}; };
  const auto profile = [](double x) -> std::array<double, 3> {
    const double u = 1.0 / (1.0 + std::exp(x / std::numbers::sqrt2));
    const double ux = -u * (1.0 - u) / std::numbers::sqrt2;
    return {u, ux, 0.5 * u * (1.0 - u) * (1.0 - 2.0 * u)};
  };
  return splitting_constants(f, profile, -60.0, 60.0, 2400);
}

double critical_splitting_step(const SplittingConstants& c, double epsilon, double k) { return epsilon * c.m1 / (k * c.m2); }

SplittingConstants scaled(const SplittingConstants& c, double k, double diffusion) {
  const double length = std::sqrt(std::sqrt(diffusion / k));  // the square root of dx in the norm
  return {c.m1 * k * k * length, c.m2 * k * k * k * length};
}

}  // namespace stiffront
