// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "plane_transfer.hpp"
#include "stiffront/solvers/cell_solve.hpp"
#include "stiffront/solvers/coarse_grids.hpp"

namespace stiffront {

/// One grid of the hierarchy with what lives on it: the matrix A = 1 - h J - h gamma D Laplacian, the inverses of its cell blocks.
template <int m>
class PlaneLevel {
 public:
  /// @param jacobian of the finest level; null: an own one
  PlaneLevel(const Decomposition& decomposition, const CoarseGrid& grid, const PlaneView* jacobian)
      : grid_(&grid),
        x(m, grid.n[0], grid.n[1]),
        b(m, grid.n[0], grid.n[1]),
        r(m, grid.n[0], grid.n[1]),
        own_jacobian_(jacobian == nullptr ? std::optional<Plane>(std::in_place, m * m, grid.n[0], grid.n[1]) : std::nullopt),
        inverse_(m * m, grid.n[0], grid.n[1]),
        jacobian_(own_jacobian_ ? static_cast<PlaneView>(*own_jacobian_) : *jacobian),
        halo_(decomposition, grid, m * m),
        gather_(decomposition.comm(), grid, m * m),
        transfer_(grid) {
    const auto part = [&](const std::vector<double>& whole, std::size_t d) {
      const auto first = whole.begin() + grid.begin[d];
      std::vector<double> mine(first, first + grid.n[d]);
      mine.resize(mine.size() + pack_size, 0.0);
      return mine;
    };
    lower_x_ = part(grid.x().lower, 0);
    upper_x_ = part(grid.x().upper, 0);
    lower_y_ = part(grid.y().lower, 1);
    upper_y_ = part(grid.y().upper, 1);
  }

  const CoarseGrid& grid() const { return *grid_; }
  PlaneView jacobian() const { return jacobian_; }
  void exchange(const PlaneView& u, int components) { halo_.exchange(u, components); }
  void gather(const PlaneView& u, int components) { gather_.gather(u, components); }

  /// @param k h gamma D / distance^2 of the finest grid, per direction and species
  void set_matrix(double h, const double (&k_x)[m], const double (&k_y)[m]) {
    h_ = h;
    for (int s = 0; s < m; ++s) k_x_[s] = k_x[s], k_y_[s] = k_y[s];
    for_cells([&](int i, int j, int n) {
      Pack inverse[m][m];
      const auto inverted = [&](auto lu) {
        for (int p = 0; p < m; ++p) {
          for (int q = 0; q < m; ++q) {
            const Pack unit = p == q ? Pack(1.0) + diagonal(p, i, j) : Pack(0.0);
            lu(p, q) = neg_mul_add(Pack(h), Pack::load(jacobian_.row(p * m + q, j) + i), unit);
          }
        }
        const bool good = lu.factor();
        for (int q = 0; q < m; ++q) {
          Pack unit[m];
          for (int p = 0; p < m; ++p) unit[p] = Pack(p == q ? 1.0 : 0.0);
          lu.solve(unit);
          for (int p = 0; p < m; ++p) inverse[p][q] = unit[p];
        }
        return good;
      };
      if (!inverted(CellLu<Pack, m, false>())) inverted(CellLu<Pack, m, true>());
      for (int c = 0; c < m * m; ++c) inverse[c / m][c % m].store_partial(inverse_.row(c, j) + i, n);
    });
  }

  /// The largest coupling of a cell to one neighbour.
  double coupling() const {
    double largest = 0.0;
    for (int s = 0; s < m; ++s) {
      largest = std::max(largest, std::max(k_x_[s] * grid_->x().coupling(), k_y_[s] * grid_->y().coupling()));
    }
    return largest;
  }

