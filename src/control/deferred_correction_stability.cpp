// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/deferred_correction_stability.hpp"

#include <cmath>
#include <limits>

namespace stiffront {

std::complex<double> deferred_correction_amplification(const CollocationNodes& nodes, int k, std::complex<double> z) {
  using Complex = std::complex<double>;
  const auto m = static_cast<std::size_t>(nodes.size());
  std::vector<Complex> factor(m), v(m), s(m), integral(m);
  Complex left = 1.0;
  for (std::size_t i = 0; i < m; ++i) {
    factor[i] = std::exp(nodes.interval(static_cast<int>(i)) * z);
    v[i] = s[i] = left = factor[i] * left;
  }
  for (int iteration = 0; iteration < k; ++iteration) {
    for (std::size_t i = 0; i < m; ++i) {
      integral[i] = 0.0;
      for (std::size_t j = 0; j < m; ++j) integral[i] += z * nodes.between(static_cast<int>(i), static_cast<int>(j)) * v[j];
    }
    Complex old_left = 1.0;
    for (std::size_t i = 0; i < m; ++i) {
      const Complex old = v[i];
      if (i == 0) {
        v[0] = 1.0 + integral[0];
      } else {
        const Complex again = factor[i] * v[i - 1];
        v[i] = old_left + integral[i] + again - s[i];
        s[i] = again;
      }
      old_left = old;
    }
  }
  return v.back();
}

std::vector<double> deferred_correction_stability_limits(const CollocationNodes& nodes, int most) {
  // Beyond `far` the exponentials are 0 and R_k is a polynomial of z that has left the unit circle or is 0.
  constexpr double ratio = 1.01;
  constexpr double far = 1e4;
  constexpr double round_off = 1e-9;
  std::vector<double> limits;
  for (int k = 0; k <= most; ++k) {
    const auto stable = [&](double z) { return std::abs(deferred_correction_amplification(nodes, k, -z)) <= 1.0 + round_off; };
    double below = 1e-2;
    double above = below;
    while (above < far && stable(above)) below = above, above *= ratio;
    if (above >= far) {
      limits.push_back(std::numeric_limits<double>::infinity());
      continue;
    }
    while (above - below > 1e-5 * above) {
      const double middle = 0.5 * (below + above);
      (stable(middle) ? below : above) = middle;
    }
    limits.push_back(below);
  }
  return limits;
}

}  // namespace stiffront
