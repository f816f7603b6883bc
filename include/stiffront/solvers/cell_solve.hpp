// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "stiffront/core/simd.hpp"

namespace stiffront {

/// LU decomposition of one m x m matrix per lane, with partial pivoting in each lane by itself.
///
/// Rows are exchanged by selection, so the operations of a lane do not depend on its neighbours; as long as no lane exchanges
/// anything, the usual case, the exchanges are skipped, which changes no bits. T is double or Pack.
template <class T, int m>
class CellLu {
 public:
  using Mask = typename ScalarTraits<T>::MaskType;

  /// The matrix on entry of factor().
  T& operator()(int i, int j) { return a_[i][j]; }

  /// Replaces the matrix by its factors. A singular matrix gives factors that are not finite.
  void factor() {
    exchanged_ = false;
    for (int k = 0; k < m; ++k) {
      for (int i = k + 1; i < m; ++i) {
        const Mask larger = abs(a_[i][k]) > abs(a_[k][k]);
        exchange_[k][i] = larger;
        if (any(larger)) {
          exchanged_ = true;
          for (int j = k; j < m; ++j) swap_where(larger, a_[k][j], a_[i][j]);
        }
      }
      inverse_pivot_[k] = T(1.0) / a_[k][k];
      for (int i = k + 1; i < m; ++i) {
        a_[i][k] = a_[i][k] * inverse_pivot_[k];
        for (int j = k + 1; j < m; ++j) a_[i][j] = neg_mul_add(a_[i][k], a_[k][j], a_[i][j]);
      }
    }
  }

  /// Replaces b by the solution.
  void solve(T* b) const {
    for (int k = 0; k < m; ++k) {
      if (exchanged_) {
        for (int i = k + 1; i < m; ++i) swap_where(exchange_[k][i], b[k], b[i]);
      }
      for (int i = k + 1; i < m; ++i) b[i] = neg_mul_add(a_[i][k], b[k], b[i]);
    }
    for (int k = m - 1; k >= 0; --k) {
      b[k] = b[k] * inverse_pivot_[k];
      for (int i = 0; i < k; ++i) b[i] = neg_mul_add(a_[i][k], b[k], b[i]);
    }
  }

  static void swap_where(Mask where, T& x, T& y) {
    const T old = x;
    x = select(where, y, old);
    y = select(where, old, y);
  }

 private:
  T a_[m][m];
  T inverse_pivot_[m];
  Mask exchange_[m][m];
  bool exchanged_;
};

/// The same for complex matrices, real and imaginary parts apart; pivots are compared by |re| + |im|.
template <class T, int m>
class ComplexCellLu {
 public:
  using Mask = typename ScalarTraits<T>::MaskType;

  T& re(int i, int j) { return re_[i][j]; }
  T& im(int i, int j) { return im_[i][j]; }

  void factor() {
    exchanged_ = false;
    for (int k = 0; k < m; ++k) {
      for (int i = k + 1; i < m; ++i) {
        const Mask larger = abs(re_[i][k]) + abs(im_[i][k]) > abs(re_[k][k]) + abs(im_[k][k]);
        exchange_[k][i] = larger;
        if (any(larger)) {
          exchanged_ = true;
          for (int j = k; j < m; ++j) {
            CellLu<T, m>::swap_where(larger, re_[k][j], re_[i][j]);
            CellLu<T, m>::swap_where(larger, im_[k][j], im_[i][j]);
          }
        }
      }
      const T scale = T(1.0) / mul_add(re_[k][k], re_[k][k], im_[k][k] * im_[k][k]);
      inverse_re_[k] = re_[k][k] * scale;
      inverse_im_[k] = -(im_[k][k] * scale);
      for (int i = k + 1; i < m; ++i) {
        multiply(re_[i][k], im_[i][k], inverse_re_[k], inverse_im_[k]);
        for (int j = k + 1; j < m; ++j) subtract_product(re_[i][j], im_[i][j], re_[i][k], im_[i][k], re_[k][j], im_[k][j]);
      }
    }
  }

  void solve(T* b_re, T* b_im) const {
    for (int k = 0; k < m; ++k) {
      if (exchanged_) {
        for (int i = k + 1; i < m; ++i) {
          CellLu<T, m>::swap_where(exchange_[k][i], b_re[k], b_re[i]);
          CellLu<T, m>::swap_where(exchange_[k][i], b_im[k], b_im[i]);
        }
      }
      for (int i = k + 1; i < m; ++i) subtract_product(b_re[i], b_im[i], re_[i][k], im_[i][k], b_re[k], b_im[k]);
    }
    for (int k = m - 1; k >= 0; --k) {
      multiply(b_re[k], b_im[k], inverse_re_[k], inverse_im_[k]);
      for (int i = 0; i < k; ++i) subtract_product(b_re[i], b_im[i], re_[i][k], im_[i][k], b_re[k], b_im[k]);
    }
  }

 private:
  static void multiply(T& x_re, T& x_im, T y_re, T y_im) {
    const T re = neg_mul_add(x_im, y_im, x_re * y_re);
    x_im = mul_add(x_re, y_im, x_im * y_re);
    x_re = re;
  }
  static void subtract_product(T& x_re, T& x_im, T y_re, T y_im, T z_re, T z_im) {
    x_re = mul_add(y_im, z_im, neg_mul_add(y_re, z_re, x_re));
    x_im = neg_mul_add(y_im, z_re, neg_mul_add(y_re, z_im, x_im));
  }

  T re_[m][m];
  T im_[m][m];
  T inverse_re_[m];
  T inverse_im_[m];
  Mask exchange_[m][m];
  bool exchanged_;
};

}  // namespace stiffront
