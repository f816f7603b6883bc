// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <limits>
#include <span>

#include "stiffront/core/simd.hpp"

namespace stiffront {

/// A sum of doubles whose bits depend on the set of terms alone, not on their order or on how they were grouped.
///
/// Exponents are cut into bins of 40 bits at fixed places. Each term is split, by rounding to the unit of a bin, into parts
/// that are integers in the units of three neighbouring bins; the parts add up exactly. The topmost bin follows the largest
/// term seen; merging two sums keeps the upper one's bins, so the result is as if all terms had been added to one sum. What is
/// dropped is below 2^-80 of the largest term. One merge is one reduction: no maximum has to be known beforehand.
///
/// The totals hold 2^80 terms.
/// @see Demmel & Nguyen, IEEE Trans. Comput. 64(7), 2015, pp. 2060-2070 (binned summation); the integer totals and
///      constant extraction offsets are our variation: they make ties of the rounding independent of the running sum.
class ReproducibleSum {
 public:
  ReproducibleSum();

  void add(double x) {
    Pack p(0.0);
    p.set(0, x);
    add(p);
  }
  /// Adds every lane.
  void add(Pack x) {
    if (!all(abs(x) < Pack(bound_))) x = raise(x);
    for (int k = 0; k < levels; ++k) {
      const Pack q = (x + Pack(offset_[k])) - Pack(offset_[k]);
      part_[k] += q;
      x -= q;
    }
    if (++deposits_ == max_deposits) flush();
  }
  /// Adds the lanes of the mask.
  void add(Pack x, Mask m) { add(select(m, x, Pack(0.0))); }

  /// Adds every lane of packs without negative lanes, at less cost than one by one.
  void add(std::span<const Pack> terms);

  /// Adds all terms of another sum.
  void merge(const ReproducibleSum& other);

  /// The sum, correct to about 2^-80 of the largest term times the number of terms; NaN or infinity if a term was one.
  double value() const;

  void reset() { *this = ReproducibleSum(); }

  /// The form in which a sum travels: plain integers, the same for the same set of terms as long as no term is added.
  struct Wire {
    std::int64_t top;       ///< index of the topmost bin, or the lowest number if nothing was added
    std::int64_t total[6];  ///< three totals, each as (high, low) 64-bit halves of a 128-bit integer
    std::int64_t special;   ///< 1: a NaN was added, 2: +inf, 4: -inf, or-ed
  };
  Wire wire() const;
  static ReproducibleSum from_wire(const Wire& w);
  /// Adds all terms of another sum that travels.
  static void merge(Wire& sum, const Wire& other);

 private:
  static constexpr int levels = 3;
  static constexpr int bin_bits = 40;
  static constexpr int max_top = 23;   // terms below 2^(40*24) = 2^960
  static constexpr int min_top = -24;  // the lowest bin's unit is then 2^-1040
  static constexpr int max_deposits = 1 << 11;
  __extension__ typedef __int128 Integer;

  /// Makes room for larger terms; notes and takes out what is not finite.
  Pack raise(Pack x);
  void set_top(int top);
  void shift_to(int top);
  void flush();

  int top_ = min_top - 1;
  int deposits_ = 0;
  int special_ = 0;
  double bound_ = 0.0;
  double offset_[levels] = {};
  Pack part_[levels];
  Integer total_[levels] = {};
};

}  // namespace stiffront
