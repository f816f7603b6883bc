// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <functional>
#include <vector>

#include "stiffront/core/mpi.hpp"
#include "stiffront/mesh/boundary.hpp"
#include "stiffront/mesh/field.hpp"
#include "stiffront/space/diffusion_operator.hpp"

namespace stiffront::testing {

/// Both sides of a direction of one kind, with these Dirichlet values if it is Dirichlet.
inline std::array<BoundarySide, 2> both_sides(BoundaryKind kind, int n_species, BoundaryValue value = {}, bool depends_on_time = false) {
  BoundarySide side;
  side.kind = kind;
  if (kind == BoundaryKind::dirichlet) {
    side.values.assign(static_cast<std::size_t>(n_species), value);
    side.depends_on_time = depends_on_time;
  }
  return {side, side};
}

/// A grid, its boundary and a diffusion operator on it, over the ranks of a communicator.
struct DiffusionProblem {
  DiffusionProblem(const Communicator& comm, const Grid& grid_, std::array<std::array<BoundarySide, 2>, 2> sides,
                   std::vector<double> coefficients, int order, std::array<int, 2> processes = {0, 0})
      : grid(grid_),
        decomposition(comm, grid, processes, 4),
        boundary(std::move(sides)),
        diffusion(grid, boundary, std::move(coefficients), order) {}
  DiffusionProblem(const DiffusionProblem&) = delete;
  DiffusionProblem& operator=(const DiffusionProblem&) = delete;

  /// With room for the stencil applied so many times.
  Field field(int depth = 1) const { return Field(decomposition, diffusion.n_species(), depth * diffusion.halo_width()); }
  /// value(species, x, y) at every point of this rank's box.
  Field field(const std::function<double(int, double, double)>& value) const { return field(1, value); }
  Field field(int depth, const std::function<double(int, double, double)>& value) const {
    Field u = field(depth);
    for (int s = 0; s < u.n_species(); ++s) {
      for (int j = 0; j < u.n_y(); ++j) {
        for (int i = 0; i < u.n_x(); ++i) {
          u.at(s, i, j) = value(s, grid.position(0, decomposition.offset_x() + i),
                                grid.dimension == 2 ? grid.position(1, decomposition.offset_y() + j) : 0.0);
        }
      }
    }
    return u;
  }

  Grid grid;
  Decomposition decomposition;
  Boundary boundary;
  DiffusionOperator diffusion;
};

/// The unit square or interval with the given numbers of points.
inline Grid unit_grid(std::int64_t n_x, std::int64_t n_y, bool periodic_x = false, bool periodic_y = false) {
  Grid grid;
  grid.dimension = n_y > 1 ? 2 : 1;
  grid.points = {n_x, n_y};
  grid.periodic = {periodic_x, n_y > 1 && periodic_y};
  return grid;
}

/// A number in [0, 1) that depends on its arguments only: rough data that are the same on every layout.
inline double scatter(std::int64_t a, std::int64_t b = 0, std::int64_t c = 0) {
  std::uint64_t x = static_cast<std::uint64_t>(a) * 0x9E3779B97F4A7C15U + static_cast<std::uint64_t>(b) * 0xC2B2AE3D27D4EB4FU +
                    static_cast<std::uint64_t>(c) * 0x165667B19E3779F9U + 1U;
  x ^= x >> 30U;
  x *= 0xBF58476D1CE4E5B9U;
  x ^= x >> 27U;
  x *= 0x94D049BB133111EBU;
  x ^= x >> 31U;
  return static_cast<double>(x >> 11U) * 0x1p-53;
}

}  // namespace stiffront::testing
