// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <utility>

/// For functions whose arguments steer code through values that are constants after inlining (core/sparse_dual.hpp).
#define STIFFRONT_ALWAYS_INLINE [[gnu::always_inline]] inline

namespace stiffront {

/// Calls f(integral_constant 0) ... f(integral_constant n-1): a loop that is unrolled before anything else is
/// optimised.
template <int n, class F>
STIFFRONT_ALWAYS_INLINE void unroll(F&& f) {
  [&]<int... i>(std::integer_sequence<int, i...>) __attribute__((always_inline)) { (f(std::integral_constant<int, i>{}), ...); }
  (std::make_integer_sequence<int, n>{});
}

}  // namespace stiffront
