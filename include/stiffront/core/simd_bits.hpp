// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <cstring>
#include <limits>

#include "stiffront/core/simd.hpp"

/// What the elementary functions on packs are made of: the bits of doubles as integers, exact sums and products, polynomials.
namespace stiffront::detail {

using Bits = Mask::Vector;

inline Bits splat(std::int64_t i) { return i - Bits{}; }
inline Bits to_bits(Pack a) {
  Bits r;
  std::memcpy(&r, &a.v, sizeof r);
  return r;
}
inline Pack from_bits(Bits b) {
  Pack r;
  std::memcpy(&r.v, &b, sizeof b);
  return r;
}

inline constexpr std::int64_t sign_bit = std::numeric_limits<std::int64_t>::min();
inline constexpr double infinity = std::numeric_limits<double>::infinity();
inline constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

inline Pack copy_sign(Pack magnitude, Pack sign) {
  return from_bits((to_bits(magnitude) & ~splat(sign_bit)) | (to_bits(sign) & splat(sign_bit)));
}

/// Adding 1.5 * 2^52 rounds to an integer, which then stands in the low bits of the sum.
inline constexpr double integer_shift = 6755399441055744.0;

struct Integer {
  Pack value;
  Bits i;
};
/// The integer nearest to a*b for |a*b| < 2^51.
inline Integer nearest_integer(Pack a, double b) {
  const Pack shifted = mul_add(a, Pack(b), Pack(integer_shift));
  return {shifted - Pack(integer_shift), to_bits(shifted) - to_bits(Pack(integer_shift))};
}
/// An integer of modulus below 2^51 as a double.
inline Pack to_double(Bits i) { return from_bits(i + to_bits(Pack(integer_shift))) - Pack(integer_shift); }

/// a * 2^n with one rounding, -2000 < n < 2000, for a near 1.
inline Pack scale(Pack a, Bits n) {
  const Bits half = n >> 1;
  const Pack first = from_bits((half + 1023) << 52);
  const Pack second = from_bits((n - half + 1023) << 52);
  return a * first * second;
}

/// high + low, |low| <= ulp(high)/2.
struct Pair {
  Pack high;
  Pack low;
};
/// Exactly a + b.
inline Pair two_sum(Pack a, Pack b) {
  const Pack s = a + b;
  const Pack b_part = s - a;
  return {s, (a - (s - b_part)) + (b - b_part)};
}
/// Exactly a + b if |a| >= |b| or a = 0.
inline Pair fast_two_sum(Pack a, Pack b) {
  const Pack s = a + b;
  return {s, b - (s - a)};
}
/// Exactly a * b, barring overflow and underflow.
inline Pair two_product(Pack a, Pack b) {
  const Pack p = a * b;
#if (defined(__AVX512F__) && defined(__AVX512DQ__)) || defined(__FMA__)
  return {p, mul_add(a, b, -p)};
#else
  const auto head = [](Pack x) {
    const Pack c = x * Pack(134217729.0);
    return c - (c - x);
  };
  const Pack a1 = head(a);
  const Pack b1 = head(b);
  const Pack a2 = a - a1;
  const Pack b2 = b - b1;
  return {p, ((a1 * b1 - p) + a1 * b2 + a2 * b1) + a2 * b2};
#endif
}

/// c[0] + c[1] x + c[2] x^2 + ...
template <int N>
Pack polynomial(Pack x, const double (&c)[N]) {
  Pack r(c[N - 1]);
  for (int i = N - 2; i >= 0; --i) r = mul_add(r, x, Pack(c[i]));
  return r;
}

}  // namespace stiffront::detail
