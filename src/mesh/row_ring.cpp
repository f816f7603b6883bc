// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/mesh/row_ring.hpp"

#include <algorithm>
#include <bit>

namespace stiffront {

RowRing::RowRing(const Field& shape, int n_rows) {
  constexpr std::ptrdiff_t line = 8;  // doubles in 64 bytes
  const auto n = static_cast<std::ptrdiff_t>(std::bit_ceil(static_cast<unsigned>(n_rows)));
  const std::ptrdiff_t stride = shape.row_stride();
  // Where kernels work on halos in whole packs, the points before the outermost of these are read too.
  const std::ptrdiff_t left = (shape.halo() + line - 1) / line * line + line;
  // One more line per species, so that equal offsets in different species do not fall on one cache set.
  const std::ptrdiff_t species = n * stride + line;
  storage_ = aligned_zeros(static_cast<std::size_t>(shape.n_species() * species + 2 * line));
  rows_ = {storage_.get() + left, species, stride, static_cast<int>(n) - 1};
}

Rows RowRing::rows(int n_rows) {
  Rows window = rows_;
  window.mask = std::min(window.mask, static_cast<int>(std::bit_ceil(static_cast<unsigned>(n_rows))) - 1);
  return window;
}

}  // namespace stiffront
