// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstdint>

namespace stiffront {

/// A uniform vertex-centred grid in one or two dimensions, end points included; known to every rank in full.
///
/// A periodic direction does not repeat its end point: its spacing is (upper-lower)/points, otherwise (upper-lower)/(points-1).
struct Grid {
  int dimension = 1;                          ///< 1 or 2
  std::array<std::int64_t, 2> points{1, 1};   ///< second entry 1 in one dimension
  std::array<double, 2> lower{0.0, 0.0};
  std::array<double, 2> upper{1.0, 1.0};
  std::array<bool, 2> periodic{false, false};

  /// Number of intervals between lower and upper; 0 for the missing direction of one dimension.
  std::int64_t intervals(int direction) const {
    const auto d = static_cast<std::size_t>(direction);
    return periodic[d] ? points[d] : points[d] - 1;
  }
  double spacing(int direction) const {
    const auto d = static_cast<std::size_t>(direction);
    return (upper[d] - lower[d]) / static_cast<double>(intervals(direction));
  }
  /// Coordinate of the point with global index i; computed from i alone, so it is the same on every rank.
  double position(int direction, std::int64_t i) const {
    return lower[static_cast<std::size_t>(direction)] + static_cast<double>(i) * spacing(direction);
  }
  /// Where point i lies between lower (0) and upper (1): exact at both ends, whatever they are.
  double fraction(int direction, std::int64_t i) const {
    return static_cast<double>(i) / static_cast<double>(intervals(direction));
  }
  std::int64_t total_points() const { return points[0] * points[1]; }
};

}  // namespace stiffront
