// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "stiffront/core/sparse_dual.hpp"

namespace stiffront {

/// Solves a x = b for one m x m system per lane, once, in registers; a and b are destroyed, b becomes x.
///
/// Entries known to be zero cost nothing. Elimination without exchange of rows, the last two unknowns by Cramer's rule,
/// so that the divisions are m-1: meant for I - gamma J + shifts in a correction step whose result is checked by an
/// error test. A small pivot costs digits of the correction there, a zero one makes it infinite; both show in the test.
template <class T, int m>
STIFFRONT_ALWAYS_INLINE void sparse_cell_solve(Sparse<T> (&a)[m][m], Sparse<T> (&b)[m]) {
  if constexpr (m == 1) {
    b[0] = b[0].value / a[0][0].value;
  } else {
    Sparse<T> inverse[m];
    unroll<m - 2>([&](auto k_) __attribute__((always_inline)) {
      constexpr int k = k_;
      inverse[k] = T(1.0) / a[k][k].value;
      unroll<m - 1 - k>([&](auto i_) __attribute__((always_inline)) {
        constexpr int i = k + 1 + i_;
        if (a[i][k].is_zero()) return;
        const Sparse<T> factor = a[i][k] * inverse[k];
        unroll<m - 1 - k>([&](auto j_) __attribute__((always_inline)) {
          constexpr int j = k + 1 + j_;
          a[i][j] = neg_mul_add(factor, a[k][j], a[i][j]);
        });
        b[i] = neg_mul_add(factor, b[k], b[i]);
      });
    });
    constexpr int p = m - 2;
    constexpr int q = m - 1;
    const Sparse<T> determinant = neg_mul_add(a[p][q], a[q][p], a[p][p] * a[q][q]);
    const Sparse<T> scale = T(1.0) / determinant.value;
    const Sparse<T> x_p = neg_mul_add(a[p][q], b[q], b[p] * a[q][q]) * scale;
    b[q] = neg_mul_add(a[q][p], b[p], b[q] * a[p][p]) * scale;
    b[p] = x_p;
    unroll<m - 2>([&](auto k_) __attribute__((always_inline)) {
      constexpr int k = m - 3 - k_;
      unroll<m - 1 - k>([&](auto j_) __attribute__((always_inline)) {
        constexpr int j = k + 1 + j_;
        b[k] = neg_mul_add(a[k][j], b[j], b[k]);
      });
      b[k] = b[k] * inverse[k];
    });
  }
}

}  // namespace stiffront
