// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "stiffront/model/model.hpp"

namespace stiffront {

/// Van der Pol's oscillator in every cell, u1' = u2, u2' = -u1 + mu (1 - u1^2) u2. For mu = 1 it is not stiff, and an IMEX splitting
/// takes nothing implicitly.
/// @see Hagstrom & Zhou 2006, eqs. (4-4), (4-5)
struct VanDerPol {
  static constexpr int n_species = 2;
  static constexpr const char* name = "van-der-pol";
  static constexpr const char* source = "van der Pol's oscillator; Hagstrom & Zhou 2006, eq. (4-4)";
  static constexpr std::array<const char*, 2> species{"u1", "u2"};
  static constexpr std::array<double, 2> diffusion{0.0, 0.0};
  static const std::array<Parameter<VanDerPol>, 1> parameters;
  static const std::array<Profile<VanDerPol>, 1> profiles;

  double mu = 1.0;

  template <class T, class P>
  void rates(const T* u, T* du, const P&) const {
    du[0] = u[1];
    du[1] = mu * (1.0 - u[0] * u[0]) * u[1] - u[0];
  }
  template <class T, class P>
  void stiff_rates(const T*, T* du, const P&) const {
    du[0] = T(0.0);
    du[1] = T(0.0);
  }

  static void start(const VanDerPol&, const Grid&, std::int64_t, std::int64_t, double* u) {
    u[0] = 2.0;
    u[1] = 2.0 / 3.0;
  }
};

inline constexpr std::array<Parameter<VanDerPol>, 1> VanDerPol::parameters{{{"mu", &VanDerPol::mu}}};
inline constexpr std::array<Profile<VanDerPol>, 1> VanDerPol::profiles{{{"van-der-pol-uniform", "u1 = 2, u2 = 2/3", &VanDerPol::start}}};

}  // namespace stiffront
