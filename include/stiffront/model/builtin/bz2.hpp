// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "stiffront/model/builtin/bz.hpp"

namespace stiffront {

/// Belousov-Zhabotinsky reaction, two variables: b (bromous acid), c (cerium(IV)). The limit mu -> 0 of Bz, in which bromide
/// follows at once, a = f c / (q + b):
///
///     db/dt = (b (1 - b) + f (q - b) c / (q + b)) / epsilon,  dc/dt = b - c
///
/// @see Tyson & Fife, J. Chem. Phys. 73, 1980, pp. 2224-2237; Gray & Scott, Chemical Oscillations and Instabilities, 1994.
struct Bz2 {
  static constexpr int n_species = 2;
  static constexpr const char* name = "bz2";
  static constexpr const char* source = "Belousov-Zhabotinsky, 2 variables; Tyson & Fife 1980";
  static constexpr std::array<const char*, 2> species{"b", "c"};
  static constexpr std::array<double, 2> diffusion{2.5e-3, 1.5e-3};
  static const std::array<Parameter<Bz2>, 3> parameters;
  static const std::array<Profile<Bz2>, 3> profiles;

  double epsilon = 1e-2;
  double f = 1.6;
  double q = 2e-3;

  template <class T, class P>
  void rates(const T* u, T* du, const P&) const {
    const T& b = u[0];
    const T& c = u[1];
    du[0] = (b * (1.0 - b) + f * c * (q - b) / (q + b)) * (1.0 / epsilon);
    du[1] = b - c;
  }

  /// The states of Bz without bromide, which is in balance there.
  template <void (*Evaluate)(const Bz&, const Grid&, std::int64_t, std::int64_t, double*)>
  static void from_bz(const Bz2& m, const Grid& grid, std::int64_t i, std::int64_t j, double* u) {
    Bz full;
    full.f = m.f;
    full.q = m.q;
    double abc[Bz::n_species];
    Evaluate(full, grid, i, j, abc);
    u[0] = abc[1];
    u[1] = abc[2];
  }
};

inline constexpr std::array<Parameter<Bz2>, 3> Bz2::parameters{{{"epsilon", &Bz2::epsilon}, {"f", &Bz2::f}, {"q", &Bz2::q}}};
inline constexpr std::array<Profile<Bz2>, 3> Bz2::profiles{
    {{"bz2-front", "ignited strip near the lower x side, b = c = 0 elsewhere", &Bz2::from_bz<&Bz::front>},
     {"bz2-ignition", "medium at rest, middle 40th ignited", &Bz2::from_bz<&Bz::ignition>},
     {"bz2-spiral", "ignited wedge around the centre (2-D)", &Bz2::from_bz<&Bz::spiral>, 2}}};

}  // namespace stiffront
