// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/mesh/field.hpp"

#include <algorithm>
#include <cstring>

#include "stiffront/core/simd.hpp"

namespace stiffront {
namespace {

constexpr std::ptrdiff_t line = 8;  // doubles in 64 bytes: the alignment of row starts, whatever the pack size

std::ptrdiff_t round_up(std::ptrdiff_t n) { return (n + line - 1) / line * line; }

}  // namespace

Field::Field(const Decomposition& decomposition, int n_species, int halo)
    : decomposition_(&decomposition),
      n_species_(n_species),
      halo_(halo),
      halo_y_(decomposition.grid().dimension == 2 ? halo : 0),
      n_x_(decomposition.n_x()),
      n_y_(decomposition.n_y()) {
  // Where kernels work on halos, the pack before that of the outermost point they compute is read too.
  const std::ptrdiff_t left = round_up(std::max(halo - 1, 0)) + line;
  // A pack that starts at the last interior point and is shifted by the halo width must stay inside the row.
  row_stride_ = left + round_up(n_x_ + halo + line);
  const std::ptrdiff_t rows = n_y_ + 2 * halo_y_;
  // One more line per species, so that equal offsets in different species do not fall on one cache set.
  species_stride_ = rows * row_stride_ + line;
  origin_ = left + halo_y_ * row_stride_;
  size_ = static_cast<std::size_t>(round_up(n_species_ * species_stride_ + line));
  data_ = aligned_zeros(size_);
}

void Field::copy_interior(const Field& other, int species) {
  for (int j = 0; j < n_y_; ++j) {
    std::memcpy(row(species, j), other.row(species, j), static_cast<std::size_t>(n_x_) * sizeof(double));
  }
}

void Field::copy_interior(const Field& other) {
  for (int s = 0; s < n_species_; ++s) copy_interior(other, s);
}

}  // namespace stiffront
