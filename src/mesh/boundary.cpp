// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/mesh/boundary.hpp"

#include <algorithm>
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

/// The cubic through four points at their left; by differences, so that constants are continued exactly.
double extrapolated(double p0, double p1, double p2, double p3) {
  const double d0 = p0 - p1;
  const double d1 = p1 - p2;
  const double d2 = p2 - p3;
  return p0 + (3.0 * (d0 - d1) + d2);
}

}  // namespace

void continue_line(double* end, std::ptrdiff_t in, int width, BoundaryKind kind) {
  if (kind == BoundaryKind::neumann) {
    for (int k = 1; k <= width; ++k) end[-k * in] = end[k * in];
    return;
  }
  // A second-order stencil never looks beyond a Dirichlet point; wider halos continue the extrapolation.
  if (kind != BoundaryKind::dirichlet || width < 2) return;
  for (int k = 1; k <= width; ++k) {
    const double* p = end - (k - 1) * in;
    end[-k * in] = extrapolated(p[0], p[in], p[2 * in], p[3 * in]);
  }
}

void continue_rows(const Rows& u, int species, int end, int in, int width, BoundaryKind kind, int i_begin, int i_end) {
  for (int k = 1; k <= width; ++k) {
    double* const out = u.row(species, end - k * in);
    if (kind == BoundaryKind::neumann) {
      std::copy(u.row(species, end + k * in) + i_begin, u.row(species, end + k * in) + i_end, out + i_begin);
    } else if (kind == BoundaryKind::dirichlet && width > 1) {
      const double* p[4];
      for (int l = 0; l < 4; ++l) p[l] = u.row(species, end + (l + 1 - k) * in);
      for (int i = i_begin; i < i_end; ++i) out[i] = extrapolated(p[0][i], p[1][i], p[2][i], p[3][i]);
    }
  }
}

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
        continue_line(which == 0 ? row : row + u.n_x() - 1, which == 0 ? 1 : -1, width, side(0, which).kind);
      }
    }
    if (d.grid().dimension == 1) continue;
    for (int which = 0; which < 2; ++which) {
      if (!d.at_boundary(1, which) || d.grid().sub_cell[1][static_cast<std::size_t>(which)]) continue;
      continue_rows(rows_of(u), s, which == 0 ? 0 : u.n_y() - 1, which == 0 ? 1 : -1, width, side(1, which).kind, i_begin, i_end);
    }
  }
}

void Boundary::impose(Field& u, double t, int reach) const {
  if (!has_dirichlet_) return;
  const Decomposition& d = u.decomposition();
  const auto beyond = [&](int direction, int which) { return d.at_boundary(direction, which) ? 0 : reach; };
  const bool in_plane = d.grid().dimension == 2;
  const FreeBox points{-beyond(0, 0), u.n_x() + beyond(0, 1), in_plane ? -beyond(1, 0) : 0, u.n_y() + (in_plane ? beyond(1, 1) : 0)};
  for (int s = 0; s < u.n_species(); ++s) impose(rows_of(u), d, s, t, points);
}

void Boundary::impose(const Rows& u, const Decomposition& d, int species, double t, const FreeBox& points) const {
  const Grid& grid = d.grid();
  const auto s = static_cast<std::size_t>(species);
  // A neighbour's points may lie at the other end of a periodic direction.
  const auto position = [&](int direction, std::int64_t index) {
    const std::int64_t n = grid.points[static_cast<std::size_t>(direction)];
    return grid.position(direction, index < 0 ? index + n : (index >= n ? index - n : index));
  };
  for (int which = 0; which < 2 && grid.dimension == 2; ++which) {
    const BoundarySide& b = side(1, which);
    const int j = which == 0 ? 0 : d.n_y() - 1;
    if (b.kind != BoundaryKind::dirichlet || !d.at_boundary(1, which) || j < points.j_begin || j >= points.j_end) continue;
    const double y = grid.position(1, d.offset_y() + j);
    double* const row = u.row(species, j);
    for (int i = points.i_begin; i < points.i_end; ++i) row[i] = b.values[s](t, position(0, d.offset_x() + i), y);
  }
  for (int which = 0; which < 2; ++which) {
    const BoundarySide& b = side(0, which);
    const int i = which == 0 ? 0 : d.n_x() - 1;
    if (b.kind != BoundaryKind::dirichlet || !d.at_boundary(0, which) || i < points.i_begin || i >= points.i_end) continue;
    const double x = grid.position(0, d.offset_x() + i);
    for (int j = points.j_begin; j < points.j_end; ++j) {
      u.row(species, j)[i] = b.values[s](t, x, grid.dimension == 2 ? position(1, d.offset_y() + j) : 0.0);
    }
  }
}

}  // namespace stiffront
