// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>

#include "stiffront/core/simd.hpp"

namespace stiffront {

/// Centred second difference along one direction from the values at a point and at distance 1 and 2 on either side: sum of c_k u_k
/// without the factor 1/dx^2. Order 2: (1, -2, 1); the outer values are not used. Order 4: (-1, 16, -30, 16, -1)/12.
///
/// Written so that mirror images give the same bits and a constant gives zero: with rounded weights of the points themselves it
/// would drift in every stage in the same direction.
template <int Order>
Pack second_difference(Pack centre, Pack before, Pack after, Pack far_before, Pack far_after) {
  static_assert(Order == 2 || Order == 4);
  const Pack near = neg_mul_add(Pack(2.0), centre, before + after);
  if constexpr (Order == 2) {
    return near;
  } else {
    const Pack far = neg_mul_add(Pack(2.0), centre, far_before + far_after);
    return mul_add(Pack(4.0 / 3.0), near, far * Pack(-1.0 / 12.0));
  }
}

/// The same from memory.
template <int Order>
Pack second_difference(const double* u, std::ptrdiff_t step, Pack centre) {
  if constexpr (Order == 2) {
    return second_difference<2>(centre, Pack::load(u - step), Pack::load(u + step), centre, centre);
  } else {
    return second_difference<4>(centre, Pack::load(u - step), Pack::load(u + step), Pack::load(u - 2 * step), Pack::load(u + 2 * step));
  }
}

/// D Laplacian(u) at the pack of points that starts at u[0].
///
/// Reads whole packs beyond the end of a row: fields are padded for that. The two directions enter symmetrically, so transposed data
/// give transposed bits when the spacings are equal.
template <int Order, int Dimension>
struct Laplacian {
  double k_x;  ///< D / dx^2
  double k_y;  ///< D / dy^2
  std::ptrdiff_t row_stride;

  Pack operator()(const double* u) const { return (*this)(u, Pack::load(u)); }
  Pack operator()(const double* u, Pack centre) const {
    const Pack along_x = Pack(k_x) * second_difference<Order>(u, 1, centre);
    if constexpr (Dimension == 1) {
      return along_x;
    } else {
      return along_x + Pack(k_y) * second_difference<Order>(u, row_stride, centre);
    }
  }
};

/// The diagonal coefficient of -second_difference.
constexpr double second_difference_diagonal(int order) { return order == 2 ? 2.0 : (order == 4 ? 2.5 : 205.0 / 72.0); }
/// The largest eigenvalue of -second_difference, its symbol at the highest wave number (exact for periodic and Neumann grids with
/// an even number of intervals, a bound for all others without sub-cells).
constexpr double second_difference_radius(int order) { return order == 2 ? 4.0 : (order == 4 ? 16.0 / 3.0 : 2048.0 / 315.0); }

/// Calls f(i, n) for the packs of a row: points i .. i + n - 1, n = pack_size except at the end.
template <class F>
void for_each_pack(int i_begin, int i_end, F&& f) {
  int i = i_begin;
  for (; i + pack_size <= i_end; i += pack_size) f(i, pack_size);
  if (i < i_end) f(i, i_end - i);
}

}  // namespace stiffront
