// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstdint>

namespace stiffront {

/// A uniform vertex-centred grid in one or two dimensions, end points included; known to every rank in full.
///
/// A periodic direction does not repeat its end point: its spacing is (upper-lower)/points, otherwise (upper-lower)/(points-1).
///
/// Differences of order eight need one more point near a Dirichlet side, a fifth of a spacing from it (space/sub_cell_closure.hpp). It is a
/// point like any other, second from its side in the order of indices, but none of the uniform grid that files and users know.
struct Grid {
  static constexpr double sub_cell_place = 0.2;  ///< in spacings from the side

  int dimension = 1;                         ///< 1 or 2
  std::array<std::int64_t, 2> points{1, 1};  ///< all points; second entry 1 in one dimension
  std::array<double, 2> lower{0.0, 0.0};
  std::array<double, 2> upper{1.0, 1.0};
  std::array<bool, 2> periodic{false, false};
  std::array<std::array<bool, 2>, 2> sub_cell{};  ///< [direction][lower 0 | upper 1]: there is such a point, counted in points

  bool has_sub_cells(int direction) const {
    const auto& sides = sub_cell[static_cast<std::size_t>(direction)];
    return sides[0] || sides[1];
  }
  /// Points of the uniform grid.
  std::int64_t uniform_points(int direction) const {
    const auto d = static_cast<std::size_t>(direction);
    return points[d] - (sub_cell[d][0] ? 1 : 0) - (sub_cell[d][1] ? 1 : 0);
  }
  bool is_sub_cell(int direction, std::int64_t i) const {
    const auto d = static_cast<std::size_t>(direction);
    return (sub_cell[d][0] && i == 1) || (sub_cell[d][1] && i == points[d] - 2);
  }
  /// Index in the uniform grid of point i, which is none of a sub-cell.
  std::int64_t uniform_index(int direction, std::int64_t i) const {
    const auto d = static_cast<std::size_t>(direction);
    return i - (sub_cell[d][0] && i > 1 ? 1 : 0) - (sub_cell[d][1] && i == points[d] - 1 ? 1 : 0);
  }
  /// The point with index k in the uniform grid.
  std::int64_t index_of_uniform(int direction, std::int64_t k) const {
    const auto d = static_cast<std::size_t>(direction);
    return k + (sub_cell[d][0] && k > 0 ? 1 : 0) + (sub_cell[d][1] && k == uniform_points(direction) - 1 ? 1 : 0);
  }
  /// The grid without them.
  Grid uniform() const {
    Grid g = *this;
    for (int d = 0; d < dimension; ++d) g.points[static_cast<std::size_t>(d)] = uniform_points(d);
    g.sub_cell = {};
    return g;
  }
  /// Distance of point i from lower in spacings.
  double place(int direction, std::int64_t i) const {
    if (has_sub_cells(direction) && is_sub_cell(direction, i)) {
      return i == 1 ? sub_cell_place : static_cast<double>(intervals(direction)) - sub_cell_place;
    }
    return static_cast<double>(uniform_index(direction, i));
  }

  /// Number of intervals between lower and upper; 0 for the missing direction of one dimension.
  std::int64_t intervals(int direction) const {
    return uniform_points(direction) - (periodic[static_cast<std::size_t>(direction)] ? 0 : 1);
  }
  double spacing(int direction) const {
    const auto d = static_cast<std::size_t>(direction);
    return (upper[d] - lower[d]) / static_cast<double>(intervals(direction));
  }
  /// Coordinate of the point with global index i; computed from i alone, so it is the same on every rank.
  double position(int direction, std::int64_t i) const {
    return lower[static_cast<std::size_t>(direction)] + place(direction, i) * spacing(direction);
  }
  /// Where point i lies between lower (0) and upper (1): exact at both ends, whatever they are.
  double fraction(int direction, std::int64_t i) const { return place(direction, i) / static_cast<double>(intervals(direction)); }
  std::int64_t total_points() const { return points[0] * points[1]; }
};

}  // namespace stiffront
