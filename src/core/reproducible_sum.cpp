// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/core/reproducible_sum.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace stiffront {
namespace {

/// 2^n for n in -1022 .. 1023; ldexp is a call, and a step of a small problem makes dozens.
double power_of_two(int n) { return std::bit_cast<double>(static_cast<std::uint64_t>(n + 1023) << 52); }

}  // namespace

ReproducibleSum::ReproducibleSum() {
  for (Pack& p : part_) p = Pack(0.0);
}

void ReproducibleSum::set_top(int top) {
  top_ = top;
  bound_ = power_of_two(bin_bits * (top + 1));
  // 1.5 * 2^52 units: adding it rounds to a multiple of the unit, subtracting it again is exact.
  for (int k = 0; k < levels; ++k) offset_[k] = 1.5 * power_of_two(52 + bin_bits * (top - k));
}

void ReproducibleSum::flush() {
  if (top_ >= min_top) {
    for (int k = 0; k < levels; ++k) {
      // In units of the bin, in two factors since the inverse of the smallest unit overflows.
      const int exponent = -bin_bits * (top_ - k);
      const double half = power_of_two(exponent / 2);
      const double rest = power_of_two(exponent - exponent / 2);
      for (int l = 0; l < pack_size; ++l) total_[k] += static_cast<std::int64_t>((part_[k][l] * half) * rest);
      part_[k] = Pack(0.0);
    }
  }
  deposits_ = 0;
}

void ReproducibleSum::shift_to(int top) {
  const int shift = top - top_;
  if (top_ >= min_top) {
    for (int k = levels - 1; k >= 0; --k) total_[k] = k - shift >= 0 ? total_[k - shift] : 0;
  }
  set_top(top);
}

Pack ReproducibleSum::raise(Pack x) {
  flush();
  double largest = 0.0;
  for (int l = 0; l < pack_size; ++l) {
    const double v = x[l];
    if (std::isnan(v) || std::abs(v) >= 0x1p960) {
      special_ |= std::isnan(v) ? 1 : (v > 0 ? 2 : 4);
      x.set(l, 0.0);
    } else if (std::abs(v) > largest) {
      largest = std::abs(v);
    }
  }
  // The bin that holds the largest: its exponent over bin_bits, rounded down.
  const int exponent = largest > 0.0 ? std::ilogb(largest) : bin_bits * min_top;
  const int top = std::max(min_top, (exponent - bin_bits * min_top) / bin_bits + min_top);
  if (top > top_) shift_to(top);
  return x;
}

void ReproducibleSum::merge(const ReproducibleSum& other) {
  ReproducibleSum theirs = other;
  theirs.flush();
  flush();
  special_ |= theirs.special_;
  if (theirs.top_ < min_top) return;
  if (theirs.top_ > top_) shift_to(theirs.top_);
  const int shift = top_ - theirs.top_;
  for (int k = 0; k + shift < levels; ++k) total_[k + shift] += theirs.total_[k];
}

double ReproducibleSum::value() const {
  ReproducibleSum s = *this;
  s.flush();
  if (s.special_ == 2) return std::numeric_limits<double>::infinity();
  if (s.special_ == 4) return -std::numeric_limits<double>::infinity();
  if (s.special_ != 0) return std::numeric_limits<double>::quiet_NaN();
  if (s.top_ < min_top) return 0.0;
  // Carry upwards, so that the value is a function of the exact total and not of its division into bins.
  for (int k = levels - 1; k > 0; --k) {
    const Integer carry = s.total_[k] >> bin_bits;
    s.total_[k] -= carry * (Integer{1} << bin_bits);
    s.total_[k - 1] += carry;
  }
  double result = 0.0;
  for (int k = levels - 1; k >= 0; --k) {
    const int exponent = bin_bits * (s.top_ - k);  // in two factors since the smallest unit is no normal number
    result += static_cast<double>(s.total_[k]) * power_of_two(exponent / 2) * power_of_two(exponent - exponent / 2);
  }
  return result;
}

ReproducibleSum::Wire ReproducibleSum::wire() const {
  ReproducibleSum s = *this;
  s.flush();
  Wire w{};
  w.top = s.top_;
  for (int k = 0; k < levels; ++k) {
    w.total[2 * k] = static_cast<std::int64_t>(s.total_[k] >> 64);
    w.total[2 * k + 1] = static_cast<std::int64_t>(static_cast<std::uint64_t>(s.total_[k]));
  }
  w.special = s.special_;
  return w;
}

ReproducibleSum ReproducibleSum::from_wire(const Wire& w) {
  __extension__ typedef unsigned __int128 Unsigned;
  ReproducibleSum s;
  if (w.top >= min_top) s.set_top(static_cast<int>(w.top));
  for (int k = 0; k < levels; ++k) {
    const Unsigned high = static_cast<std::uint64_t>(w.total[2 * k]);
    s.total_[k] = static_cast<Integer>((high << 64) | static_cast<std::uint64_t>(w.total[2 * k + 1]));
  }
  s.special_ = static_cast<int>(w.special);
  return s;
}

}  // namespace stiffront
