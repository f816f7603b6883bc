// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/core/reproducible_sum.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

namespace stiffront {
namespace {

constexpr double huge = 0x1p960;  ///< what is not smaller has no bin

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
  if (deposits_ > 0) {
    for (int k = 0; k < levels; ++k) {
      // In units of the bin, in two factors since the inverse of the smallest unit overflows.
      const int exponent = -bin_bits * (top_ - k);
      const double half = power_of_two(exponent / 2);
      const double rest = power_of_two(exponent - exponent / 2);
      typedef std::int64_t Integers __attribute__((vector_size(pack_size * sizeof(std::int64_t))));  // NOLINT: an alias loses the attribute
      const Integers lanes = __builtin_convertvector(((part_[k] * Pack(half)) * Pack(rest)).v, Integers);
      std::int64_t sum = 0;  // of at most 2^51 each
      for (int l = 0; l < pack_size; ++l) sum += lanes[l];
      total_[k] += sum;
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
  if (!all(abs(x) < Pack(huge))) {
    for (int l = 0; l < pack_size; ++l) {
      const double v = x[l];
      if (std::abs(v) < huge) continue;
      special_ |= std::isnan(v) ? 1 : (v > 0 ? 2 : 4);
      x.set(l, 0.0);
    }
  }
  // The bin that holds the largest: its exponent over bin_bits, rounded down. What is subnormal is in the lowest.
  const int exponent = static_cast<int>(std::bit_cast<std::uint64_t>(max_lane(abs(x))) >> 52) - 1023;
  const int top = std::max(min_top, (exponent - bin_bits * min_top) / bin_bits + min_top);
  if (top > top_) shift_to(top);
  return x;
}

void ReproducibleSum::add(std::span<const Pack> terms) {
  const auto deposits = static_cast<int>(terms.size());
  Pack even(0.0);
  Pack odd(0.0);
  std::size_t n = 0;
  for (; n + 2 <= terms.size(); n += 2) {
    even += terms[n];
    odd += terms[n + 1];
  }
  if (n < terms.size()) even += terms[n];
  const Pack sum = even + odd;
  if (!all(sum < Pack(bound_)) || deposits_ + deposits > max_deposits) {
    if (!all(sum < Pack(huge)) || deposits_ + deposits > max_deposits) {
      for (const Pack& x : terms) add(x);
      return;
    }
    Pack largest(0.0);
    for (const Pack& x : terms) largest = max(largest, x);
    raise(largest);
  }
  // In registers, and the bins by number: a call or a loop over them would keep everything in memory.
  static_assert(levels == 3);
  const Pack offset_0(offset_[0]);
  const Pack offset_1(offset_[1]);
  const Pack offset_2(offset_[2]);
  Pack part_0 = part_[0];
  Pack part_1 = part_[1];
  Pack part_2 = part_[2];
  for (Pack x : terms) {
    const Pack q_0 = (x + offset_0) - offset_0;
    x -= q_0;
    const Pack q_1 = (x + offset_1) - offset_1;
    x -= q_1;
    const Pack q_2 = (x + offset_2) - offset_2;
    part_0 += q_0;
    part_1 += q_1;
    part_2 += q_2;
  }
  part_[0] = part_0;
  part_[1] = part_1;
  part_[2] = part_2;
  deposits_ += deposits;
  if (deposits_ == max_deposits) flush();
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

void ReproducibleSum::merge(Wire& sum, const Wire& other) {
  __extension__ typedef unsigned __int128 Unsigned;
  Wire lower = other;
  if (lower.top > sum.top) std::swap(lower, sum);
  sum.special |= lower.special;
  if (lower.top < min_top) return;
  const auto total = [](const Wire& w, std::int64_t k) {
    return (static_cast<Unsigned>(static_cast<std::uint64_t>(w.total[2 * k])) << 64) | static_cast<std::uint64_t>(w.total[2 * k + 1]);
  };
  const std::int64_t shift = sum.top - lower.top;
  for (std::int64_t k = 0; k + shift < levels; ++k) {
    const Unsigned added = total(sum, k + shift) + total(lower, k);
    sum.total[2 * (k + shift)] = static_cast<std::int64_t>(static_cast<std::uint64_t>(added >> 64));
    sum.total[2 * (k + shift) + 1] = static_cast<std::int64_t>(static_cast<std::uint64_t>(added));
  }
}

}  // namespace stiffront
