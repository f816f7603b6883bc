// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "stiffront/core/simd.hpp"

/// One m x m system per lane, real or complex, solved by LU decomposition with row exchanges in each lane by itself. T is double
/// or Pack.
///
/// There are two kinds. Those with exchanges put the largest candidate in the place of the pivot where it is more than eight times
/// the one that is there; elements then grow by at most 9 per column. Those without are for packs in which no lane exchanges
/// anything, the usual case, and say so if that is not the case: selection, its masks and their calls would cost a third of the time
/// of a Radau5 step with three species. In a lane that exchanges nothing both do the same operations, so its bits do not depend on
/// which kind its neighbours call for.
///
/// A singular matrix gives solutions that are not finite.
namespace stiffront {

namespace cell_solve {

inline constexpr double exchange_threshold = 8.0;

/// x -= y z for complex numbers.
template <class T>
void subtract_product(T& x_re, T& x_im, T y_re, T y_im, T z_re, T z_im) {
  x_re = mul_add(y_im, z_im, neg_mul_add(y_re, z_re, x_re));
  x_im = neg_mul_add(y_im, z_re, neg_mul_add(y_re, z_im, x_im));
}
/// x *= y for complex numbers.
template <class T>
void multiply(T& x_re, T& x_im, T y_re, T y_im) {
  const T re = neg_mul_add(x_im, y_im, x_re * y_re);
  x_im = mul_add(x_re, y_im, x_im * y_re);
  x_re = re;
}

/// The row exchanges of a decomposition; without, a mask of the lanes that would have needed one.
template <class T, int m, bool with>
class Exchanges {
 public:
  using Mask = typename ScalarTraits<T>::MaskType;

  /// Decides about rows k and i from the sizes of their candidates.
  void decide(int k, int i, T size_k, T size_i) {
    const Mask larger = size_i > T(exchange_threshold) * size_k;
    if constexpr (with) {
      where_[k][i] = larger;
    } else {
      needed_ = needed_ || larger;
    }
  }
  void apply(int k, int i, T& x, T& y) const {
    if constexpr (with) {
      const T old = x;
      x = select(where_[k][i], y, old);
      y = select(where_[k][i], old, y);
    }
  }
  bool needed() const { return !with && any(needed_); }

 private:
  Mask needed_{false};
  Mask where_[with ? m : 1][with ? m : 1];
};

}  // namespace cell_solve

/// A real matrix.
template <class T, int m, bool with_exchanges>
class CellLu {
 public:
  T& operator()(int i, int j) { return a_[i][j]; }

  /// Replaces the matrix by its factors. @return false if exchanges would have been needed
  bool factor() {
    for (int k = 0; k < m; ++k) {
      for (int i = k + 1; i < m; ++i) {
        exchanges_.decide(k, i, abs(a_[k][k]), abs(a_[i][k]));
        for (int j = k; j < m; ++j) exchanges_.apply(k, i, a_[k][j], a_[i][j]);
      }
      inverse_pivot_[k] = T(1.0) / a_[k][k];
      for (int i = k + 1; i < m; ++i) {
        a_[i][k] = a_[i][k] * inverse_pivot_[k];
        for (int j = k + 1; j < m; ++j) a_[i][j] = neg_mul_add(a_[i][k], a_[k][j], a_[i][j]);
      }
    }
    return !exchanges_.needed();
  }

  /// Replaces b by the solution.
  void solve(T* b) const {
    for (int k = 0; k < m; ++k) {
      for (int i = k + 1; i < m; ++i) exchanges_.apply(k, i, b[k], b[i]);
      for (int i = k + 1; i < m; ++i) b[i] = neg_mul_add(a_[i][k], b[k], b[i]);
    }
    for (int k = m - 1; k >= 0; --k) {
      b[k] = b[k] * inverse_pivot_[k];
      for (int i = 0; i < k; ++i) b[i] = neg_mul_add(a_[i][k], b[k], b[i]);
    }
  }

 private:
  T a_[m][m];
  T inverse_pivot_[m];
  cell_solve::Exchanges<T, m, with_exchanges> exchanges_;
};

/// A complex matrix, real and imaginary parts apart; candidates are compared by |re| + |im|.
template <class T, int m, bool with_exchanges>
class ComplexCellLu {
 public:
  T& re(int i, int j) { return re_[i][j]; }
  T& im(int i, int j) { return im_[i][j]; }

  /// Replaces the matrix by its factors. @return false if exchanges would have been needed
  bool factor() {
    using namespace cell_solve;
    for (int k = 0; k < m; ++k) {
      for (int i = k + 1; i < m; ++i) {
        exchanges_.decide(k, i, abs(re_[k][k]) + abs(im_[k][k]), abs(re_[i][k]) + abs(im_[i][k]));
        for (int j = k; j < m; ++j) {
          exchanges_.apply(k, i, re_[k][j], re_[i][j]);
          exchanges_.apply(k, i, im_[k][j], im_[i][j]);
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
    return !exchanges_.needed();
  }

  /// Replaces b by the solution.
  void solve(T* b_re, T* b_im) const {
    using namespace cell_solve;
    for (int k = 0; k < m; ++k) {
      for (int i = k + 1; i < m; ++i) {
        exchanges_.apply(k, i, b_re[k], b_re[i]);
        exchanges_.apply(k, i, b_im[k], b_im[i]);
      }
      for (int i = k + 1; i < m; ++i) subtract_product(b_re[i], b_im[i], re_[i][k], im_[i][k], b_re[k], b_im[k]);
    }
    for (int k = m - 1; k >= 0; --k) {
      multiply(b_re[k], b_im[k], inverse_re_[k], inverse_im_[k]);
      for (int i = 0; i < k; ++i) subtract_product(b_re[i], b_im[i], re_[i][k], im_[i][k], b_re[k], b_im[k]);
    }
  }

 private:
  T re_[m][m];
  T im_[m][m];
  T inverse_re_[m];
  T inverse_im_[m];
  cell_solve::Exchanges<T, m, with_exchanges> exchanges_;
};

}  // namespace stiffront
