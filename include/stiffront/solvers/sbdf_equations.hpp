// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <span>
#include <utility>

#include "stiffront/model/model.hpp"
#include "stiffront/solvers/plane.hpp"
#include "stiffront/solvers/sbdf_kernel.hpp"
#include "stiffront/space/diffusion_operator.hpp"

namespace stiffront {

/// What a correction on coarser grids (solvers/plane_correction.hpp) needs of one model's BDF equation
/// v = r + gamma (rates(t, v) + D Laplacian(v)) in two dimensions.
class SbdfEquations {
 public:
  virtual ~SbdfEquations() = default;
  /// out = r - v + gamma (rates(t, v) + D Laplacian(v)) at the points of the box; other points are left alone. No communication.
  /// @param sweep as for SbdfKernel; its shift is not used. @pre the field has two dimensions
  virtual void residual(const DiffusionOperator& diffusion, const SbdfSweep& sweep, const FreeBox& box) const = 0;
  /// The Jacobian of the rates at some points of v, one after the other in rows of a plane: row k of the result belongs to rows[k].
  /// @param columns, rows local indices of the points
  virtual void jacobian(const SbdfSweep& sweep, std::span<const int> columns, std::span<const int> rows, const PlaneView& result) const = 0;
};

template <Model M>
class SbdfEquationsOf final : public SbdfEquations {
 public:
  explicit SbdfEquationsOf(M model) : model_(std::move(model)) {}

  void residual(const DiffusionOperator& diffusion, const SbdfSweep& sweep, const FreeBox& box) const override {
    diffusion.dispatch([&]<int Order, int Dimension>() {
      if constexpr (Dimension == 2) residual_of<Order>(diffusion, sweep, box);
    });
  }

  void jacobian(const SbdfSweep& sweep, std::span<const int> columns, std::span<const int> rows, const PlaneView& result) const override {
    const Decomposition& d = *sweep.decomposition;
    const Grid& grid = d.grid();
    const int n_columns = static_cast<int>(columns.size());
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const Pack y(grid.position(1, d.offset_y() + rows[k]));
      for_each_pack(0, n_columns, [&](int i, int n) {
        Pack v[m];
        Pack rate[m];
        Pack entries[m][m];
        Pack x;
        for (int l = 0; l < pack_size; ++l) {
          const int column = columns[static_cast<std::size_t>(i + std::min(l, n - 1))];
          x.set(l, grid.position(0, d.offset_x() + column));
          for (int s = 0; s < m; ++s) v[s].set(l, sweep.v.row(s, rows[k])[column]);
        }
        rates_and_jacobian(model_, v, rate, entries, Place<Pack>{Pack(sweep.t), x, y});
        for (int c = 0; c < m * m; ++c) entries[c / m][c % m].store_partial(result.row(c, static_cast<int>(k)) + i, n);
      });
    }
  }

 private:
  static constexpr int m = M::n_species;

  template <int Order>
  void residual_of(const DiffusionOperator& diffusion, const SbdfSweep& sweep, const FreeBox& box) const {
    const Decomposition& d = *sweep.decomposition;
    const Pack gamma(sweep.gamma);
    const Pack anisotropy(diffusion.anisotropy());
    for (int j = box.j_begin; j < box.j_end; ++j) {
      const std::ptrdiff_t below = sweep.v.distance(j, -1);
      const std::ptrdiff_t above = sweep.v.distance(j, 1);
      const std::ptrdiff_t far_below = sweep.v.distance(j, -2);
      const std::ptrdiff_t far_above = sweep.v.distance(j, 2);
      for_each_pack(box.i_begin, box.i_end, [&](int i, int n) {
        Pack v[m];
        Pack rate[m];
        for (int s = 0; s < m; ++s) v[s] = Pack::load_partial(sweep.v.row(s, j) + i, n);
        model_.rates(v, rate, place_of_pack(d, sweep.t, i, j, n));
        for (int s = 0; s < m; ++s) {
          const double* at = sweep.v.row(s, j) + i;
          Pack change = rate[s];
          if (diffusion.coefficient(s) > 0.0) {
            Pack far_before = v[s];
            Pack far_after = v[s];
            if constexpr (Order == 4) {
              far_before = Pack::load(at + far_below);
              far_after = Pack::load(at + far_above);
            }
            const Pack along_y = second_difference<Order>(v[s], Pack::load(at + below), Pack::load(at + above), far_before, far_after);
            const Pack difference = mul_add(anisotropy, along_y, second_difference<Order>(at, 1, v[s]));
            change = mul_add(Pack(diffusion.k_x(s)), difference, change);
          }
          mul_add(gamma, change, Pack::load(sweep.r.row(s, j) + i) - v[s]).store_partial(sweep.out.row(s, j) + i, n);
        }
      });
    }
  }

  M model_;
};

}  // namespace stiffront
