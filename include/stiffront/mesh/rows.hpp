// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>

#include "stiffront/mesh/field.hpp"

namespace stiffront {

/// The rows of all species of a field, or of a ring that holds a moving window of them.
///
/// Row j of a ring of 2^k rows lies where rows j +- 2^k lie, so that a window of 2^k rows may be alive at a time.
template <class T>
struct RowsOf {
  T* origin = nullptr;  ///< row 0 of species 0
  std::ptrdiff_t species_stride = 0;
  std::ptrdiff_t row_stride = 0;
  int mask = -1;  ///< of row indices: all bits, or 2^k - 1

  /// Address of point 0 of row j; j may be negative.
  T* row(int species, int j) const { return origin + species * species_stride + (j & mask) * row_stride; }
  /// Distance in memory from row j to row j + by, the same for all species.
  std::ptrdiff_t distance(int j, int by) const { return (((j + by) & mask) - (j & mask)) * row_stride; }

  operator RowsOf<const T>() const { return {origin, species_stride, row_stride, mask}; }
};

using Rows = RowsOf<double>;
using ConstRows = RowsOf<const double>;

inline Rows rows_of(Field& u) { return {u.row(0, 0), u.species_stride(), u.row_stride()}; }
inline ConstRows rows_of(const Field& u) { return {u.row(0, 0), u.species_stride(), u.row_stride()}; }

}  // namespace stiffront
