// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "stiffront/core/aligned_array.hpp"
#include "stiffront/mesh/rows.hpp"

namespace stiffront {

/// A moving window of rows of all species, laid out so that the window stays in cache while it moves over a field.
class RowRing {
 public:
  /// @param shape a field with the length and halo of the rows
  /// @param n_rows least number of rows alive at a time
  RowRing(const Field& shape, int n_rows);

  /// Rows of a window of at most n_rows; any index, the rows alive being those of the last n_rows written. A narrower window takes less
  /// of the cache.
  Rows rows(int n_rows);

 private:
  AlignedArray storage_;
  Rows rows_;
};

}  // namespace stiffront
