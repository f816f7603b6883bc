// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "stiffront/core/simd_bits.hpp"

/// Exponentials, logarithms and powers of packs.
///
/// Polynomials interpolate at Chebyshev nodes of the reduced interval; their relative error is below 2^-58 of the function.
namespace stiffront {

namespace detail {

inline constexpr double ln2_high = 0x1.62e42fefa3800p-1;  // 42 bits: its product with an exponent is exact
inline constexpr double ln2_low = 0x1.ef35793c76730p-45;
inline constexpr double log2_e = 0x1.71547652b82fep+0;

/// x = n ln 2 + r, |r| <= 0.3466.
struct ExpArgument {
  Bits n;
  Pack r;
};
inline ExpArgument reduce_exp(Pack x) {
  const Integer k = nearest_integer(x, log2_e);
  return {k.i, neg_mul_add(k.value, Pack(ln2_low), neg_mul_add(k.value, Pack(ln2_high), x))};
}
/// exp(r) - 1 for |r| <= 0.3466.
inline Pack exp_minus_one(Pack r) {
  static constexpr double c[] = {0x1.5555555555556p-3,  0x1.5555555555555p-5,  0x1.11111111109a6p-7,  0x1.6c16c16c167dap-10,
                                 0x1.a01a01a7cebcdp-13, 0x1.a01a01a48116fp-16, 0x1.71de0d85293b8p-19, 0x1.27e4e1dcf773bp-22,
                                 0x1.af390ba7e6f47p-26, 0x1.1f6717774d5e0p-29};
  return mul_add(r * r, mul_add(r, polynomial(r, c), Pack(0.5)), r);
}
/// Arguments beyond which exp is 0 or infinite, brought to where the reduction still holds. NaN stays.
inline Pack clamp_exp(Pack x) { return select(x > Pack(711.0), Pack(711.0), select(x < Pack(-746.0), Pack(-746.0), x)); }
/// exp(x) * 2^shift, so that halves of exponentials beyond the range of doubles can be formed.
inline Pack exp_times_power_of_two(Pack x, int shift) {
  const ExpArgument a = reduce_exp(clamp_exp(x));
  return scale(Pack(1.0) + exp_minus_one(a.r), a.n + shift);
}

/// x = 2^k (1 + f) with sqrt(1/2) <= 1 + f < sqrt(2), for positive finite x, subnormals included.
struct LogArgument {
  Pack k;
  Pack f;
};
inline LogArgument reduce_log(Pack x) {
  const Mask subnormal = x < Pack(0x1p-1022);
  const Bits b = to_bits(abs(select(subnormal, x * Pack(0x1p54), x)));  // abs: no overflow below for any argument
  const Bits k = (b - to_bits(Pack(0x1.6a09e667f3bcdp-1))) >> 52;
  return {to_double(k) - select(subnormal, Pack(54.0), Pack(0.0)), from_bits(b - (k << 52)) - Pack(1.0)};
}
/// k ln 2 + log(1 + f) + c with a small correction c.
inline Pack assemble_log(LogArgument a, Pack c) {
  // log(1 + f) = 2 atanh(s), s = f/(2 + f); written as f - f^2/2 + s (f^2/2 + R) the rounding of s hardly matters.
  static constexpr double p[] = {0x1.5555555555555p-1, 0x1.9999999999a38p-2, 0x1.2492492476c87p-2, 0x1.c71c720160b47p-3,
                                 0x1.745cf901605f7p-3, 0x1.3b1c360763b8ap-3, 0x1.0fbe83c2cbcf3p-3, 0x1.0c04595972ab8p-3};
  const Pack s = a.f / (Pack(2.0) + a.f);
  const Pack z = s * s;
  const Pack half_square = Pack(0.5) * a.f * a.f;
  const Pack inner = s * (half_square + z * polynomial(z, p)) + (a.k * Pack(ln2_low) + c);
  return a.k * Pack(ln2_high) - ((half_square - inner) - a.f);
}
/// What logarithms return where there is no reduction: x = 0, x < 0, infinity, NaN.
inline Pack log_special_cases(Pack x, Pack regular) {
  Pack r = select(x < Pack(infinity), regular, x + x);
  r = select(x == Pack(0.0), Pack(-infinity), r);
  return select(x < Pack(0.0), Pack(not_a_number), r);
}

/// log(x) with a relative error below 2^-62, for positive finite x.
inline Pair log_pair(Pack x) {
  static constexpr double p[] = {0x1.999999999999ap-3, 0x1.2492492492521p-3, 0x1.c71c71c6eaa10p-4, 0x1.745d177a96056p-4,
                                 0x1.3b1395d2190c1p-4, 0x1.1118c7e4b0917p-4, 0x1.df7cc8e5fa539p-5, 0x1.e02e6fff27908p-5};
  const LogArgument a = reduce_log(x);
  // s = f/(2 + f) in two parts
  const Pair d = fast_two_sum(Pack(2.0), a.f);
  const Pack inverse = Pack(1.0) / d.high;
  const Pack s = a.f / d.high;
  const Pair sd = two_product(s, d.high);
  const Pack s_low = (((a.f - sd.high) - sd.low) - s * d.low) * inverse;
  // 2 atanh(s) = 2 s + 2 s z (1/3 + z (1/5 + ...)), z = s^2, in two parts up to 1/3
  Pair z = two_product(s, s);
  z.low = z.low + Pack(2.0) * s * s_low;
  Pair q = fast_two_sum(Pack(0x1.5555555555555p-2), z.high * polynomial(z.high, p));
  q.low = q.low + Pack(0x1.5555555555555p-56);
  Pair zq = two_product(z.high, q.high);
  zq.low = zq.low + (z.high * q.low + z.low * q.high);
  Pair t = two_product(s, zq.high);
  t.low = t.low + (s * zq.low + s_low * zq.high);
  Pair m = fast_two_sum(s, t.high);
  m.low = m.low + (t.low + s_low);
  const Pair sum = two_sum(a.k * Pack(ln2_high), Pack(2.0) * m.high);
  return fast_two_sum(sum.high, sum.low + (Pack(2.0) * m.low + a.k * Pack(ln2_low)));
}

inline Mask is_integer(Pack magnitude) {
  const Pack shift(0x1p52);
  return (magnitude >= shift) | (((magnitude + shift) - shift) == magnitude);
}

}  // namespace detail

/// exp, error below 1.5 ulp.
inline Pack exp(Pack x) { return detail::exp_times_power_of_two(x, 0); }

/// exp(x) - 1 without cancellation, error below 2 ulp.
inline Pack expm1(Pack x) {
  const Pack clamped = select(x > Pack(710.0), Pack(710.0), select(x < Pack(-60.0), Pack(-60.0), x));
  const detail::ExpArgument a = detail::reduce_exp(clamped);
  const Pack e = detail::exp_minus_one(a.r);
  const Pack half_power = detail::from_bits((a.n + 1022) << 52);
  const Pack far = Pack(2.0) * ((half_power - Pack(0.5)) + half_power * e);
  return select(Mask(a.n == 0), detail::copy_sign(e, x), far);
}

/// Natural logarithm, error below 1 ulp.
inline Pack log(Pack x) { return detail::log_special_cases(x, detail::assemble_log(detail::reduce_log(x), Pack(0.0))); }

/// log(1 + x) without cancellation, error below 1.5 ulp.
inline Pack log1p(Pack x) {
  const detail::Pair u = detail::two_sum(Pack(1.0), x);
  const Pack r = detail::log_special_cases(u.high, detail::assemble_log(detail::reduce_log(u.high), u.low / u.high));
  return select(x == Pack(0.0), x, r);
}

/// Decimal logarithm, error below 0.51 ulp and so exact at powers of ten.
inline Pack log10(Pack x) {
  const detail::Pair l = detail::log_pair(x);
  const Pack c(0x1.bcb7b1526e50ep-2);
  const detail::Pair p = detail::two_product(l.high, c);
  const Pack r = p.high + (p.low + (l.high * Pack(0x1.95355baaafad3p-57) + l.low * c));
  return detail::log_special_cases(x, r);
}

/// x^y, error below 1.5 ulp, with the special cases of C's pow (IEEE 754-2019, 9.2.1): x^0 = 1^y = 1 even for NaN, negative x with
/// integer y only, signed zeros and infinities by the parity of y.
inline Pack pow(Pack x, Pack y) {
  using namespace detail;
  const Pack magnitude = abs(x);
  const Pack y_magnitude = abs(y);
  // Beyond 2^70 the power of anything but 1 is 0 or infinite; so is it at 2^70, where products cannot overflow.
  const Pack exponent = select(y_magnitude > Pack(0x1p70), copy_sign(Pack(0x1p70), y), y);
  const Pair l = log_pair(magnitude);
  const Pair p = two_product(exponent, l.high);
  const Pack clamped = clamp_exp(p.high);
  const Pack low = select(clamped == p.high, p.low + exponent * l.low, Pack(0.0));
  const ExpArgument a = reduce_exp(clamped);
  Pack r = scale(Pack(1.0) + exp_minus_one(a.r + low), a.n);

  const Mask zero = x == Pack(0.0);
  const Mask infinite = magnitude == Pack(infinity);
  r = select(zero | infinite, select(Mask(zero.v == Mask(y < Pack(0.0)).v), Pack(infinity), Pack(0.0)), r);
  const Mask integer = is_integer(y_magnitude);
  const Mask odd = integer & !is_integer(Pack(0.5) * y_magnitude);
  const Mask negative(to_bits(x) < 0);
  r = select(negative & odd, -r, r);
  r = select((x < Pack(0.0)) & !infinite & !integer, Pack(not_a_number), r);
  r = select((x != x) | (y != y), x + y, r);
  return select((y == Pack(0.0)) | (x == Pack(1.0)), Pack(1.0), r);
}

}  // namespace stiffront
