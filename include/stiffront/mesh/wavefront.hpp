// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <cstddef>
#include <limits>
#include <span>

#include "stiffront/core/simd.hpp"

namespace stiffront {

/// What the rows under way may take of a processor's caches, in bytes: some of the last level too, since one more pass over memory costs more.
inline constexpr std::ptrdiff_t wavefront_cache_share = 2048 * 1024;

/// What stays in the cache that a processor has for itself, in bytes.
inline constexpr std::ptrdiff_t own_cache = 1024 * 1024;

/// One of several passes over the rows of a box (or the points of a line), each of which reads what the one before left there and a little
/// beyond.
struct WavefrontPass {
  int behind;  ///< rows that the pass stays behind the first one
  int begin;   ///< its rows, begin .. end - 1; they may lie beyond the box
  int end;
};

/// Makes passes follow each other over the rows at the distance of a stencil, so that what one leaves the next finds in cache:
/// on(p, begin, end) is called for `rows` rows of pass p at a time.
///
/// When rows .. end - 1 of pass p come, an earlier pass q has been over its rows before end + behind_p - behind_q, and a later
/// one over none of its rows from begin - (behind_q - behind_p) on. So pass p may read as far beyond its rows as it stays behind
/// pass p - 1, and, if all passes stay equally far behind each other, write over what pass p - 1 has read: two arrays that take turns do.
/// @pre rows > 0; passes in the order of `behind`
template <class On>
void wavefront(std::span<const WavefrontPass> passes, int rows, On&& on) {
  int first = std::numeric_limits<int>::max();
  int last = std::numeric_limits<int>::min();
  for (const WavefrontPass& pass : passes) {
    first = std::min(first, pass.begin + pass.behind);
    last = std::max(last, pass.end + pass.behind);
  }
  // From a whole number of packs, so that those along a line stay aligned.
  const int start = first & -pack_size;
  for (int front = start; front < last; front += rows) {
    for (std::size_t p = 0; p < passes.size(); ++p) {
      const int begin = std::max(front - passes[p].behind, passes[p].begin);
      const int end = std::min(front - passes[p].behind + rows, passes[p].end);
      if (begin < end) on(p, begin, end);
    }
  }
}

/// The same on a ring of n rows, row n being row 0 again, for passes that begin where they are behind: the rows that each is behind the
/// first one it makes last, when the pass before has come round to them. The rows of a call lie in 0 .. n - 1.
template <class On>
void wavefront_around(std::span<const WavefrontPass> passes, int n, int rows, On&& on) {
  wavefront(passes, rows, [&](std::size_t p, int begin, int end) {
    while (begin < end) {
      const int turn = begin / n * n;
      const int stop = std::min(end, turn + n);
      on(p, begin - turn, stop - turn);
      begin = stop;
    }
  });
}

}  // namespace stiffront
