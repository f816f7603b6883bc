// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstdint>

#include "stiffront/core/mpi.hpp"
#include "stiffront/mesh/grid.hpp"

namespace stiffront {

/// A Cartesian layout of ranks over a grid and this rank's box in it.
///
/// Sizes need not divide: boxes along a direction differ by one point at most, the larger ones first.
class Decomposition {
 public:
  /// @param processes ranks per direction; 0 leaves the choice to the layout with the least halo surface.
  /// @param min_points least number of points a box must have in every divided direction (the widest halo used).
  /// @throws Error(input) on every rank if the layout does not match the number of ranks or a box would be too small.
  /// @mpi comm must outlive the decomposition.
  Decomposition(const Communicator& comm, const Grid& grid, std::array<int, 2> processes, int min_points);

  const Communicator& comm() const { return *comm_; }
  const Grid& grid() const { return grid_; }
  std::array<int, 2> processes() const { return processes_; }
  std::array<int, 2> coordinates() const { return coordinates_; }
  /// Points of this rank's box and the global index of its first point, per direction.
  int n_x() const { return size_[0]; }
  int n_y() const { return size_[1]; }
  std::int64_t offset_x() const { return offset_[0]; }
  std::int64_t offset_y() const { return offset_[1]; }
  /// Whether the box touches the physical lower (side 0) or upper (side 1) boundary; never in a periodic direction.
  bool at_boundary(int direction, int side) const;
  /// Rank at (dx, dy) from here, -1 <= dx, dy <= 1; MPI_PROC_NULL beyond a physical boundary.
  int neighbour(int dx, int dy) const;
  /// Global box of any rank: {offset_x, offset_y, n_x, n_y}.
  std::array<std::int64_t, 4> box_of(int rank) const;

 private:
  const Communicator* comm_;
  Grid grid_;
  std::array<int, 2> processes_{1, 1};
  std::array<int, 2> coordinates_{0, 0};
  std::array<int, 2> size_{1, 1};
  std::array<std::int64_t, 2> offset_{0, 0};
};

}  // namespace stiffront
