// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <cmath>

#include "stiffront/model/model.hpp"

namespace stiffront {

/// Cylindrical flame around a source of fuel with a stiff intermediate: fuel Y, radical W and temperature Theta at the radius x,
///
///     Y_t     = (Y_xx + Y_x / x) / L_Y - V Y_x / x - k1
///     W_t     = (W_xx + W_x / x) / L_W - V W_x / x + k1 - k2
///     Theta_t = Theta_xx + Theta_x / x - V Theta_x / x + k1 + gamma (k2 - k1)
///
/// with k1 = A1 Y exp(E1 z), k2 = A2 W^2 exp(E2 z), z = (1 - sigma)(Theta - 1) / (sigma + (1 - sigma) Theta). The flame pulsates: its
/// fuel diffuses slower than heat. In one dimension; by a coupled method.
/// @see Hagstrom & Zhou 2006, eqs. (6-14)-(6-20), which do not say what gamma is
struct PulsatingFlame {
  static constexpr int n_species = 3;
  static constexpr const char* name = "pulsating-flame";
  static constexpr const char* source = "pulsating cylindrical flame with a stiff intermediate; Hagstrom & Zhou 2006, section 6.3";
  static constexpr std::array<const char*, 3> species{"Y", "W", "Theta"};
  static constexpr std::array<double, 3> diffusion{0.5, 2.0 / 3.0, 1.0};  // 1/L_Y, 1/L_W, 1
  static const std::array<Parameter<PulsatingFlame>, 9> parameters;
  static const std::array<Profile<PulsatingFlame>, 1> profiles;

  double V = 11.7;
  double L_Y = 2.0;  ///< Lewis numbers; the diffusion coefficients must be set to 1/L_Y and 1/L_W
  double L_W = 1.5;
  double sigma = 0.5;
  double A1 = 2e2;
  double E1 = 40.0;
  double A2 = 2e6;
  double E2 = 2.0;
  double gamma = 0.5;

  template <class T, class P>
  void rates(const T* u, T* du, const P&) const {
    const T z = (1.0 - sigma) * (u[2] - 1.0) / (sigma + (1.0 - sigma) * u[2]);
    const T k1 = A1 * u[0] * exp(E1 * z);
    const T k2 = A2 * u[1] * u[1] * exp(E2 * z);
    du[0] = -k1;
    du[1] = k1 - k2;
    du[2] = k1 + gamma * (k2 - k1);
  }

  template <class T, class P>
  void transport(const T*, const T* u_x, const T*, T* du, const P& place) const {
    du[0] = (1.0 / L_Y - V) * u_x[0] / place.x;
    du[1] = (1.0 / L_W - V) * u_x[1] / place.x;
    du[2] = (1.0 - V) * u_x[2] / place.x;
  }

  /// A thin flame at x = 11 with its preheat zone, and W in equilibrium, k1 = k2.
  static void start(const PulsatingFlame& m, const Grid& grid, std::int64_t i, std::int64_t, double* u) {
    const double x = grid.position(0, i);
    u[2] = x < 11.0 ? std::pow(x / 11.0, m.V) : 1.0;
    u[0] = x < 11.0 ? 1.0 - std::pow(x / 11.0, m.L_Y * m.V) : 0.0;
    u[1] = m.equilibrium(u[0], u[2]);
  }
  double equilibrium(double fuel, double temperature) const {
    const double z = (1.0 - sigma) * (temperature - 1.0) / (sigma + (1.0 - sigma) * temperature);
    return std::sqrt(std::max(0.0, A1 / A2 * fuel * std::exp((E1 - E2) * z)));
  }
};

inline constexpr std::array<Parameter<PulsatingFlame>, 9> PulsatingFlame::parameters{{{"V", &PulsatingFlame::V},
                                                                                      {"L_Y", &PulsatingFlame::L_Y},
                                                                                      {"L_W", &PulsatingFlame::L_W},
                                                                                      {"sigma", &PulsatingFlame::sigma},
                                                                                      {"A1", &PulsatingFlame::A1},
                                                                                      {"E1", &PulsatingFlame::E1},
                                                                                      {"A2", &PulsatingFlame::A2},
                                                                                      {"E2", &PulsatingFlame::E2},
                                                                                      {"gamma", &PulsatingFlame::gamma}}};
inline constexpr std::array<Profile<PulsatingFlame>, 1> PulsatingFlame::profiles{
    {{"flame-at-11", "Theta = (x/11)^V, Y = 1 - (x/11)^(L_Y V) up to x = 11, burnt beyond; W in equilibrium", &PulsatingFlame::start}}};

}  // namespace stiffront
