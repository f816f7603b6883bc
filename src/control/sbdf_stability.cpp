// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/sbdf_stability.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace stiffront::sbdf_stability {
namespace {

double conjugate(double x) { return x; }
std::complex<double> conjugate(std::complex<double> x) { return std::conj(x); }

// Lagrange weight of node i (of the nodes first..last) at t = 0.
double extrapolation_weight(std::span<const double> t, std::size_t first, std::size_t last, std::size_t i) {
  double weight = 1;
  for (std::size_t m = first; m <= last; ++m) {
    if (m != i) weight *= t[m] / (t[m] - t[i]);
  }
  return weight;
}

}  // namespace

StepWeights step_weights(int order, std::span<const double> steps) {
  StepWeights weights;
  weights.order = order;
  const auto k = static_cast<std::size_t>(order);
  std::array<double, max_order + 2> t{};  // t[i]: time of v_{n-i} in units of the step, the new one at 0
  for (std::size_t i = 0; i <= k; ++i) t[i + 1] = t[i] - steps[i] / steps[0];

  for (std::size_t i = 1; i <= k + 1; ++i) weights.predictor[i - 1] = extrapolation_weight(t, 1, k + 1, i);

  // The derivative at t[0] = 0 of the polynomial through nodes 0..k: d_0 = -sum 1/t_m, and for i > 0
  // d_i = (product over m != 0, i of t_m/(t_m - t_i)) / t_i, the Lagrange polynomial being zero at 0.
  double leading = 0;
  for (std::size_t m = 1; m <= k; ++m) leading -= 1 / t[m];
  weights.gamma = 1 / leading;
  for (std::size_t i = 1; i <= k; ++i) {
    weights.history[i - 1] = -weights.gamma * extrapolation_weight(t, 1, k, i) / t[i];
  }
  return weights;
}

StepWeights constant_step_weights(int order) {
  std::array<double, max_order + 1> steps{};
  steps.fill(1);
  return step_weights(order, steps);
}

template <typename T>
T sweep_remainder(double gamma, double z, double mu, T reaction, std::span<const double> shifts) {
  T phi = 1;
  for (const double g : shifts) phi *= gamma * z * (g / 2 - mu) / (1 + gamma * z * g / 2 + gamma * reaction);
  return phi;
}

template <typename T>
Recursion<T> recursion(const StepWeights& weights, T phi, T y) {
  Recursion<T> result;
  result.length = weights.order + 1;
  const T corrected = (1.0 - phi) / (1.0 + y);
  // The history of one order less is padded with a zero: it has k terms, the predictor k + 1.
  for (std::size_t i = 0; i <= static_cast<std::size_t>(weights.order); ++i) {
    result.c[i] = phi * weights.predictor[i];
    if (i < weights.history.size()) result.c[i] += corrected * weights.history[i];
  }
  return result;
}

template <typename T>
Recursion<T> mode_recursion(const StepWeights& weights, double z, double mu, T reaction, std::span<const double> shifts) {
  const T phi = sweep_remainder(weights.gamma, z, mu, reaction, shifts);
  return recursion<T>(weights, phi, weights.gamma * (z * mu + reaction));
}

template <typename T>
bool roots_within(const Recursion<T>& recursion, double radius) {
  std::array<T, max_order + 2> p{};
  p[0] = 1;
  double scale = 1;
  auto degree = static_cast<std::size_t>(recursion.length);
  for (std::size_t i = 0; i < degree; ++i) {
    scale /= radius;
    p[i + 1] = -recursion.c[i] * scale;
  }
  for (; degree > 0; --degree) {
    const T first = p[0];
    const T last = p[degree];
    if (!(std::norm(last) < std::norm(first))) return false;  // also for not-a-number
    const double normalise = 1 / std::norm(first);
    std::array<T, max_order + 2> reduced{};
    for (std::size_t i = 0; i < degree; ++i) {
      reduced[i] = (conjugate(first) * p[i] - last * conjugate(p[degree - i])) * normalise;
    }
    p = reduced;
  }
  return true;
}

template <typename T>
double largest_root(const Recursion<T>& recursion) {
  double outside = 0;
  double inside = 1;  // Cauchy's bound: 1 + the largest coefficient
  for (const T& c : recursion.c) inside = std::max(inside, 1 + std::abs(c));
  while (inside - outside > 1e-9 * inside) {
    const double middle = (inside + outside) / 2;
    (roots_within(recursion, middle) ? inside : outside) = middle;
    if (inside < 1e-12) break;
  }
  return inside;
}

double required_modulus(double decay, double modulus) { return std::max(modulus, std::exp(-decay / 2)); }

bool all_modes_damped(int order, std::span<const double> shifts, double z, double modulus, int points_per_lobe) {
  const StepWeights weights = constant_step_weights(order);
  std::vector<double> ends;  // phi(mu) = 0 at g/2; between them it has one extremum each
  for (const double g : shifts) ends.push_back(g / 2);
  ends.insert(ends.end(), {0.0, 1.0});
  std::sort(ends.begin(), ends.end());
  std::vector<double> mus;
  for (std::size_t lobe = 0; lobe + 1 < ends.size(); ++lobe) {
    const double width = ends[lobe + 1] - ends[lobe];
    if (!(width > 0)) continue;
    for (int i = 1; i <= points_per_lobe; ++i) mus.push_back(ends[lobe] + width * i / points_per_lobe);
  }
  std::vector<double> reactions{0};
  for (double reaction = 1e-3; reaction < 1e5; reaction *= 2) reactions.push_back(reaction);

  // The finest part of the range of z' lies next to z, where the limit is.
  constexpr std::array fractions{1.0, 0.99, 0.97, 0.94, 0.9, 0.85, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2, 0.1, 0.03, 0.01};
  for (const double fraction : fractions) {
    const double z_here = fraction * z;
    for (const double reaction : reactions) {
      for (const double mu : mus) {
        const double allowed = required_modulus(z_here * mu + reaction, modulus);
        if (!roots_within(mode_recursion(weights, z_here, mu, reaction, shifts), allowed)) return false;
      }
    }
  }
  return true;
}

template double sweep_remainder(double, double, double, double, std::span<const double>);
template std::complex<double> sweep_remainder(double, double, double, std::complex<double>, std::span<const double>);
template Recursion<double> recursion(const StepWeights&, double, double);
template Recursion<std::complex<double>> recursion(const StepWeights&, std::complex<double>, std::complex<double>);
template Recursion<double> mode_recursion(const StepWeights&, double, double, double, std::span<const double>);
template Recursion<std::complex<double>> mode_recursion(const StepWeights&, double, double, std::complex<double>, std::span<const double>);
template bool roots_within(const Recursion<double>&, double);
template bool roots_within(const Recursion<std::complex<double>>&, double);
template double largest_root(const Recursion<double>&);
template double largest_root(const Recursion<std::complex<double>>&);

}  // namespace stiffront::sbdf_stability
