// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cmath>

#include "stiffront/model/model.hpp"

namespace stiffront {

/// The pulsating flame with its fast reaction in balance with the slow one, k1 = k2: fuel Y and temperature Theta at the radius x,
///
///     Y_t     = (Y_xx + Y_x / x) / L_Y - V Y_x / x - k1
///     Theta_t = Theta_xx + Theta_x / x - V Theta_x / x + k1
///
/// Where the pulsating flame starts. In one dimension; by a coupled method.
/// @see Hagstrom & Zhou 2006, section 6.3; Bayliss, Gottlieb, Matkowsky & Minkoff, J. Comput. Phys. 81, 1989
struct ReducedPulsatingFlame {
  static constexpr int n_species = 2;
  static constexpr const char* name = "reduced-pulsating-flame";
  static constexpr const char* source = "pulsating cylindrical flame, one reaction; Hagstrom & Zhou 2006, section 6.3";
  static constexpr std::array<const char*, 2> species{"Y", "Theta"};
  static constexpr std::array<double, 2> diffusion{0.5, 1.0};  // 1/L_Y, 1
  static const std::array<Parameter<ReducedPulsatingFlame>, 5> parameters;
  static const std::array<Profile<ReducedPulsatingFlame>, 1> profiles;

  double V = 11.7;
  double L_Y = 2.0;  ///< Lewis number; the diffusion coefficient of Y must be set to 1/L_Y
  double sigma = 0.5;
  double A1 = 2e2;
  double E1 = 40.0;

  template <class T, class P>
  void rates(const T* u, T* du, const P&) const {
    const T k1 = A1 * u[0] * exp(E1 * (1.0 - sigma) * (u[1] - 1.0) / (sigma + (1.0 - sigma) * u[1]));
    du[0] = -k1;
    du[1] = k1;
  }

  template <class T, class P>
  void transport(const T*, const T* u_x, const T*, T* du, const P& place) const {
    du[0] = (1.0 / L_Y - V) * u_x[0] / place.x;
    du[1] = (1.0 - V) * u_x[1] / place.x;
  }

  /// A thin flame at x = 11 with its preheat zone.
  static void start(const ReducedPulsatingFlame& m, const Grid& grid, std::int64_t i, std::int64_t, double* u) {
    const double x = grid.position(0, i);
    u[0] = x < 11.0 ? 1.0 - std::pow(x / 11.0, m.L_Y * m.V) : 0.0;
    u[1] = x < 11.0 ? std::pow(x / 11.0, m.V) : 1.0;
  }
};

inline constexpr std::array<Parameter<ReducedPulsatingFlame>, 5> ReducedPulsatingFlame::parameters{
    {{"V", &ReducedPulsatingFlame::V},
     {"L_Y", &ReducedPulsatingFlame::L_Y},
     {"sigma", &ReducedPulsatingFlame::sigma},
     {"A1", &ReducedPulsatingFlame::A1},
     {"E1", &ReducedPulsatingFlame::E1}}};
inline constexpr std::array<Profile<ReducedPulsatingFlame>, 1> ReducedPulsatingFlame::profiles{
    {{"reduced-flame-at-11", "Theta = (x/11)^V, Y = 1 - (x/11)^(L_Y V) up to x = 11, burnt beyond", &ReducedPulsatingFlame::start}}};

}  // namespace stiffront
