// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "stiffront/model/expression_program.hpp"

namespace stiffront {

/// What an instruction computes from its registers a, b, c and its constants k, l. Every operation is rounded by itself; fused(...)
/// marks the one rounding of a multiply_add.
enum class ExpressionProgram::Code : std::uint16_t {
  constant,  // k
  add,
  add_k,  // a + b, a + k
  subtract,
  k_minus,  // a - b, k - a
  multiply,
  scale,  // a*b, k*a
  divide,
  k_over,  // a/b, k/a
  negate,  // -a

  fma,
  fma_k,
  fma_to_k,
  fma_k_to_l,  // fused(a*b + c), fused(k*a + c), fused(a*b + k), fused(k*a + l)
  fms,
  fms_k,  // fused(a*b - c), fused(k*a - c)
  fnma,
  fnma_to_k,  // fused(c - a*b), fused(k - a*b)

  add_add,
  add_subtract,
  subtract_add,
  subtract_subtract,  // (a + b) + c, (a + b) - c, (a - b) + c, (a - b) - c
  minus_sum,
  minus_difference,  // c - (a + b), c - (a - b)
  k_minus_add,
  k_minus_subtract,  // (k - a) + b, (k - a) - b

  scale_sum,
  scale_difference,
  scale_k_minus,
  scale_k_plus,  // k*(a + b), k*(a - b), k*(l - a), k*(l + a)
  scale_product,
  scale_fma,  // k*(a*b), k*fused(a*b + c)
  multiply_sum,
  multiply_difference,
  multiply_k_minus,
  multiply_k_plus,    // (a + b)*c, (a - b)*c, (k - a)*b, (k + a)*b
  multiply_multiply,  // (a*b)*c
  over_k_plus,
  k_over_l_plus,  // a/(b + k), k/(a + l)

  power,
  minimum,
  maximum,
  absolute,
  square_root,
  exponential,
  logarithm,
  logarithm10,
  sine,
  cosine,
  tangent,
  arc_sine,
  arc_cosine,
  arc_tangent,
  hyperbolic_sine,
  hyperbolic_cosine,
  hyperbolic_tangent,

  less,
  less_equal,
  equal,
  not_equal,  // 1 or 0
  select,     // a != 0 ? b : c
  select_if_less,
  select_if_less_equal,
  select_if_equal,
  select_if_not_equal,  // compare a with b: c or register k
};

}  // namespace stiffront
