// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>

#include "stiffront/mesh/boundary.hpp"
#include "stiffront/mesh/rows.hpp"

namespace stiffront {

/// What a stencil reads beyond the sides of the domain, made for the rows that come next instead of for a whole field: a wavefront
/// (mesh/wavefront.hpp) has them in cache then. The values are those of HaloExchange and Boundary. Halos next to other ranks are left alone.
class RowHalo {
 public:
  /// @param width of the stencil
  /// @pre decomposition and boundary outlive the object; no sub-cells
  RowHalo(const Decomposition& decomposition, const Boundary& boundary, int width);

  /// Before a stencil is applied to u at the points of the box: what it reads beyond the ends of the rows.
  void fill_ends(const Rows& u, int species, const FreeBox& box) const;
  /// And beyond the first and last row of the rank's box.
  void fill_rows(const Rows& u, int species, const FreeBox& box) const;
  void fill(const Rows& u, int species, const FreeBox& box) const {
    fill_ends(u, species, box);
    fill_rows(u, species, box);
  }
  /// Before that where there are Dirichlet sides: the points of theirs that come into reach with the box take their values at time t.
  void impose(const Rows& u, int species, const FreeBox& box, double t) const;

  /// Whether a periodic direction is this rank's alone, so that its halo is made here.
  bool wraps(int direction) const { return sides_[static_cast<std::size_t>(direction)][0] == Side::wrapped; }

 private:
  enum class Side { others, wrapped, mirrored, extrapolated };
  static BoundaryKind kind_of(Side side) { return side == Side::mirrored ? BoundaryKind::neumann : BoundaryKind::dirichlet; }

  const Decomposition* decomposition_;
  const Boundary* boundary_;
  int width_;
  bool in_plane_;
  std::array<std::array<Side, 2>, 2> sides_{};
};

}  // namespace stiffront
