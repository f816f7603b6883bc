// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cmath>
#include <numbers>

#include "stiffront/model/model.hpp"

namespace stiffront {

/// Tumour angiogenesis: the density rho of capillary tips, drawn along the gradient of a growth factor c that they consume,
///
///     rho_t = D_rho rho_xx - chi (rho c_x)_x + mu rho (1 - rho) K(c) - beta rho
///     c_t   = D_c c_xx - lambda c - alpha rho c / (1 + c)
///
/// where K(c) = (100 (c - c_star) + log cosh(100 (c - c_star))) / 200 is a smooth form of max(0, c - c_star). In one dimension; by a
/// coupled method.
/// @see Hagstrom & Zhou 2006, eqs. (6-8)-(6-11); Hundsdorfer & Verwer, Time-Dependent Advection-Diffusion-Reaction Equations, 2003.
struct AngiogenesisChemotaxis {
  static constexpr int n_species = 2;
  static constexpr const char* name = "angiogenesis-chemotaxis";
  static constexpr const char* source = "tumour angiogenesis with chemotaxis; Hagstrom & Zhou 2006, section 6.2";
  static constexpr std::array<const char*, 2> species{"rho", "c"};
  static constexpr std::array<double, 2> diffusion{1e-3, 1.0};
  static const std::array<Parameter<AngiogenesisChemotaxis>, 6> parameters;
  static const std::array<Profile<AngiogenesisChemotaxis>, 1> profiles;

  double chi = 0.75;
  double mu = 100.0;
  double c_star = 0.2;
  double beta = 4.0;
  double lambda = 1.0;
  double alpha = 10.0;

  template <class T, class P>
  void rates(const T* u, T* du, const P&) const {
    const T& rho = u[0];
    const T& c = u[1];
    // z + log cosh z = log(1 + exp(2 z)) - log 2 for z = 100 (c - c_star)
    const T growth = (log(1.0 + exp(200.0 * (c - c_star))) - std::numbers::ln2) * 0.005;
    du[0] = mu * rho * (1.0 - rho) * growth - beta * rho;
    du[1] = -lambda * c - alpha * rho * c / (1.0 + c);
  }

  template <class T, class P>
  void transport(const T* u, const T* u_x, const T* u_xx, T* du, const P&) const {
    du[0] = -chi * (u_x[0] * u_x[1] + u[0] * u_xx[1]);
    du[1] = T(0.0);
  }

  /// x = 0 is the tumour, x = 1 the vessel the tips come from.
  static void start(const AngiogenesisChemotaxis&, const Grid& grid, std::int64_t i, std::int64_t, double* u) {
    const double x = grid.fraction(0, i);
    u[0] = std::exp(-288.0 * (x - 1.0) * (x - 13.0 / 12.0));
    u[1] = std::cos(0.5 * std::numbers::pi * x);
  }
};

inline constexpr std::array<Parameter<AngiogenesisChemotaxis>, 6> AngiogenesisChemotaxis::parameters{
    {{"chi", &AngiogenesisChemotaxis::chi},
     {"mu", &AngiogenesisChemotaxis::mu},
     {"c_star", &AngiogenesisChemotaxis::c_star},
     {"beta", &AngiogenesisChemotaxis::beta},
     {"lambda", &AngiogenesisChemotaxis::lambda},
     {"alpha", &AngiogenesisChemotaxis::alpha}}};
inline constexpr std::array<Profile<AngiogenesisChemotaxis>, 1> AngiogenesisChemotaxis::profiles{
    {{"chemotaxis-start", "rho = exp(-288 (x - 1)(x - 13/12)), c = cos(pi x/2), with x across the domain (Hagstrom & Zhou)",
      &AngiogenesisChemotaxis::start}}};

}  // namespace stiffront
