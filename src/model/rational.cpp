// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/model/rational.hpp"

#include <limits>
#include <numeric>

#include "stiffront/core/error.hpp"

namespace stiffront {
namespace {

[[noreturn]] void overflow() { throw Error(ErrorKind::input, "the coefficients are too large for exact arithmetic"); }

std::int64_t product(std::int64_t a, std::int64_t b) {
  std::int64_t r;
  if (__builtin_mul_overflow(a, b, &r)) overflow();
  return r;
}
std::int64_t sum(std::int64_t a, std::int64_t b) {
  std::int64_t r;
  if (__builtin_add_overflow(a, b, &r)) overflow();
  return r;
}

}  // namespace

Rational::Rational(std::int64_t numerator, std::int64_t denominator) {
  constexpr std::int64_t least = std::numeric_limits<std::int64_t>::min();  // has no negative
  if (numerator == least || denominator == least) overflow();
  const std::int64_t divisor = std::gcd(numerator, denominator) * (denominator < 0 ? -1 : 1);
  numerator_ = numerator / divisor;
  denominator_ = denominator / divisor;
}

Rational operator+(const Rational& a, const Rational& b) {
  return {sum(product(a.numerator_, b.denominator_), product(b.numerator_, a.denominator_)), product(a.denominator_, b.denominator_)};
}
Rational operator-(const Rational& a, const Rational& b) { return a + Rational(-1) * b; }
Rational operator*(const Rational& a, const Rational& b) {
  return {product(a.numerator_, b.numerator_), product(a.denominator_, b.denominator_)};
}
Rational operator/(const Rational& a, const Rational& b) {
  return {product(a.numerator_, b.denominator_), product(a.denominator_, b.numerator_)};
}

}  // namespace stiffront
