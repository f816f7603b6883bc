// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>

#include "stiffront/mesh/boundary.hpp"
#include "stiffront/solvers/block_tridiagonal.hpp"

namespace stiffront {

/// Gives points outside of the free box the equation x = right side.
template <int m>
void fix_points(BlockTridiagonal<m>& system, const FreeBox& free, int n) {
  const auto fix = [&](int i) {
    for (int s = 0; s < m; ++s) {
      for (int q = 0; q < m; ++q) system.diagonal(s, q)[i] = s == q ? 1.0 : 0.0;
      system.lower(s)[i] = system.upper(s)[i] = 0.0;
    }
  };
  if (free.i_begin > 0) fix(0);
  if (free.i_end < n) fix(n - 1);
}

/// The off-diagonal blocks of a line on which a point of species s is coupled to each of its neighbours by coupling[s]
/// (-gamma D_s / dx^2 for implicit diffusion), mirrored beyond Neumann sides. Points outside of the free box get the
/// equation x = right side.
/// @pre the diagonal blocks are filled
template <int m>
void couple_line(BlockTridiagonal<m>& system, const Decomposition& d, const FreeBox& free, const double (&coupling)[m]) {
  const int n = d.n_x();
  for (int s = 0; s < m; ++s) {
    double* const lower = system.lower(s);
    double* const upper = system.upper(s);
    const double c = coupling[s];
    std::fill_n(lower, n, c);
    std::fill_n(upper, n, c);
    if (d.at_boundary(0, 0)) upper[0] = 2.0 * c, lower[0] = 0.0;
    if (d.at_boundary(0, 1)) lower[n - 1] = 2.0 * c, upper[n - 1] = 0.0;
  }
  fix_points(system, free, n);
}

}  // namespace stiffront
