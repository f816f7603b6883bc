// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>

#include "stiffront/mesh/decomposition.hpp"

namespace stiffront {

/// Differences of order eight next to a Dirichlet side, in units of the spacing.
///
/// One-sided differences of this order are unstable on a uniform grid. One additional point a fifth of a spacing from the side,
/// an unknown like all others, makes them stable: the second difference gets a real negative spectrum and the first one, with values
/// given at the inflow, a spectrum in the left half-plane. The points from the side inwards are x_0 (given), the sub-cell, x_1, x_2 ...;
/// the sub-cell and x_1, x_2, x_3 take the weights of all ten outermost points, and x_4 the centred formula, which skips the sub-cell.
/// From x_5 on nothing is different from the interior.
///
/// @see Hagstrom & Hagstrom, Grid stabilization of high-order one-sided differencing, J. Comput. Phys. 223, 2007; as used by Hagstrom & Zhou,
///      Commun. Appl. Math. Comput. Sci. 1(1), 2006, section 6
struct SubCellClosure {
  static constexpr int rows = 5;      ///< of the points 1 .. 5, counted from the side, x_0 being 0
  static constexpr int columns = 10;  ///< weights of the points 0 .. 9
  using Weights = std::array<std::array<double, columns>, rows>;

  Weights first;   ///< of du/dx at a lower side; at an upper side they change their sign
  Weights second;  ///< of d2u/dx2

  /// The one there is.
  static const SubCellClosure& get();
};

/// The difference at the point `row` (1 .. 5) counted from a side, where load(k) is the value at point k. By
/// differences, so that constants give zero, and from the side inwards, so that both sides give mirrored bits.
template <class Value, class Load>
Value closed_difference(const SubCellClosure::Weights& weights, int row, Load&& load) {
  const auto& w = weights[static_cast<std::size_t>(row - 1)];
  const Value centre = load(row);
  Value sum(0.0);
  for (int k = 0; k < SubCellClosure::columns; ++k) {
    const double weight = w[static_cast<std::size_t>(k)];
    if (k != row && weight != 0.0) sum = sum + Value(weight) * (load(k) - centre);
  }
  return sum;
}

/// Which ends of this rank's part of a line are sides with a sub-cell.
struct ClosedEnds {
  bool lower;
  bool upper;

  ClosedEnds(const Decomposition& d, int direction)
      : lower(d.at_boundary(direction, 0) && d.grid().sub_cell[static_cast<std::size_t>(direction)][0]),
        upper(d.at_boundary(direction, 1) && d.grid().sub_cell[static_cast<std::size_t>(direction)][1]) {}

  /// Of point i of n: its number counted from such a side, if it takes the closure's weights; otherwise 0.
  int row_from_lower(int i) const { return lower && i >= 1 && i <= SubCellClosure::rows ? i : 0; }
  int row_from_upper(int i, int n) const { return upper && i <= n - 2 && i >= n - 1 - SubCellClosure::rows ? n - 1 - i : 0; }

  /// Calls f(i, row, first, inwards) for the points of begin .. end - 1 (of n) with weights of the closure: their row, the point of
  /// the side and the step inwards.
  template <class F>
  void for_each(int begin, int end, int n, F&& f) const {
    if (lower) {
      for (int i = std::max(begin, 1); i < std::min(end, 1 + SubCellClosure::rows); ++i) f(i, i, 0, 1);
    }
    if (upper) {
      for (int i = std::max(begin, n - 1 - SubCellClosure::rows); i < std::min(end, n - 1); ++i) f(i, n - 1 - i, n - 1, -1);
    }
  }
};

}  // namespace stiffront
