// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <string>
#include <utility>

#include "stiffront/mesh/boundary.hpp"
#include "stiffront/mesh/grid.hpp"

namespace stiffront::testing {

/// Kinds of the lower and the upper side of one direction.
using Sides = std::array<BoundaryKind, 2>;

inline constexpr Sides periodic{BoundaryKind::periodic, BoundaryKind::periodic};
inline constexpr Sides neumann{BoundaryKind::neumann, BoundaryKind::neumann};
inline constexpr Sides dirichlet{BoundaryKind::dirichlet, BoundaryKind::dirichlet};
inline constexpr Sides mixed{BoundaryKind::dirichlet, BoundaryKind::neumann};
inline constexpr std::array<Sides, 4> all_sides{periodic, neumann, dirichlet, mixed};

inline std::string name_of(const Sides& sides) {
  if (sides == periodic) return "periodic";
  if (sides == neumann) return "neumann";
  return sides == dirichlet ? "dirichlet" : "mixed";
}

/// A grid on [0, 1] or the unit square; one dimension if n_y = 0.
inline Grid unit_grid(int n_x, int n_y, const Sides& x, const Sides& y = neumann) {
  Grid grid;
  grid.dimension = n_y == 0 ? 1 : 2;
  grid.points = {n_x, n_y == 0 ? 1 : n_y};
  grid.periodic = {x == periodic, n_y != 0 && y == periodic};
  return grid;
}

/// The same with the sub-cells that differences of order eight need.
inline Grid unit_grid_of_order(int order, int n_x, int n_y, const Sides& x, const Sides& y = neumann) {
  Grid grid = unit_grid(n_x, n_y, x, y);
  for (std::size_t d = 0; d < static_cast<std::size_t>(grid.dimension); ++d) {
    for (std::size_t which = 0; which < 2; ++which) {
      grid.sub_cell[d][which] = order == 8 && (d == 0 ? x : y)[which] == BoundaryKind::dirichlet;
      if (grid.sub_cell[d][which]) ++grid.points[d];
    }
  }
  return grid;
}

/// Boundaries of the given kinds; Dirichlet sides of every species take the value of the function.
inline Boundary boundary_of(const Sides& x, const Sides& y, int n_species, const BoundaryValue& value) {
  std::array<std::array<BoundarySide, 2>, 2> sides;
  for (std::size_t which = 0; which < 2; ++which) {
    sides[0][which].kind = x[which];
    sides[1][which].kind = y[which];
    for (std::size_t d = 0; d < 2; ++d) {
      if (sides[d][which].kind == BoundaryKind::dirichlet) sides[d][which].values.assign(static_cast<std::size_t>(n_species), value);
    }
  }
  return Boundary(std::move(sides));
}

inline double zero(double, double, double) { return 0.0; }

}  // namespace stiffront::testing
