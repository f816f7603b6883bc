// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <span>
#include <vector>

namespace stiffront {

/// One step of IMEX backward differentiation from past times s_1 > s_2 > ... > s_k to t, in the form the linearly implicit start uses.
///
/// With derivative weights d_0 v(t) + sum d_i v(s_i) and extrapolation weights e_i, F = F_I + F_E and F_I = -P v, the step
/// d_0 v + sum d_i v_i = F_I(v) + sum e_i F_E(v_i) is, for v* = sum e_i v_i,
///
///     (1 + h P) (v - v*) = sum a_i v_i + h sum e_i F(v_i),    h = 1/d_0,   a_i = -d_i/d_0 - e_i.
///
/// @see Ascher, Ruuth & Wetton, SIAM J. Numer. Anal. 32(3), 1995; Hagstrom & Zhou 2006, eq. (2-4)
struct StartingWeights {
  double h = 0.0;
  std::vector<double> extrapolation;  ///< e_i
  std::vector<double> states;         ///< a_i
};

/// @param past times before t, the nearest first, at least one
StartingWeights starting_weights(double t, std::span<const double> past);

}  // namespace stiffront
