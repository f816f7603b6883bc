// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cmath>
#include <type_traits>

#include "stiffront/model/model.hpp"

namespace stiffront {

/// Autocatalytic decay fed from outside for a limited time around x = 1/2,
///
///     du/dt = s - 20 u^2 v - u,  dv/dt = 5 u - 5 v,  s = strength exp(-((x - 1/2) / 0.1)^2) for on < t <= off, else 0
///
/// A test of sources that switch: a run should have `on` and `off` among its breakpoints.
struct Pulse {
  static constexpr int n_species = 2;
  static constexpr const char* name = "pulse";
  static constexpr const char* source = "a source switched on and off, our own test of time-dependent rates";
  static constexpr std::array<const char*, 2> species{"u", "v"};
  static constexpr std::array<double, 2> diffusion{0.01, 1e-3};
  static const std::array<Parameter<Pulse>, 3> parameters;
  static const std::array<Profile<Pulse>, 1> profiles;

  double strength = 50.0;
  double on = 0.3;
  double off = 0.6;

  template <class T, class P>
  void rates(const T* u, T* du, const P& place) const {
    using Real = std::remove_cvref_t<decltype(place.x)>;
    const auto fed = (place.t > on) && (place.t <= off);
    Real s(0.0);
    if (any(fed)) {
      const Real z = (place.x - 0.5) / 0.1;
      s = select(fed, strength * exp(-(z * z)), s);
    }
    du[0] = s - 20.0 * u[0] * u[0] * u[1] - u[0];
    du[1] = 5.0 * u[0] - 5.0 * u[1];
  }

  static void uniform(const Pulse&, const Grid&, std::int64_t, std::int64_t, double* u) { u[0] = u[1] = 0.1; }
};

inline constexpr std::array<Parameter<Pulse>, 3> Pulse::parameters{
    {{"strength", &Pulse::strength}, {"on", &Pulse::on}, {"off", &Pulse::off}}};
inline constexpr std::array<Profile<Pulse>, 1> Pulse::profiles{{{"pulse-uniform", "u = v = 0.1", &Pulse::uniform}}};

}  // namespace stiffront
