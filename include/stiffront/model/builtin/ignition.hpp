// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cmath>

#include "stiffront/model/model.hpp"

namespace stiffront {

/// Thermal explosion of a hot spot: fuel Y and heat theta,
///
///     dY/dt = -w, dtheta/dt = w,  w = rate Y exp(energy theta / (1 + alpha theta))
///
/// Slow at first, then a runaway in a few cells and waves from there.
/// @see Frank-Kamenetskii, Diffusion and Heat Transfer in Chemical Kinetics, 1969.
struct Ignition {
  static constexpr int n_species = 2;
  static constexpr const char* name = "ignition";
  static constexpr const char* source = "thermal explosion with Arrhenius kinetics; Frank-Kamenetskii 1969";
  static constexpr std::array<const char*, 2> species{"fuel", "theta"};
  static constexpr std::array<double, 2> diffusion{1e-4, 1e-4};
  static const std::array<Parameter<Ignition>, 3> parameters;
  static const std::array<Profile<Ignition>, 1> profiles;

  double rate = 0.016;
  double energy = 10.0;
  double alpha = 0.2;

  template <class T, class P>
  void rates(const T* u, T* du, const P&) const {
    const T w = rate * u[0] * exp(energy * u[1] / (1.0 + alpha * u[1]));
    du[0] = -w;
    du[1] = w;
  }

  static void spot(const Ignition&, const Grid& grid, std::int64_t i, std::int64_t, double* u) {
    const double s = (grid.fraction(0, i) - 0.5) / 0.03;
    u[0] = 1.0;
    u[1] = 0.2 * std::exp(-s * s);
  }
};

inline constexpr std::array<Parameter<Ignition>, 3> Ignition::parameters{
    {{"rate", &Ignition::rate}, {"energy", &Ignition::energy}, {"alpha", &Ignition::alpha}}};
inline constexpr std::array<Profile<Ignition>, 1> Ignition::profiles{
    {{"ignition-spot", "fuel everywhere, a warm spot in the middle", &Ignition::spot}}};

}  // namespace stiffront
