// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cmath>

#include "stiffront/model/model.hpp"

namespace stiffront {

/// Lambda-omega system, an oscillator whose frequency depends on its amplitude: with r = u^2 + v^2,
///
///     du/dt = (1 - r) u - omega (1 + shear r) v,  dv/dt = (1 - r) v + omega (1 + shear r) u
///
/// @see Kopell & Howard, Stud. Appl. Math. 52, 1973, pp. 291-328.
struct LambdaOmega {
  static constexpr int n_species = 2;
  static constexpr const char* name = "lambda-omega";
  static constexpr const char* source = "lambda-omega oscillator; Kopell & Howard 1973";
  static constexpr std::array<const char*, 2> species{"u", "v"};
  static constexpr std::array<double, 2> diffusion{0.01, 0.01};
  static const std::array<Parameter<LambdaOmega>, 2> parameters;
  static const std::array<Profile<LambdaOmega>, 1> profiles;

  double omega = 20.0;
  double shear = 0.1;

  template <class T, class P>
  void rates(const T* u, T* du, const P&) const {
    const T r = u[0] * u[0] + u[1] * u[1];
    const T growth = 1.0 - r;
    const T turn = omega * (1.0 + shear * r);
    du[0] = growth * u[0] - turn * u[1];
    du[1] = growth * u[1] + turn * u[0];
  }

  static void defect(const LambdaOmega&, const Grid& grid, std::int64_t i, std::int64_t, double* u) {
    u[0] = std::tanh((grid.fraction(0, i) - 0.5) * (grid.upper[0] - grid.lower[0]));
    u[1] = 0.1;
  }
};

inline constexpr std::array<Parameter<LambdaOmega>, 2> LambdaOmega::parameters{
    {{"omega", &LambdaOmega::omega}, {"shear", &LambdaOmega::shear}}};
inline constexpr std::array<Profile<LambdaOmega>, 1> LambdaOmega::profiles{
    {{"lambda-omega-defect", "u = tanh(x - middle), v = 0.1", &LambdaOmega::defect}}};

}  // namespace stiffront
