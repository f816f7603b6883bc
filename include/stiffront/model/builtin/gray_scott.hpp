// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cmath>

#include "stiffront/model/model.hpp"

namespace stiffront {

/// Gray-Scott reaction in a fed reactor: du/dt = F (1 - u) - u v^2, dv/dt = u v^2 - (F + k) v.
///
/// @see Gray & Scott, Chem. Eng. Sci. 39, 1984, pp. 1087-1097; Pearson, Science 261, 1993, pp. 189-192.
struct GrayScott {
  static constexpr int n_species = 2;
  static constexpr const char* name = "gray-scott";
  static constexpr const char* source = "Gray-Scott; Pearson, Science 261, 1993";
  static constexpr std::array<const char*, 2> species{"u", "v"};
  static constexpr std::array<double, 2> diffusion{2e-5, 1e-5};
  static const std::array<Parameter<GrayScott>, 2> parameters;
  static const std::array<Profile<GrayScott>, 2> profiles;

  double F = 0.04;
  double k = 0.06;

  template <class T, class P>
  void rates(const T* u, T* du, const P&) const {
    const T uvv = u[0] * u[1] * u[1];
    du[0] = F * (1.0 - u[0]) - uvv;
    du[1] = uvv - (F + k) * u[1];
  }

  /// u = 1/2, v = 1/4 on the middle 5/64 of every direction, 20 points of 256 as in Pearson, and u = 1, v = 0 elsewhere. His noise of
  /// one percent is left out: the state is the same on every machine.
  static void square(const GrayScott&, const Grid& grid, std::int64_t i, std::int64_t j, double* u) {
    const auto in_the_middle = [&](std::int64_t index, int direction) {
      const std::int64_t last = grid.points[static_cast<std::size_t>(direction)] - 1;
      const std::int64_t twice_from_middle = 2 * index > last ? 2 * index - last : last - 2 * index;
      return 64 * twice_from_middle <= 5 * grid.intervals(direction);
    };
    const bool inside = in_the_middle(i, 0) && (grid.dimension == 1 || in_the_middle(j, 1));
    u[0] = inside ? 0.5 : 1.0;
    u[1] = inside ? 0.25 : 0.0;
  }

  /// With b = exp(-(s/3)^2), s the distance in x from the middle: u = 1 - b/2, v = b/4.
  static void pulse(const GrayScott&, const Grid& grid, std::int64_t i, std::int64_t, double* u) {
    const double s = (grid.fraction(0, i) - 0.5) * (grid.upper[0] - grid.lower[0]) / 3.0;
    const double b = std::exp(-s * s);
    u[0] = 1.0 - 0.5 * b;
    u[1] = 0.25 * b;
  }
};

inline constexpr std::array<Parameter<GrayScott>, 2> GrayScott::parameters{{{"F", &GrayScott::F}, {"k", &GrayScott::k}}};
inline constexpr std::array<Profile<GrayScott>, 2> GrayScott::profiles{
    {{"gray-scott-square", "u = 1/2, v = 1/4 in the middle 5/64, u = 1, v = 0 elsewhere", &GrayScott::square},
     {"gray-scott-pulse", "a smooth pulse of half-width 3 in the middle (x from 0 to 100, say)", &GrayScott::pulse}}};

}  // namespace stiffront
