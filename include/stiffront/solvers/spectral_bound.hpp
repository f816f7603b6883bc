// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cmath>

#include "stiffront/core/simd.hpp"

namespace stiffront {

/// An upper bound of the moduli of the eigenvalues of small matrices, one per lane: ||A^n||^(1/n) with n = 2^squarings (Gelfand), the
/// norm being the smaller of the largest row and column sum.
///
/// The norm itself is useless for kinetics: a fast species that depends strongly on a slow one makes it many times the fastest rate.
/// Five squarings bring an excess of a factor f down to f^(1/32). NaN or infinity if an entry is not finite.
template <int m>
Pack spectral_bound(const Pack (&matrix)[m][m], int squarings = 5) {
  const auto norm = [](const Pack(&a)[m][m]) {
    Pack row(0.0), column(0.0), sum(0.0);
    for (int i = 0; i < m; ++i) {
      Pack along_row(0.0), along_column(0.0);
      for (int j = 0; j < m; ++j) {
        along_row += abs(a[i][j]);
        along_column += abs(a[j][i]);
      }
      row = max(row, along_row);
      column = max(column, along_column);
      sum += along_row;
    }
    // A maximum forgets a NaN it has met: the sum of all moduli does not.
    return min(row, column) + (sum - sum);
  };
  constexpr int most = 8;
  Pack scale[most + 1];
  Pack a[m][m];
  scale[0] = norm(matrix);
  const auto normalise = [&](const Pack(&from)[m][m], Pack by) {
    const Pack inverse = select(by > Pack(0.0), Pack(1.0) / select(by > Pack(0.0), by, Pack(1.0)), Pack(0.0));
    for (int i = 0; i < m; ++i) {
      for (int j = 0; j < m; ++j) a[i][j] = from[i][j] * inverse;
    }
  };
  normalise(matrix, scale[0]);
  for (int k = 1; k <= squarings; ++k) {
    Pack square[m][m];
    for (int i = 0; i < m; ++i) {
      for (int j = 0; j < m; ++j) {
        Pack sum(0.0);
        for (int q = 0; q < m; ++q) sum = mul_add(a[i][q], a[q][j], sum);
        square[i][j] = sum;
      }
    }
    scale[k] = norm(square);
    normalise(square, scale[k]);
  }
  // scale_0 * sqrt(scale_1 * sqrt(scale_2 * ...))
  Pack root = scale[squarings];
  for (int k = squarings; k > 0; --k) root = scale[k - 1] * sqrt(root);
  return root;
}

}  // namespace stiffront
