// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cmath>
#include <numbers>

#include "stiffront/model/model.hpp"

namespace stiffront {

/// Brusselator: du/dt = A + u^2 v - (B + 1) u, dv/dt = B u - u^2 v. Steady state u = A, v = B/A, a limit cycle for B > 1 + A^2.
///
/// @see Prigogine & Lefever, J. Chem. Phys. 48, 1968, pp. 1695-1700; as a test problem Hagstrom & Zhou 2006, section 6.1;
///      Hairer & Wanner, Solving Ordinary Differential Equations II, section IV.10; Abdulle 2002.
struct Brusselator {
  static constexpr int n_species = 2;
  static constexpr const char* name = "brusselator";
  static constexpr const char* source = "Brusselator; Prigogine & Lefever 1968; Hagstrom & Zhou 2006, section 6.1";
  static constexpr std::array<const char*, 2> species{"u", "v"};
  static constexpr std::array<double, 2> diffusion{2e-3, 2e-3};
  static const std::array<Parameter<Brusselator>, 2> parameters;
  static const std::array<Profile<Brusselator>, 4> profiles;

  double A = 1.0;
  double B = 3.0;

  template <class T, class P>
  void rates(const T* u, T* du, const P&) const {
    const T uuv = u[0] * u[0] * u[1];
    du[0] = A + uuv - (B + 1.0) * u[0];
    du[1] = B * u[0] - uuv;
  }

  /// u = 1 + sin(2 waves pi x), v = 3, with x across the domain.
  template <int Waves>
  static void sine(const Brusselator&, const Grid& grid, std::int64_t i, std::int64_t, double* u) {
    u[0] = 1.0 + std::sin(2.0 * Waves * std::numbers::pi * grid.fraction(0, i));
    u[1] = 3.0;
  }

  static void cosine(const Brusselator&, const Grid& grid, std::int64_t i, std::int64_t, double* u) {
    const double x = grid.fraction(0, i);
    u[0] = 1.0 + 0.5 * std::cos(std::numbers::pi * x);
    u[1] = 3.0 + 0.5 * std::cos(2.0 * std::numbers::pi * x);
  }

  /// u = 22 y (1 - y)^(3/2), v = 27 x (1 - x)^(3/2), with x and y across the domain.
  static void rock4(const Brusselator&, const Grid& grid, std::int64_t i, std::int64_t j, double* u) {
    const auto hump = [](double s) { return s * (1.0 - s) * std::sqrt(1.0 - s); };
    u[0] = 22.0 * hump(grid.fraction(1, j));
    u[1] = 27.0 * hump(grid.fraction(0, i));
  }
};

inline constexpr std::array<Parameter<Brusselator>, 2> Brusselator::parameters{{{"A", &Brusselator::A}, {"B", &Brusselator::B}}};
inline constexpr std::array<Profile<Brusselator>, 4> Brusselator::profiles{
    {{"brusselator-sine", "u = 1 + sin(2 pi x), v = 3", &Brusselator::sine<1>},
     {"brusselator-ten-waves", "u = 1 + sin(20 pi x), v = 3 (Hagstrom & Zhou)", &Brusselator::sine<10>},
     {"brusselator-cosine", "u = 1 + cos(pi x)/2, v = 3 + cos(2 pi x)/2", &Brusselator::cosine},
     {"brusselator-rock4", "u = 22 y (1-y)^1.5, v = 27 x (1-x)^1.5 (2-D, periodic in Hairer & Wanner and Abdulle)", &Brusselator::rock4,
      2}}};

}  // namespace stiffront
