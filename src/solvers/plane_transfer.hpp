// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <vector>

#include "stiffront/solvers/coarse_grids.hpp"

namespace stiffront {

/// The ways from a grid to the next coarser one and back. Every number is made by the same operations wherever it lies.
class PlaneTransfer {
 public:
  /// @param grid the finer one; must outlive the transfer
  explicit PlaneTransfer(const CoarseGrid& grid) : grid_(&grid) {}

  /// result = means of u on the coarser grid; on a whole one this rank's part. @pre the halo of u is up to date, corners too
  void restrict_to(const CoarseGrid& coarse, const PlaneView& u, const PlaneView& result, int components);
  /// u += interpolated values of the coarser grid at the unknowns. @pre their halo is up to date, corners too
  void add_from(const CoarseGrid& coarse, const PlaneView& values, const PlaneView& u, int components);
  /// Points of the coarser grid in this rank's part of the finer one: first and last + 1, along a direction.
  std::array<int, 2> coarse_part(int direction) const;

 private:
  const CoarseGrid* grid_;
  std::vector<double> strip_;  // one row, halo included
};

}  // namespace stiffront
