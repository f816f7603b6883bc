// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cmath>

#include "stiffront/model/model.hpp"

namespace stiffront {

/// FitzHugh-Nagumo nerve equations, du/dt = (u (1 - u) (u - a) - v) / epsilon, dv/dt = u - gamma v; the recovery v does not diffuse.
///
/// @see FitzHugh, Biophys. J. 1, 1961, pp. 445-466; Nagumo, Arimoto & Yoshizawa, Proc. IRE 50, 1962, pp. 2061-2070.
struct FitzhughNagumo {
  static constexpr int n_species = 2;
  static constexpr const char* name = "fitzhugh-nagumo";
  static constexpr const char* source = "FitzHugh-Nagumo; FitzHugh 1961, Nagumo et al. 1962";
  static constexpr std::array<const char*, 2> species{"u", "v"};
  static constexpr std::array<double, 2> diffusion{1.0, 0.0};
  static const std::array<Parameter<FitzhughNagumo>, 3> parameters;
  static const std::array<Profile<FitzhughNagumo>, 1> profiles;

  double epsilon = 0.01;
  double a = 0.1;
  double gamma = 1.0;

  template <class T, class P>
  void rates(const T* u, T* du, const P&) const {
    du[0] = (u[0] * (1.0 - u[0]) * (u[0] - a) - u[1]) * (1.0 / epsilon);
    du[1] = u[0] - gamma * u[1];
  }

  static void front(const FitzhughNagumo&, const Grid& grid, std::int64_t i, std::int64_t, double* u) {
    u[0] = 0.5 - 0.5 * std::tanh((grid.position(0, i) - 3.0) / 0.5);
    u[1] = 0.0;
  }
};

inline constexpr std::array<Parameter<FitzhughNagumo>, 3> FitzhughNagumo::parameters{
    {{"epsilon", &FitzhughNagumo::epsilon}, {"a", &FitzhughNagumo::a}, {"gamma", &FitzhughNagumo::gamma}}};
inline constexpr std::array<Profile<FitzhughNagumo>, 1> FitzhughNagumo::profiles{
    {{"fitzhugh-nagumo-front", "excited for x < 3, at rest beyond, v = 0", &FitzhughNagumo::front}}};

}  // namespace stiffront
