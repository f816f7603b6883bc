// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/mesh/boundary.hpp"

#include <utility>

namespace stiffront {

Boundary::Boundary(std::array<std::array<BoundarySide, 2>, 2> sides) : sides_(std::move(sides)) {
  for (const auto& direction : sides_) {
    for (const BoundarySide& s : direction) {
      has_dirichlet_ = has_dirichlet_ || s.kind == BoundaryKind::dirichlet;
      depends_on_time_ = depends_on_time_ || (s.kind == BoundaryKind::dirichlet && s.depends_on_time);
    }
  }
}

Boundary Boundary::natural(const Grid& grid) {
  std::array<std::array<BoundarySide, 2>, 2> sides;
  for (std::size_t d = 0; d < 2; ++d) {
    for (BoundarySide& s : sides[d]) s.kind = grid.periodic[d] ? BoundaryKind::periodic : BoundaryKind::neumann;
  }
  return Boundary(std::move(sides));
}

FreeBox Boundary::free_box(const Decomposition& d) const {
  const auto fixed = [&](int direction, int which) {
    return d.at_boundary(direction, which) && side(direction, which).kind == BoundaryKind::dirichlet ? 1 : 0;
  };
  FreeBox box{fixed(0, 0), d.n_x() - fixed(0, 1), 0, d.n_y()};
  if (d.grid().dimension == 2) {
    box.j_begin = fixed(1, 0);
    box.j_end = d.n_y() - fixed(1, 1);
  }
  return box;
}

std::int64_t Boundary::free_points(const Grid& grid) const {
  std::int64_t product = 1;
  for (int d = 0; d < grid.dimension; ++d) {
    std::int64_t n = grid.points[static_cast<std::size_t>(d)];
    for (int which = 0; which < 2; ++which) n -= side(d, which).kind == BoundaryKind::dirichlet ? 1 : 0;
    product *= n;
  }
  return product;
}

namespace {

/// Fills `width` points beyond the end of a line of points that starts at `end` and goes inwards with stride `in`.
void fill_line(double* end, std::ptrdiff_t in, int width, BoundaryKind kind) {
  if (kind == BoundaryKind::neumann) {
    for (int k = 1; k <= width; ++k) end[-k * in] = end[k * in];
    return;
  }
  // A second-order stencil never looks beyond a Dirichlet point; wider halos continue the extrapolation.
  if (kind != BoundaryKind::dirichlet || width < 2) return;
  for (int k = 1; k <= width; ++k) {
    const double* p = end - (k - 1) * in;
    // By differences, so that constants are continued exactly.
    const double d0 = p[0] - p[in];
    const double d1 = p[in] - p[2 * in];
    const double d2 = p[2 * in] - p[3 * in];
    end[-k * in] = p[0] + (3.0 * (d0 - d1) + d2);
  }
}

}  // namespace

void Boundary::fill_halo(Field& u, int width, std::span<const int> species, int reach) const {
  const Decomposition& d = u.decomposition();
  // Beyond a physical side nothing but what this function puts there.
  const auto beyond = [&](int direction, int which) { return d.at_boundary(direction, which) ? width : reach; };
  const bool in_plane = d.grid().dimension == 2;
  const int i_begin = -beyond(0, 0);
  const int i_end = u.n_x() + beyond(0, 1);
  const int j_begin = in_plane ? -beyond(1, 0) : 0;
  const int j_end = u.n_y() + (in_plane ? beyond(1, 1) : 0);
  for (int s : species) {
    for (int which = 0; which < 2; ++which) {
      if (!d.at_boundary(0, which) || d.grid().sub_cell[0][static_cast<std::size_t>(which)]) continue;
      for (int j = j_begin; j < j_end; ++j) {
        double* row = u.row(s, j);
        fill_line(which == 0 ? row : row + u.n_x() - 1, which == 0 ? 1 : -1, width, side(0, which).kind);
      }
    }
    if (d.grid().dimension == 1) continue;
    for (int which = 0; which < 2; ++which) {
      if (!d.at_boundary(1, which) || d.grid().sub_cell[1][static_cast<std::size_t>(which)]) continue;
      double* end = u.row(s, which == 0 ? 0 : u.n_y() - 1);
      const std::ptrdiff_t in = which == 0 ? u.row_stride() : -u.row_stride();
      for (int i = i_begin; i < i_end; ++i) fill_line(end + i, in, width, side(1, which).kind);
    }
  }
}

void Boundary::impose(Field& u, double t, int reach) const {
  if (!has_dirichlet_) return;
  const Decomposition& d = u.decomposition();
  const Grid& grid = d.grid();
  const auto beyond = [&](int direction, int which) { return d.at_boundary(direction, which) ? 0 : reach; };
  // A neighbour's points may lie at the other end of a periodic direction.
  const auto position = [&](int direction, std::int64_t index) {
    const std::int64_t n = grid.points[static_cast<std::size_t>(direction)];
    return grid.position(direction, index < 0 ? index + n : (index >= n ? index - n : index));
  };
  for (int s = 0; s < u.n_species(); ++s) {
    const auto species = static_cast<std::size_t>(s);
    for (int which = 0; which < 2 && grid.dimension == 2; ++which) {
      const BoundarySide& b = side(1, which);
      if (b.kind != BoundaryKind::dirichlet || !d.at_boundary(1, which)) continue;
      const int j = which == 0 ? 0 : u.n_y() - 1;
      const double y = grid.position(1, d.offset_y() + j);
      for (int i = -beyond(0, 0); i < u.n_x() + beyond(0, 1); ++i) u.at(s, i, j) = b.values[species](t, position(0, d.offset_x() + i), y);
    }
    for (int which = 0; which < 2; ++which) {
      const BoundarySide& b = side(0, which);
      if (b.kind != BoundaryKind::dirichlet || !d.at_boundary(0, which)) continue;
      const int i = which == 0 ? 0 : u.n_x() - 1;
      const double x = grid.position(0, d.offset_x() + i);
      const bool in_plane = grid.dimension == 2;
      for (int j = in_plane ? -beyond(1, 0) : 0; j < u.n_y() + (in_plane ? beyond(1, 1) : 0); ++j) {
        u.at(s, i, j) = b.values[species](t, x, in_plane ? position(1, d.offset_y() + j) : 0.0);
      }
    }
  }
}

}  // namespace stiffront
