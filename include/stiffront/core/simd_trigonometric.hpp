// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cmath>

#include "stiffront/core/simd_bits.hpp"

/// Circular functions of packs and their inverses.
namespace stiffront {

namespace detail {

inline constexpr double half_pi_high = 0x1.921fb54442d18p+0;
inline constexpr double half_pi_low = 0x1.1a62633145c07p-54;

/// Up to here the reduction below is exact to the last bit; larger arguments go lane by lane to the C library.
inline constexpr double largest_reduced_angle = 1e5;

/// sin and cos of x reduced to |y| <= pi/4: x = quadrant * pi/2 + y.high + y.low.
struct Angle {
  Bits quadrant;
  Pair y;
};
inline Angle reduce_angle(Pack x) {
  const Integer k = nearest_integer(x, 0x1.45f306dc9c883p-1);
  // pi/2 in parts of 33 bits, whose products with k < 2^17 are exact, and a last one; together good to 2^-150
  const Pair first = two_sum(x - k.value * Pack(0x1.921fb54400000p+0), -(k.value * Pack(0x1.0b4611a600000p-34)));
  const Pair second = two_sum(first.high, -(k.value * Pack(0x1.3198a2e000000p-69)));
  const Pack rest = (first.low + second.low) - k.value * Pack(0x1.b839a252049c1p-104);
  return {k.i, fast_two_sum(second.high, rest)};
}

struct SinCos {
  Pack sin;
  Pack cos;
};
inline SinCos sin_cos_reduced(Pair y) {
  static constexpr double s[] = {0x1.1111111111110p-7,   -0x1.a01a01a019937p-13, 0x1.71de3a54607a5p-19,
                                 -0x1.ae64541295cdfp-26, 0x1.61217ee5cca1bp-33,  -0x1.ab17bdcbd3414p-41};
  static constexpr double c[] = {0x1.5555555555555p-5,   -0x1.6c16c16c16967p-10, 0x1.a01a019f4e9b4p-16,
                                 -0x1.27e4fa17bf139p-22, 0x1.1eeb68cd22f56p-29,  -0x1.907d8f29fe831p-37};
  const Pack z = y.high * y.high;
  const Pack cube = z * y.high;
  SinCos r;
  r.sin = y.high + ((cube * (Pack(-0x1.5555555555555p-3) + z * polynomial(z, s)) - Pack(0.5) * z * y.low) + y.low);
  const Pack half = Pack(0.5) * z;
  const Pack w = Pack(1.0) - half;
  r.cos = w + (((Pack(1.0) - w) - half) + (z * z * polynomial(z, c) - y.high * y.low));
  return r;
}
inline SinCos sin_cos(Pack x) {
  const Angle a = reduce_angle(x);
  const SinCos r = sin_cos_reduced(a.y);
  const Mask odd((a.quadrant & 1) != 0);
  const Bits sin_sign = (a.quadrant & 2) << 62;
  const Bits cos_sign = ((a.quadrant + 1) & 2) << 62;
  return {from_bits(to_bits(select(odd, r.cos, r.sin)) ^ sin_sign), from_bits(to_bits(select(odd, r.sin, r.cos)) ^ cos_sign)};
}
/// Lanes beyond the reduction, one by one.
template <class F>
Pack with_large_angles(Pack x, Pack regular, F f) {
  const Mask large = abs(x) > Pack(largest_reduced_angle);
  if (any(large)) {
    for (int l = 0; l < pack_size; ++l) {
      if (large[l]) regular.set(l, f(x[l]));
    }
  }
  return regular;
}

/// (asin(x) - x)/x as a function of z = x^2 <= 1/4.
inline Pack asin_tail(Pack z) {
  static constexpr double c[] = {0x1.5555555555555p-3,  0x1.3333333333388p-4, 0x1.6db6db6dac1e0p-5, 0x1.f1c71c7a52ba3p-6,
                                 0x1.6e8ba123e494cp-6,  0x1.1c4efce23019fp-6, 0x1.c990ad3d8fdcap-7, 0x1.7b027ee1dd585p-7,
                                 0x1.3b49de7121487p-7,  0x1.31622469ce5adp-7, 0x1.8f193743418ffp-9, 0x1.406192d124629p-6,
                                 -0x1.3b416bb7d9257p-6, 0x1.e529c6fce9bb4p-6};
  return z * polynomial(z, c);
}
/// asin(s) with s = sqrt((1 - |x|)/2) for 1/2 <= |x| <= 1, as head + tail with a head of 21 bits.
struct HalfAngle {
  Pack head;
  Pack tail;
};
inline HalfAngle asin_of_half_angle(Pack z) {
  const Pack s = sqrt(z);
  const Pack head = from_bits(to_bits(s) & ~splat(0xffffffff));
  const Pack rest = select(s == Pack(0.0), s, (z - head * head) / (s + head));  // s = head + rest
  return {head, mul_add(s, asin_tail(z), rest)};
}

}  // namespace detail

/// Error below 1 ulp up to |x| = 1e5; beyond, the C library's results.
inline Pack sin(Pack x) {
  const Pack r = select(x == Pack(0.0), x, detail::sin_cos(x).sin);
  return detail::with_large_angles(x, r, [](double a) { return std::sin(a); });
}
/// Error below 1 ulp up to |x| = 1e5; beyond, the C library's results.
inline Pack cos(Pack x) {
  return detail::with_large_angles(x, detail::sin_cos(x).cos, [](double a) { return std::cos(a); });
}
/// Error below 2.5 ulp up to |x| = 1e5; beyond, the C library's results.
inline Pack tan(Pack x) {
  const detail::SinCos r = detail::sin_cos(x);
  return detail::with_large_angles(x, select(x == Pack(0.0), x, r.sin / r.cos), [](double a) { return std::tan(a); });
}

/// Error below 1.5 ulp; NaN beyond [-1, 1].
inline Pack asin(Pack x) {
  using namespace detail;
  const Pack magnitude = abs(x);
  const Pack near = mul_add(magnitude, asin_tail(magnitude * magnitude), magnitude);
  // pi/2 - 2 asin(s), from pi/4 so that the large parts cancel exactly
  const HalfAngle a = asin_of_half_angle(Pack(0.5) * (Pack(1.0) - magnitude));
  const Pack quarter_pi(0.5 * half_pi_high);
  const Pack far = quarter_pi - ((Pack(2.0) * a.tail - Pack(half_pi_low)) - (quarter_pi - Pack(2.0) * a.head));
  return copy_sign(select(magnitude < Pack(0.5), near, far), x);
}
/// Error below 1.5 ulp; NaN beyond [-1, 1].
inline Pack acos(Pack x) {
  using namespace detail;
  const Pack magnitude = abs(x);
  const Pack near = Pack(half_pi_high) - (x - (Pack(half_pi_low) - x * asin_tail(x * x)));
  const HalfAngle a = asin_of_half_angle(Pack(0.5) * (Pack(1.0) - magnitude));
  const Pack positive = Pack(2.0) * (a.head + a.tail);
  const Pack negative = Pack(2.0 * half_pi_high) - Pack(2.0) * (a.head + (a.tail - Pack(half_pi_low)));
  return select(magnitude < Pack(0.5), near, select(x < Pack(0.0), negative, positive));
}

/// Error below 2 ulp.
inline Pack atan(Pack x) {
  using namespace detail;
  static constexpr double c[] = {-0x1.5555555555555p-2, 0x1.9999999999953p-3, -0x1.249249248d7dcp-3, 0x1.c71c71c303dbbp-4,
                                 -0x1.745d165dc9713p-4, 0x1.3b1392d519db1p-4, -0x1.110e87b4357d2p-4, 0x1.e19a0bfa3eef9p-5,
                                 -0x1.ac7a5a79b3f26p-5, 0x1.74dccfb93fff0p-5, -0x1.1b311bb48c215p-5, 0x1.0acd9e91a5a35p-6};
  // |x| is turned back by 0, pi/4 or pi/2 so that tangents of at most tan(pi/8) remain
  const Pack a = abs(x);
  const Mask middle = a > Pack(0x1.a827999fcef32p-2);
  const Mask large = a > Pack(0x1.3504f333f9de6p+1);
  const Pack numerator = select(large, Pack(-1.0), select(middle, a - Pack(1.0), a));
  const Pack denominator = select(large, a, select(middle, a + Pack(1.0), Pack(1.0)));
  const Pack turned_high = select(large, Pack(half_pi_high), select(middle, Pack(0.5 * half_pi_high), Pack(0.0)));
  const Pack turned_low = select(large, Pack(half_pi_low), select(middle, Pack(0.5 * half_pi_low), Pack(0.0)));
  const Pack t = numerator / denominator;
  const Pack z = t * t;
  const Pack tail = mul_add(t * z, polynomial(z, c), turned_low);
  return copy_sign(turned_high + (t + tail), x);
}

}  // namespace stiffront
