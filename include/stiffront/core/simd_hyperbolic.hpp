// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "stiffront/core/simd_exp_log.hpp"

/// Hyperbolic functions of packs, through exponentials.
namespace stiffront {

/// Error below 2.5 ulp.
inline Pack sinh(Pack x) {
  const Pack a = abs(x);
  const Pack e = expm1(a);
  const Pack near = Pack(0.5) * (e + e / (e + Pack(1.0)));
  const Pack far = detail::exp_times_power_of_two(a, -1);  // exp(-a) is below half an ulp of exp(a), and exp(a) may overflow
  return detail::copy_sign(select(a < Pack(20.0), near, far), x);
}
/// Error below 2 ulp.
inline Pack cosh(Pack x) {
  const Pack half = detail::exp_times_power_of_two(abs(x), -1);
  return half + Pack(0.25) / half;
}
/// Error below 3 ulp.
inline Pack tanh(Pack x) {
  const Pack a = abs(x);
  const Pack e = expm1(Pack(2.0) * select(a > Pack(22.0), Pack(22.0), a));
  return detail::copy_sign(e / (e + Pack(2.0)), x);
}

}  // namespace stiffront
