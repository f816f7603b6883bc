// SPDX-License-Identifier: BSD-3-Clause
#include "plane_transfer.hpp"

#include <algorithm>

#include "stiffront/solvers/block_tridiagonal.hpp"

namespace stiffront {
namespace {

using block_tridiagonal::load_every_second;
using block_tridiagonal::store_in_turn;

}  // namespace

std::array<int, 2> PlaneTransfer::coarse_part(int direction) const {
  const auto d = static_cast<std::size_t>(direction);
  const std::vector<int>& centre = grid_->lines[d].centre;
  const auto first = std::lower_bound(centre.begin(), centre.end(), grid_->begin[d]);
  const auto last = std::lower_bound(centre.begin(), centre.end(), grid_->begin[d] + grid_->n[d]);
  return {static_cast<int>(first - centre.begin()), static_cast<int>(last - centre.begin())};
}

void PlaneTransfer::restrict_to(const CoarseGrid& coarse, const PlaneView& u, const PlaneView& result, int components) {
  const GridLine& along_x = grid_->x();
  const GridLine& along_y = grid_->y();
  const auto [i_first, i_last] = coarse_part(0);
  const auto [j_first, j_last] = coarse_part(1);
  const int n = grid_->n[0];
  strip_.resize(static_cast<std::size_t>(std::max(n, coarse.n[0]) + 2 + 3 * pack_size));
  // Packs where the centres are every second point: all of a coarsened line but perhaps its last point.
  int regular = i_first;
  while (regular < i_last && along_x.centre[static_cast<std::size_t>(regular)] == 2 * regular) ++regular;
  if (along_x.centre.size() == along_x.position.size()) regular = i_first;
  for (int c = 0; c < components; ++c) {
    for (int jc = j_first; jc < j_last; ++jc) {
      const auto gj = static_cast<std::size_t>(jc);
      const int j = along_y.centre[gj] - grid_->begin[1];
      const double* below = u.row(c, j - 1);
      const double* here = u.row(c, j);
      const double* above = u.row(c, j + 1);
      double* strip = strip_.data() + 1;
      const double w_b = along_y.before[gj], w_h = along_y.at[gj], w_a = along_y.after[gj];
      for (int i = -1; i <= n; ++i) strip[i] = w_h * here[i] + (w_b * below[i] + w_a * above[i]);
      double* out = result.row(c, jc - coarse.begin[1]) - coarse.begin[0];
      int ic = i_first;
      for (; ic + pack_size <= regular; ic += pack_size) {
        const auto gi = static_cast<std::size_t>(ic);
        const double* at = strip + (2 * ic - grid_->begin[0]);
        const Pack sides =
            Pack::load(&along_x.before[gi]) * load_every_second(at - 1) + Pack::load(&along_x.after[gi]) * load_every_second(at + 1);
        (Pack::load(&along_x.at[gi]) * load_every_second(at) + sides).store(out + ic);
      }
      for (; ic < i_last; ++ic) {
        const auto gi = static_cast<std::size_t>(ic);
        const double* at = strip + (along_x.centre[gi] - grid_->begin[0]);
        out[ic] = along_x.at[gi] * at[0] + (along_x.before[gi] * at[-1] + along_x.after[gi] * at[1]);
      }
    }
  }
}

void PlaneTransfer::add_from(const CoarseGrid& coarse, const PlaneView& values, const PlaneView& u, int components) {
  const GridLine& along_x = grid_->x();
  const GridLine& along_y = grid_->y();
  strip_.resize(static_cast<std::size_t>(std::max(grid_->n[0], coarse.n[0]) + 2 + 3 * pack_size));
  double* strip = strip_.data() + 1;
  const int begin = grid_->free.i_begin;
  const int end = grid_->free.i_end;
  // Pairs of points with the same left neighbour: all of a coarsened line but perhaps its last point.
  const int first_pair = begin + (begin + grid_->begin[0]) % 2;
  int regular = first_pair;
  if (along_x.centre.size() < along_x.position.size()) {
    while (regular + 2 <= end && along_x.left[static_cast<std::size_t>(regular + 1 + grid_->begin[0])] == (regular + grid_->begin[0]) / 2)
      regular += 2;
  }
  for (int c = 0; c < components; ++c) {
    for (int j = grid_->free.j_begin; j < grid_->free.j_end; ++j) {
      const auto gj = static_cast<std::size_t>(j + grid_->begin[1]);
      const int jc = along_y.left[gj] - coarse.begin[1];
      const double* lower_row = values.row(c, jc);
      const double* upper_row = values.row(c, jc + 1);
      const double w_l = along_y.by_left[gj], w_u = along_y.by_right[gj];
      for (int i = -1; i <= coarse.n[0]; ++i) strip[i] = w_l * lower_row[i] + w_u * upper_row[i];
      double* out = u.row(c, j);
      const auto one = [&](int i) {
        const auto gi = static_cast<std::size_t>(i + grid_->begin[0]);
        const double* at = strip + (along_x.left[gi] - coarse.begin[0]);
        out[i] += along_x.by_left[gi] * at[0] + along_x.by_right[gi] * at[1];
      };
      int i = begin;
      for (; i < first_pair && i < end; ++i) one(i);
      for (; i + 2 * pack_size <= regular; i += 2 * pack_size) {
        const auto gi = static_cast<std::size_t>(i + grid_->begin[0]);
        const double* at = strip + ((i + grid_->begin[0]) / 2 - coarse.begin[0]);
        double left[2 * pack_size];
        double right[2 * pack_size];
        store_in_turn(Pack::load(at), Pack::load(at), left);
        store_in_turn(Pack::load(at + 1), Pack::load(at + 1), right);
        for (int p = 0; p < 2 * pack_size; p += pack_size) {
          const auto g = gi + static_cast<std::size_t>(p);
          const Pack sum =
              Pack::load(&along_x.by_left[g]) * Pack::load(left + p) + Pack::load(&along_x.by_right[g]) * Pack::load(right + p);
          (Pack::load(out + i + p) + sum).store(out + i + p);
        }
      }
      for (; i < end; ++i) one(i);
    }
  }
}

}  // namespace stiffront
