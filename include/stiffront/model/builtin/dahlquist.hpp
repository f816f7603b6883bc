// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <numbers>

#include "stiffront/model/model.hpp"

namespace stiffront {

/// Dahlquist's equation u' = (alpha + i beta) u in every cell, u = re + i im: it decays and turns. An IMEX splitting takes the decay
/// implicitly.
/// @see Hagstrom & Zhou 2006, eqs. (4-1)-(4-3)
struct Dahlquist {
  static constexpr int n_species = 2;
  static constexpr const char* name = "dahlquist";
  static constexpr const char* source = "Dahlquist's test equation; Hagstrom & Zhou 2006, eq. (4-1)";
  static constexpr std::array<const char*, 2> species{"re", "im"};
  static constexpr std::array<double, 2> diffusion{0.0, 0.0};
  static const std::array<Parameter<Dahlquist>, 2> parameters;
  static const std::array<Profile<Dahlquist>, 1> profiles;

  double alpha = -0.05;
  double beta = -2.0 * std::numbers::pi;

  template <class T, class P>
  void rates(const T* u, T* du, const P&) const {
    du[0] = alpha * u[0] - beta * u[1];
    du[1] = alpha * u[1] + beta * u[0];
  }
  template <class T, class P>
  void stiff_rates(const T* u, T* du, const P&) const {
    du[0] = alpha * u[0];
    du[1] = alpha * u[1];
  }

  static void one(const Dahlquist&, const Grid&, std::int64_t, std::int64_t, double* u) {
    u[0] = 1.0;
    u[1] = 0.0;
  }
};

inline constexpr std::array<Parameter<Dahlquist>, 2> Dahlquist::parameters{{{"alpha", &Dahlquist::alpha}, {"beta", &Dahlquist::beta}}};
inline constexpr std::array<Profile<Dahlquist>, 1> Dahlquist::profiles{{{"dahlquist-uniform", "u = 1", &Dahlquist::one}}};

}  // namespace stiffront
