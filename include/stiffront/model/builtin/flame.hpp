// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cmath>

#include "stiffront/model/model.hpp"

namespace stiffront {

/// Premixed flame with one Arrhenius reaction in the thermo-diffusive model: fuel Y and reduced temperature theta,
///
///     dY/dt = -w, dtheta/dt = w,  w = Ze^2 / (2 Le) Y exp(-Ze (1 - theta) / (1 - alpha (1 - theta)))
///
/// with the diffusion coefficients 1/Le and 1: lengths are in units of the flame thickness, and the flame moves with a speed near 1.
/// @see Zeldovich, Barenblatt, Librovich & Makhviladze, The Mathematical Theory of Combustion and Explosions, 1985.
struct Flame {
  static constexpr int n_species = 2;
  static constexpr const char* name = "flame";
  static constexpr const char* source = "thermo-diffusive premixed flame; Zeldovich et al. 1985";
  static constexpr std::array<const char*, 2> species{"fuel", "theta"};
  static constexpr std::array<double, 2> diffusion{1.0, 1.0};
  static const std::array<Parameter<Flame>, 3> parameters;
  static const std::array<Profile<Flame>, 1> profiles;

  double Ze = 10.0;     ///< Zeldovich number
  double Le = 1.0;      ///< Lewis number; the fuel's diffusion coefficient must be set to 1/Le
  double alpha = 0.85;  ///< heat release, (T_burnt - T_fresh) / T_burnt

  template <class T, class P>
  void rates(const T* u, T* du, const P&) const {
    const T below = 1.0 - u[1];
    const T w = (Ze * Ze / (2.0 * Le)) * u[0] * exp(-Ze * below / (1.0 - alpha * below));
    du[0] = -w;
    du[1] = w;
  }

  /// Burnt up to a fifth of the domain, preheated ahead as in the limit of a thin reaction zone.
  static void front(const Flame& m, const Grid& grid, std::int64_t i, std::int64_t, double* u) {
    const std::int64_t fifths_ahead = 5 * i - grid.intervals(0);
    const double ahead = static_cast<double>(fifths_ahead) * grid.spacing(0) / 5.0;
    u[0] = fifths_ahead < 0 ? 0.0 : 1.0 - std::exp(-m.Le * ahead);
    u[1] = fifths_ahead < 0 ? 1.0 : std::exp(-ahead);
  }
};

inline constexpr std::array<Parameter<Flame>, 3> Flame::parameters{{{"Ze", &Flame::Ze}, {"Le", &Flame::Le}, {"alpha", &Flame::alpha}}};
inline constexpr std::array<Profile<Flame>, 1> Flame::profiles{
    {{"flame-front", "burnt in the lower fifth, preheat zone ahead", &Flame::front}}};

}  // namespace stiffront
