// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>

#include "stiffront/core/simd.hpp"
#include "stiffront/space/laplacian.hpp"

namespace stiffront {

/// Centred second difference of order eight from memory, without the factor 1/dx^2; mirror images give the same bits and a constant gives zero.
inline Pack second_difference_of_order_8(const double* u, std::ptrdiff_t step, Pack centre) {
  const auto pair = [&](std::ptrdiff_t k) { return neg_mul_add(Pack(2.0), centre, Pack::load(u - k * step) + Pack::load(u + k * step)); };
  Pack sum = pair(4) * Pack(-1.0 / 560.0);
  sum = mul_add(Pack(8.0 / 315.0), pair(3), sum);
  sum = mul_add(Pack(-0.2), pair(2), sum);
  return mul_add(Pack(1.6), pair(1), sum);
}

/// Centred first difference along x from memory, without the factor 1/dx; mirror images give opposite bits.
template <int Order>
Pack first_difference(const double* u) {
  static_assert(Order == 2 || Order == 4 || Order == 8);
  const auto pair = [&](int k) { return Pack::load(u + k) - Pack::load(u - k); };
  if constexpr (Order == 2) {
    return pair(1) * Pack(0.5);
  } else if constexpr (Order == 4) {
    return mul_add(Pack(2.0 / 3.0), pair(1), pair(2) * Pack(-1.0 / 12.0));
  } else {
    Pack sum = pair(4) * Pack(-1.0 / 280.0);
    sum = mul_add(Pack(4.0 / 105.0), pair(3), sum);
    sum = mul_add(Pack(-0.2), pair(2), sum);
    return mul_add(Pack(0.8), pair(1), sum);
  }
}

}  // namespace stiffront