  /// result = A u at the unknowns. @pre the halo of u is up to date
  void apply(const PlaneView& u, const PlaneView& result) const {
    for_cells([&](int i, int j, int n) {
      Pack au[m];
      multiply(u, i, j, au);
      for (int s = 0; s < m; ++s) au[s].store_partial(result.row(s, j) + i, n);
    });
  }
  /// result = b - A u.
  void residual(const PlaneView& right, const PlaneView& u, const PlaneView& result) const {
    for_cells([&](int i, int j, int n) {
      Pack au[m];
      multiply(u, i, j, au);
      for (int s = 0; s < m; ++s) (Pack::load(right.row(s, j) + i) - au[s]).store_partial(result.row(s, j) + i, n);
    });
  }
  /// x = weight / (cell blocks) b.
  void begin(double weight) {
    for_cells([&](int i, int j, int n) {
      Pack right[m];
      for (int s = 0; s < m; ++s) right[s] = Pack::load(b.row(s, j) + i);
      Pack change[m];
      divide(right, i, j, change);
      for (int s = 0; s < m; ++s) (Pack(weight) * change[s]).store_partial(x.row(s, j) + i, n);
    });
  }
  /// x += weight / (cell blocks) (b - A x).
  void smooth(double weight) {
    exchange(x, m);
    for_cells([&](int i, int j, int n) {
      Pack au[m];
      multiply(x, i, j, au);
      for (int s = 0; s < m; ++s) au[s] = Pack::load(b.row(s, j) + i) - au[s];
      Pack change[m];
      divide(au, i, j, change);
      for (int s = 0; s < m; ++s) mul_add(Pack(weight), change[s], Pack::load(x.row(s, j) + i)).store_partial(r.row(s, j) + i, n);
    });
    std::swap(x, r);
  }

  /// coarse = means of u. @pre the halo of u is up to date, corners too
  void restrict_to(const PlaneLevel& coarse, const PlaneView& u, const PlaneView& result, int components) {
    transfer_.restrict_to(coarse.grid(), u, result, components);
  }
  /// x += interpolated x of the coarser level. @pre its halo is up to date, corners too
  void add_from(const PlaneLevel& coarse) { transfer_.add_from(coarse.grid(), coarse.x, x, m); }

  template <class F>
  void for_cells(F&& f) const {
    for (int j = grid_->free.j_begin; j < grid_->free.j_end; ++j) {
      for_each_pack(grid_->free.i_begin, grid_->free.i_end, [&](int i, int n) { f(i, j, n); });
    }
  }

 private:
  /// What the Laplacian has on the diagonal.
  Pack diagonal(int s, int i, int j) const {
    const auto gi = static_cast<std::size_t>(i);
    const auto gj = static_cast<std::size_t>(j);
    return mul_add(Pack(k_x_[s]), Pack::load(&lower_x_[gi]) + Pack::load(&upper_x_[gi]), Pack(k_y_[s] * (lower_y_[gj] + upper_y_[gj])));
  }
  void multiply(const PlaneView& u, int i, int j, Pack (&result)[m]) const {
    const auto gi = static_cast<std::size_t>(i);
    const auto gj = static_cast<std::size_t>(j);
    const Pack lower = Pack::load(&lower_x_[gi]), upper = Pack::load(&upper_x_[gi]);
    const Pack below(lower_y_[gj]), above(upper_y_[gj]);
    Pack v[m];
    for (int s = 0; s < m; ++s) v[s] = Pack::load(u.row(s, j) + i);
    for (int s = 0; s < m; ++s) {
      const double* at = u.row(s, j) + i;
      Pack sum = v[s];
      for (int q = 0; q < m; ++q) sum = neg_mul_add(Pack(h_) * v[q], Pack::load(jacobian_.row(s * m + q, j) + i), sum);
      // Differences of neighbours: a constant is in the null space to the last bit.
      const Pack along_x = lower * (v[s] - Pack::load(at - 1)) + upper * (v[s] - Pack::load(at + 1));
      const Pack along_y = below * (v[s] - Pack::load(at - u.row_stride)) + above * (v[s] - Pack::load(at + u.row_stride));
      sum = mul_add(Pack(k_x_[s]), along_x, sum);
      result[s] = mul_add(Pack(k_y_[s]), along_y, sum);
    }
  }
  void divide(const Pack (&right)[m], int i, int j, Pack (&result)[m]) const {
    for (int p = 0; p < m; ++p) {
      Pack sum = Pack::load(inverse_.row(p * m, j) + i) * right[0];
      for (int q = 1; q < m; ++q) sum = mul_add(Pack::load(inverse_.row(p * m + q, j) + i), right[q], sum);
      result[p] = sum;
    }
  }

  const CoarseGrid* grid_;

 public:
  Plane x, b, r;  ///< solution, right side, residual or next solution

 private:
  std::optional<Plane> own_jacobian_;
  Plane inverse_;
  PlaneView jacobian_;
  PlaneExchange halo_;
  PlaneGather gather_;
  std::vector<double> lower_x_, upper_x_, lower_y_, upper_y_;  // of this rank, zeros beyond
  PlaneTransfer transfer_;
  double h_ = 0.0;
  double k_x_[m] = {};
  double k_y_[m] = {};
};

}  // namespace stiffront
