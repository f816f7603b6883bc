// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cmath>
#include <numbers>

#include "stiffront/model/model.hpp"

namespace stiffront {

/// Belousov-Zhabotinsky reaction, three variables: a (bromide), b (bromous acid), c (cerium(IV)).
///
///     da/dt = (-q a - a b + f c) / mu,  db/dt = (q a - a b + b (1 - b)) / epsilon,  dc/dt = b - c
///
/// @see Descombes et al. 2011, eq. (5.11); Duarte & Emmett 2016, eq. (49). Both papers exchange the names of a and c.
struct Bz {
  static constexpr int n_species = 3;
  static constexpr const char* name = "bz";
  static constexpr const char* source =
      "Belousov-Zhabotinsky, 3 variables; Duarte & Emmett 2016, section 7; Descombes et al. 2011, section 5.2";
  static constexpr std::array<const char*, 3> species{"a", "b", "c"};
  static constexpr std::array<double, 3> diffusion{2.5e-3, 2.5e-3, 1.5e-3};
  static const std::array<Parameter<Bz>, 4> parameters;
  static const std::array<Profile<Bz>, 3> profiles;

  double epsilon = 1e-2;
  double mu = 1e-5;
  double f = 1.6;
  double q = 2e-3;

  template <class T, class P>
  void rates(const T* u, T* du, const P&) const {
    const T ab = u[0] * u[1];
    du[0] = (f * u[2] - q * u[0] - ab) * (1.0 / mu);
    du[1] = (q * u[0] - ab + u[1] * (1.0 - u[1])) * (1.0 / epsilon);
    du[2] = u[1] - u[2];
  }

  double rest() const { return q * (f + 1.0) / (f - 1.0); }

  /// Ignited strip at the lower x side in a medium at a = b = c = 0 (the initial state of section 7 of Duarte & Emmett is not
  /// given there; this one makes a self-similar wave of speed 1 as described). The strip 0 <= 20 x - 0.05 <= 0.15 of the unit
  /// interval is stated by index: N/400 <= i < N/100 of N intervals. The point at exactly N/100 is outside, as it is where the rule is
  /// evaluated in double precision (20 * 0.01 - 0.05 > 0.15): one point more changes the wave by 6e-4.
  static void front(const Bz& m, const Grid& grid, std::int64_t i, std::int64_t, double* u) {
    const std::int64_t n = grid.points[0] - 1;
    const double position = static_cast<double>(i) / static_cast<double>(n);
    const double y = 20.0 * position - 0.05;
    u[1] = u[2] = 0.0;
    if (20 * i < n) {
      const bool ignited = 400 * i >= n && 100 * i < n;
      const double theta = std::atan(y / 0.5) + (400 * i < n ? 2.0 * std::numbers::pi : 0.0);
      u[1] = ignited ? 0.8 : m.rest();
      u[2] = m.rest() + theta / (8.0 * std::numbers::pi * m.f);
    }
    u[0] = m.f * u[2] / (m.q + u[1]);
  }

  /// The medium at rest, b = 0.8 on the middle 40th of the domain: two outgoing waves.
  static void ignition(const Bz& m, const Grid& grid, std::int64_t i, std::int64_t, double* u) {
    const std::int64_t n = grid.points[0] - 1;
    const std::int64_t from_middle = 2 * i > n ? 2 * i - n : n - 2 * i;
    u[1] = 40 * from_middle <= n ? 0.8 : m.rest();
    u[2] = m.rest();
    u[0] = m.f * u[2] / (m.q + u[1]);
  }

  /// A wedge of angle 0.5 ignited, recovering with the angle around the centre: a spiral. Angles are compared after exact integer
  /// coordinates have been formed; no grid point lies on the wedge's edge except the ray of angle 0.
  static void spiral(const Bz& m, const Grid& grid, std::int64_t i, std::int64_t j, double* u) {
    const double x = static_cast<double>(2 * i - (grid.points[0] - 1)) / static_cast<double>(2 * (grid.points[0] - 1));
    const double y = static_cast<double>(2 * j - (grid.points[1] - 1)) / static_cast<double>(2 * (grid.points[1] - 1));
    double theta = std::atan2(y, x);
    if (theta < 0.0) theta += 2.0 * std::numbers::pi;
    u[1] = theta < 0.5 ? 0.8 : m.rest();
    u[2] = m.rest() + theta / (8.0 * std::numbers::pi * m.f);
    u[0] = m.f * u[2] / (m.q + u[1]);
  }
};

inline constexpr std::array<Parameter<Bz>, 4> Bz::parameters{{{"epsilon", &Bz::epsilon}, {"mu", &Bz::mu}, {"f", &Bz::f}, {"q", &Bz::q}}};
inline constexpr std::array<Profile<Bz>, 3> Bz::profiles{
    {{"bz-front", "ignited strip near the lower x side, a = b = c = 0 elsewhere", &Bz::front},
     {"bz-ignition", "medium at rest, middle 40th ignited", &Bz::ignition},
     {"bz-spiral", "ignited wedge around the centre (2-D)", &Bz::spiral, 2}}};

}  // namespace stiffront
