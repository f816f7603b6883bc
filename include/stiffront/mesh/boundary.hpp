// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <functional>
#include <span>
#include <vector>

#include "stiffront/mesh/field.hpp"
#include "stiffront/mesh/rows.hpp"

namespace stiffront {

enum class BoundaryKind { neumann, periodic, dirichlet };

/// Value of a species on a Dirichlet side at time t and place (x, y).
using BoundaryValue = std::function<double(double t, double x, double y)>;

/// One side of the domain.
struct BoundarySide {
  BoundaryKind kind = BoundaryKind::neumann;
  std::vector<BoundaryValue> values;  ///< one per species, Dirichlet only
  bool depends_on_time = false;
};

/// The points of a box that evolve: Dirichlet points are outside.
struct FreeBox {
  int i_begin, i_end;  ///< local x indices
  int j_begin, j_end;  ///< local y indices
};

/// What happens at the sides of the domain: homogeneous Neumann by mirroring about the end point, periodic by the halo exchange,
/// Dirichlet by fixing the end point.
///
/// Mirroring is exact to any order where the solution continues evenly: its third derivative vanishes at a Neumann side too if the
/// rates depend on u alone. Rates that vary with the normal coordinate there reduce a fourth-order scheme to order two.
///
/// Halo points beyond a Dirichlet side are extrapolated from the four outermost points by a cubic,
/// u(-1) = 4 u(0) - 6 u(1) + 4 u(2) - u(3). A second-order stencil never uses them; in a fourth-order stencil they make the row next
/// to the boundary the second-order one, which keeps the eigenvalues real, the spectral radius below that of the interior and the
/// global order at four (one row of lower order costs nothing; Gustafsson, Math. Comp. 29, 1975).
class Boundary {
 public:
  /// sides[direction][0 lower | 1 upper].
  explicit Boundary(std::array<std::array<BoundarySide, 2>, 2> sides);
  /// Neumann, or periodic where the grid is.
  static Boundary natural(const Grid& grid);

  const BoundarySide& side(int direction, int which) const {
    return sides_[static_cast<std::size_t>(direction)][static_cast<std::size_t>(which)];
  }
  bool has_dirichlet() const { return has_dirichlet_; }
  bool depends_on_time() const { return depends_on_time_; }

  /// The evolving points of this rank's box.
  FreeBox free_box(const Decomposition& d) const;
  /// The number of evolving points of the whole grid.
  std::int64_t free_points(const Grid& grid) const;

  /// Fills `width` points of the halo of the given species beyond physical sides; halos from neighbours must be there already. Where the grid has a
  /// sub-cell nobody looks beyond the side. Along a side this includes `reach` points of the halos of neighbours.
  void fill_halo(Field& u, int width, std::span<const int> species, int reach) const;
  void fill_halo(Field& u, int width, std::span<const int> species) const { fill_halo(u, width, species, width); }
  /// Sets Dirichlet points to their values at time t. A point of two Dirichlet sides takes the x side's value. Along a side this includes
  /// `reach` points of the halos of neighbours.
  void impose(Field& u, double t, int reach = 0) const;
  /// The same for one species at the points of a box, which may reach into halos.
  void impose(const Rows& u, const Decomposition& d, int species, double t, const FreeBox& points) const;

 private:
  std::array<std::array<BoundarySide, 2>, 2> sides_;
  bool has_dirichlet_ = false;
  bool depends_on_time_ = false;
};

/// Continues a line of points beyond its end by `width` points: `end` is the last point, the others follow inwards at the stride `in`.
/// Beyond a Dirichlet point nothing is read by a stencil of width 1, and nothing is done for it.
void continue_line(double* end, std::ptrdiff_t in, int width, BoundaryKind kind);
/// The same for the points i_begin .. i_end - 1 of rows; in is 1 or -1.
void continue_rows(const Rows& u, int species, int end, int in, int width, BoundaryKind kind, int i_begin, int i_end);

}  // namespace stiffront
