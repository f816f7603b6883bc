// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cmath>
#include <numbers>

#include "stiffront/model/model.hpp"

namespace stiffront {

/// Kolmogorov-Petrovskii-Piskunov equation with cubic source, du/dt = k u^2 (1 - u).
///
/// Its wave u = 1 / (1 + exp((x - c t) sqrt(k / (2 D)))) moves with the speed c = sqrt(k D / 2).
/// @see Descombes et al. 2011, eq. (4.9), where k D = 1: steeper fronts of one speed as k grows.
struct Kpp {
  static constexpr int n_species = 1;
  static constexpr const char* name = "kpp";
  static constexpr const char* source = "KPP equation with source k u^2 (1 - u); Descombes et al. 2011, section 4.2";
  static constexpr std::array<const char*, 1> species{"u"};
  static constexpr std::array<double, 1> diffusion{1.0};
  static const std::array<Parameter<Kpp>, 1> parameters;
  static const std::array<Profile<Kpp>, 1> profiles;

  double k = 1.0;

  template <class T, class P>
  void rates(const T* u, T* du, const P&) const {
    du[0] = k * (u[0] * u[0] * (1.0 - u[0]));
  }

  /// The exact wave of D = 1/k with its middle at x = 0.
  static void front(const Kpp& m, const Grid& grid, std::int64_t i, std::int64_t, double* u) {
    const double z = m.k * grid.position(0, i) / std::numbers::sqrt2;
    // 1 / (1 + exp(z)) without the overflow of exp far ahead of the front.
    const double e = std::exp(-std::abs(z));
    u[0] = (z > 0.0 ? e : 1.0) / (1.0 + e);
  }
};

inline constexpr std::array<Parameter<Kpp>, 1> Kpp::parameters{{{"k", &Kpp::k}}};
inline constexpr std::array<Profile<Kpp>, 1> Kpp::profiles{
    {{"kpp-front", "the travelling wave for D = 1/k, middle at x = 0", &Kpp::front}}};

}  // namespace stiffront
