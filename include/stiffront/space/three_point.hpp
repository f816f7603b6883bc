// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>

#include "stiffront/mesh/grid.hpp"

namespace stiffront {

/// Weights of the points before and after a point, in units of the spacing; the point itself has minus their sum.
struct ThreePoint {
  double before;
  double after;
};

/// Second difference from a point and its neighbours, wherever they are. At an end of a line that is not periodic the line goes on as
/// its mirror image.
inline ThreePoint three_point_second(const Grid& grid, int direction, std::int64_t i) {
  const std::int64_t last = grid.points[static_cast<std::size_t>(direction)] - 1;
  if (!grid.has_sub_cells(direction)) {
    if (grid.periodic[static_cast<std::size_t>(direction)] || (i > 0 && i < last)) return {1.0, 1.0};
    return i == 0 ? ThreePoint{0.0, 2.0} : ThreePoint{2.0, 0.0};
  }
  const double here = grid.place(direction, i);
  if (i == 0) return {0.0, 2.0 / ((grid.place(direction, 1) - here) * (grid.place(direction, 1) - here))};
  const double a = here - grid.place(direction, i - 1);
  if (i == last) return {2.0 / (a * a), 0.0};
  const double b = grid.place(direction, i + 1) - here;
  return {2.0 / (a * (a + b)), 2.0 / (b * (a + b))};
}

/// First difference of the same kind.
inline ThreePoint three_point_first(const Grid& grid, int direction, std::int64_t i) {
  const std::int64_t last = grid.points[static_cast<std::size_t>(direction)] - 1;
  if (!grid.periodic[static_cast<std::size_t>(direction)] && (i == 0 || i == last)) return {0.0, 0.0};
  if (!grid.has_sub_cells(direction)) return {-0.5, 0.5};
  const double here = grid.place(direction, i);
  const double a = here - grid.place(direction, i - 1);
  const double b = grid.place(direction, i + 1) - here;
  return {-b / (a * (a + b)), a / (b * (a + b))};
}

}  // namespace stiffront
