// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>

#include "stiffront/core/simd.hpp"
#include "stiffront/space/laplacian.hpp"

namespace stiffront {

/// Centred second difference of order eight from memory, without the factor 1/dx^2; mirror images give the same bits and a constant gives zero.
inline Pack second_difference_of_order_8(const double* u, std::ptrdiff_t step, Pack centre) {
  const auto pair = [&](std::ptrdiff_t k) {
    return neg_mul_add(Pack(2.0), centre, Pack::load(u - k * step) + Pack::load(u + k * step));
  };
  Pack sum = pair(4) * Pack(-1.0 / 560.0);
  sum = mul_add(Pack(8.0 / 315.0), pair(3), sum);
  sum = mul_add(Pack(-0.2), pair(2), sum);
  return mul_add(Pack(1.6), pair(1), sum);
}

}  // namespace stiffront
