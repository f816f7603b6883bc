// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cmath>
#include <numbers>

#include "stiffront/model/model.hpp"

namespace stiffront {

/// Tumour angiogenesis without chemotaxis: density rho of capillary tips, which hardly move, and growth factor c, which diffuses fast,
///
///     drho/dt = mu rho (1 - rho) (c - c_star) - beta rho,  dc/dt = -lambda c - alpha rho c / (1 + c)
///
/// A test of diffusion much faster than the reaction. The published model has max(0, c - c_star), or a smoothed form of it, and
/// transport of rho along the gradient of c.
/// @see Hagstrom & Zhou 2006, eqs. (6-8)-(6-11); Hundsdorfer & Verwer, Time-Dependent Advection-Diffusion-Reaction Equations, 2003.
struct Angiogenesis {
  static constexpr int n_species = 2;
  static constexpr const char* name = "angiogenesis";
  static constexpr const char* source = "tumour angiogenesis without chemotaxis; after Hagstrom & Zhou 2006, section 6.2";
  static constexpr std::array<const char*, 2> species{"rho", "c"};
  static constexpr std::array<double, 2> diffusion{1e-3, 1.0};
  static const std::array<Parameter<Angiogenesis>, 5> parameters;
  static const std::array<Profile<Angiogenesis>, 1> profiles;

  double mu = 100.0;
  double c_star = 0.2;
  double beta = 4.0;
  double lambda = 1.0;
  double alpha = 10.0;

  template <class T, class P>
  void rates(const T* u, T* du, const P&) const {
    const T& rho = u[0];
    const T& c = u[1];
    du[0] = mu * rho * (1.0 - rho) * (c - c_star) - beta * rho;
    du[1] = -lambda * c - alpha * rho * c / (1.0 + c);
  }

  static void invasion(const Angiogenesis&, const Grid& grid, std::int64_t i, std::int64_t, double* u) {
    const double x = grid.fraction(0, i);
    u[0] = std::exp(-x * x / 0.01);
    u[1] = std::cos(0.5 * std::numbers::pi * x);
  }
};

inline constexpr std::array<Parameter<Angiogenesis>, 5> Angiogenesis::parameters{{{"mu", &Angiogenesis::mu},
                                                                                  {"c_star", &Angiogenesis::c_star},
                                                                                  {"beta", &Angiogenesis::beta},
                                                                                  {"lambda", &Angiogenesis::lambda},
                                                                                  {"alpha", &Angiogenesis::alpha}}};
inline constexpr std::array<Profile<Angiogenesis>, 1> Angiogenesis::profiles{
    {{"angiogenesis-invasion", "rho = exp(-100 x^2), c = cos(pi x/2), with x across the domain", &Angiogenesis::invasion}}};

}  // namespace stiffront
