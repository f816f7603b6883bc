// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/mesh/row_halo.hpp"

#include <algorithm>
#include <cstring>

namespace stiffront {

RowHalo::RowHalo(const Decomposition& d, const Boundary& boundary, int width)
    : decomposition_(&d), boundary_(&boundary), width_(width), in_plane_(d.grid().dimension == 2) {
  for (int direction = 0; direction < d.grid().dimension; ++direction) {
    const auto k = static_cast<std::size_t>(direction);
    for (std::size_t which = 0; which < 2; ++which) {
      const int dx = direction == 0 ? (which == 0 ? -1 : 1) : 0;
      const int dy = direction == 1 ? (which == 0 ? -1 : 1) : 0;
      if (d.at_boundary(direction, static_cast<int>(which))) {
        sides_[k][which] =
            boundary.side(direction, static_cast<int>(which)).kind == BoundaryKind::dirichlet ? Side::extrapolated : Side::mirrored;
      } else {
        sides_[k][which] = d.neighbour(dx, dy) == d.comm().rank() ? Side::wrapped : Side::others;
      }
    }
  }
}

void RowHalo::fill_ends(const Rows& u, int s, const FreeBox& box) const {
  const int w = width_;
  const int n_x = decomposition_->n_x();
  for (std::size_t which = 0; which < 2; ++which) {
    const Side side = sides_[0][which];
    if (side == Side::others || (which == 0 ? box.i_begin >= w : box.i_end <= n_x - w)) continue;
    for (int j = box.j_begin; j < box.j_end; ++j) {
      double* const row = u.row(s, j);
      if (side == Side::wrapped) {
        for (int k = 1; k <= w; ++k) (which == 0 ? row[-k] : row[n_x - 1 + k]) = which == 0 ? row[n_x - k] : row[k - 1];
      } else {
        continue_line(which == 0 ? row : row + n_x - 1, which == 0 ? 1 : -1, w, kind_of(side));
      }
    }
  }
}

void RowHalo::fill_rows(const Rows& u, int s, const FreeBox& box) const {
  if (!in_plane_) return;
  const int w = width_;
  const int n_y = decomposition_->n_y();
  for (std::size_t which = 0; which < 2; ++which) {
    const Side side = sides_[1][which];
    if (side == Side::others || (which == 0 ? box.j_begin >= w : box.j_end <= n_y - w)) continue;
    if (side != Side::wrapped) {
      continue_rows(u, s, which == 0 ? 0 : n_y - 1, which == 0 ? 1 : -1, w, kind_of(side), box.i_begin, box.i_end);
      continue;
    }
    for (int k = 1; k <= w; ++k) {
      const int to = which == 0 ? -k : n_y - 1 + k;
      const int from = which == 0 ? n_y - k : k - 1;
      std::memcpy(u.row(s, to) + box.i_begin, u.row(s, from) + box.i_begin,
                  static_cast<std::size_t>(box.i_end - box.i_begin) * sizeof(double));
    }
  }
}

void RowHalo::impose(const Rows& u, int s, const FreeBox& box, double t) const {
  // Behind the box, a point is all that its first points need; what lies further back may have been written over.
  const auto begin = [](int first) { return first > 0 ? first - 1 : first; };
  const auto end = [this](int stop, int n) { return stop < n ? std::min(stop + width_, n) : stop; };
  const Decomposition& d = *decomposition_;
  boundary_->impose(u, d, s, t, {begin(box.i_begin), end(box.i_end, d.n_x()), begin(box.j_begin), end(box.j_end, d.n_y())});
}

}  // namespace stiffront
