// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <array>
#include <utility>

#include "stiffront/core/sparse_dual.hpp"
#include "stiffront/mesh/boundary.hpp"
#include "stiffront/mesh/rows.hpp"
#include "stiffront/model/model.hpp"
#include "stiffront/solvers/sparse_cell_solve.hpp"
#include "stiffront/space/diffusion_operator.hpp"

namespace stiffront {

/// The most nodes of a step whose nodes are swept together.
inline constexpr int max_parallel_nodes = 8;

/// One sweep of all nodes of a step from t to t + dt towards collocation, v_i = u + dt sum_a s_ia F(v_a) with F(v) = rates(t + c_a dt, v) +
/// D Laplacian(v). In every cell and for every node by itself
///
///     (1 - dt d_i J_i + dt d_i g rho/2) delta_i = u + dt sum_a s_ia F(v_a) - v_i,    out_i = v_i + delta_i,
///
/// with the reaction Jacobian J_i of the cell at v_i and rho, for each species, the spectral radius of its diffusion.
struct NodeSweep {
  double t = 0.0;
  double dt = 0.0;
  double shift = 0.0;  ///< g
  int nodes = 0;
  std::array<double, max_parallel_nodes> c{};         ///< nodes
  std::array<double, max_parallel_nodes> diagonal{};  ///< d
  std::array<std::array<double, max_parallel_nodes>, max_parallel_nodes> s{};
  const Decomposition* decomposition = nullptr;
  ConstRows u;
  std::array<ConstRows, max_parallel_nodes> v;  ///< halos up to date
  std::array<Rows, max_parallel_nodes> out;     ///< distinct from all v
};

/// The sweeps of one model's equations.
class NodeSweepKernel {
 public:
  virtual ~NodeSweepKernel() = default;
  /// Makes a sweep at the points of the box; other points of `out` are left alone. No communication.
  virtual void sweep(const DiffusionOperator& diffusion, const NodeSweep& sweep, const FreeBox& box) const = 0;
};

template <Model M>
class NodeSweepKernelOf final : public NodeSweepKernel {
 public:
  explicit NodeSweepKernelOf(M model) : model_(std::move(model)) {}

  void sweep(const DiffusionOperator& diffusion, const NodeSweep& sweep, const FreeBox& box) const override {
    diffusion.dispatch([&]<int Order, int Dimension>() { rows<Order, Dimension>(diffusion, sweep, box); });
  }

 private:
  static constexpr int m = M::n_species;

  /// A row of cells at all nodes.
  struct Row {
    const double* u[m];
    const double* v[max_parallel_nodes][m];
    double* out[max_parallel_nodes][m];
    std::ptrdiff_t below, above, far_below, far_above;  ///< from the row to rows -1, 1, -2, 2 of v
    double first;                                       ///< global index of the first point
    Pack lane;                                          ///< offsets of the cells of a pack from its first
    double y;
  };

  template <int Order, int Dimension>
  void rows(const DiffusionOperator& diffusion, const NodeSweep& sweep, const FreeBox& box) const {
    const Decomposition& d = *sweep.decomposition;
    const std::int64_t n_rows = d.grid().points[1];
    const int n = box.i_end - box.i_begin;
    for (int j = box.j_begin; j < box.j_end && n > 0; ++j) {
      Row row;
      for (int s = 0; s < m; ++s) row.u[s] = sweep.u.row(s, j) + box.i_begin;
      for (int a = 0; a < sweep.nodes; ++a) {
        const auto k = static_cast<std::size_t>(a);
        for (int s = 0; s < m; ++s) {
          row.v[a][s] = sweep.v[k].row(s, j) + box.i_begin;
          row.out[a][s] = sweep.out[k].row(s, j) + box.i_begin;
        }
      }
      row.below = sweep.v[0].distance(j, -1);
      row.above = sweep.v[0].distance(j, 1);
      row.far_below = sweep.v[0].distance(j, -2);
      row.far_above = sweep.v[0].distance(j, 2);
      row.first = static_cast<double>(d.offset_x() + box.i_begin);
      for (int l = 0; l < pack_size; ++l) row.lane.set(l, std::min(l, n - 1));
      row.y = Dimension == 2 ? d.grid().position(1, (d.offset_y() + j + n_rows) % n_rows) : 0.0;
      if (n >= pack_size) {
        cells<Order, Dimension>(diffusion, sweep, row, n);
      } else {
        short_row<Order, Dimension>(diffusion, sweep, row, n);
      }
    }
  }

  /// Makes a row of fewer cells than a pack holds a full one. The other lanes hold the halo's last value, or the last cell's where nothing
  /// diffuses and the halo is not kept, so that no rate is evaluated at made-up states.
  template <int Order, int Dimension>
  void short_row(const DiffusionOperator& diffusion, const NodeSweep& sweep, Row row, int n) const {
    constexpr int w = Order / 2;
    constexpr int w_y = Dimension == 2 ? w : 0;
    constexpr int length = pack_size + 2 * w;
    double u[m][pack_size];
    double v[max_parallel_nodes][m][2 * w_y + 1][length];
    double out[max_parallel_nodes][m][pack_size];
    double* target[max_parallel_nodes][m];
    for (int s = 0; s < m; ++s) {
      for (int i = 0; i < pack_size; ++i) u[s][i] = row.u[s][std::min(i, n - 1)];
      row.u[s] = u[s];
    }
    const std::ptrdiff_t to_row[] = {row.far_below, row.below, 0, row.above, row.far_above};
    for (int a = 0; a < sweep.nodes; ++a) {
      for (int s = 0; s < m; ++s) {
        const int last = diffusion.coefficient(s) > 0.0 ? n - 1 + w : n - 1;
        for (int j = -w_y; j <= w_y; ++j) {
          for (int i = -w; i < pack_size + w; ++i) v[a][s][j + w_y][i + w] = row.v[a][s][to_row[j + 2] + std::min(i, last)];
        }
        target[a][s] = row.out[a][s];
        row.v[a][s] = &v[a][s][w_y][w];
        row.out[a][s] = out[a][s];
      }
    }
    row.below = -length;
    row.above = length;
    row.far_below = -2 * length;
    row.far_above = 2 * length;
    cells<Order, Dimension>(diffusion, sweep, row, pack_size);
    for (int a = 0; a < sweep.nodes; ++a) {
      for (int s = 0; s < m; ++s) std::copy_n(out[a][s], n, target[a][s]);
    }
  }

  static constexpr bool is_interpreted = requires { M::packs_together; };

  /// n >= pack_size cells. The last pack overlaps the one before: its common cells are computed twice, with the same bits.
  ///
  /// Two passes over the nodes of a pack, of which the second needs the slopes of the first at all nodes: rates are computed again there
  /// together with their derivatives, which costs less than keeping those.
  template <int Order, int Dimension>
  [[gnu::flatten]] void cells(const DiffusionOperator& diffusion, const NodeSweep& sweep, const Row& row, int n) const {
    const M model = model_;
    const Grid& grid = sweep.decomposition->grid();
    const Pack lower(grid.lower[0]);
    const Pack spacing(grid.spacing(0));
    const Pack y(row.y);
    const Pack anisotropy(diffusion.anisotropy());
    const int nodes = sweep.nodes;
    double k[m];
    double inverse_gamma[max_parallel_nodes];
    double weights[max_parallel_nodes][max_parallel_nodes];  // of the slopes, dt s_ia / (dt d_i)
    double diagonal[max_parallel_nodes][m];
    double time[max_parallel_nodes];
    for (int s = 0; s < m; ++s) k[s] = diffusion.k_x(s);
    for (int a = 0; a < nodes; ++a) {
      const auto node = static_cast<std::size_t>(a);
      inverse_gamma[a] = 1.0 / (sweep.dt * sweep.diagonal[node]);
      time[a] = sweep.t + sweep.c[node] * sweep.dt;
      for (int s = 0; s < m; ++s) diagonal[a][s] = inverse_gamma[a] + 0.5 * sweep.shift * diffusion.spectral_radius(s);
      for (int b = 0; b < nodes; ++b) weights[a][b] = sweep.s[node][static_cast<std::size_t>(b)] / sweep.diagonal[node];
    }
    const auto place_of = [&](int i, int a) __attribute__((always_inline)) {
      return Place<Pack>{Pack(time[a]), lower + (Pack(row.first + i) + row.lane) * spacing, y};
    };
    const auto diffused = [&](int a, int s, int i, Pack centre) __attribute__((always_inline)) {
      const double* const at = row.v[a][s] + i;
      // A species that does not diffuse takes part with k = 0: cheaper than a branch. Its halo is finite.
      Pack difference = second_difference<Order>(at, 1, centre);
      if constexpr (Dimension == 2) {
        Pack far_before = centre;
        Pack far_after = centre;
        if constexpr (Order == 4) {
          far_before = Pack::load(at + row.far_below);
          far_after = Pack::load(at + row.far_above);
        }
        const Pack along_y =
            second_difference<Order>(centre, Pack::load(at + row.below), Pack::load(at + row.above), far_before, far_after);
        difference = mul_add(anisotropy, along_y, difference);
      }
      return Pack(k[s]) * difference;
    };

    for (int begin = 0; begin < n; begin += pack_size) {
      const int i = std::min(begin, n - pack_size);
      Pack slope[max_parallel_nodes][m];
      for (int a = 0; a < nodes; ++a) {
        Pack centre[m];
        Pack rate[m];
        unroll<m>([&](auto s) __attribute__((always_inline)) { centre[s] = Pack::load(row.v[a][s] + i); });
        model.rates(centre, rate, place_of(i, a));
        unroll<m>([&](auto s) __attribute__((always_inline)) { slope[a][s] = rate[s] + diffused(a, s, i, centre[s]); });
      }
      Pack u[m];
      unroll<m>([&](auto s) __attribute__((always_inline)) { u[s] = Pack::load(row.u[s] + i); });
      for (int a = 0; a < nodes; ++a) {
        Pack centre[m];
        unroll<m>([&](auto s) __attribute__((always_inline)) { centre[s] = Pack::load(row.v[a][s] + i); });
        Sparse<Pack> jacobian[m][m];
        if constexpr (is_interpreted) {
          Pack rate[m];
          Pack entries[m][m];
          model.rates_and_jacobian(centre, rate, entries, place_of(i, a));
          for (int e = 0; e < m * m; ++e) jacobian[e / m][e % m] = entries[e / m][e % m];
        } else {
          SparseDual<Pack, m> v[m];
          SparseDual<Pack, m> reaction[m];
          unroll<m>([&](auto s) __attribute__((always_inline)) { v[s] = SparseDual<Pack, m>::variable(centre[s], s); });
          model.rates(v, reaction, place_of(i, a));
          unroll<m>([&](auto s) __attribute__((always_inline)) {
            unroll<m>([&](auto q) __attribute__((always_inline)) { jacobian[s][q] = reaction[s].derivative[q]; });
          });
        }
        Sparse<Pack> matrix[m][m];
        Sparse<Pack> right[m];
        Pack sum[m];
        unroll<m>([&](auto s) __attribute__((always_inline)) { sum[s] = Pack(inverse_gamma[a]) * (u[s] - centre[s]); });
        for (int b = 0; b < nodes; ++b) {
          const Pack weight(weights[a][b]);
          unroll<m>([&](auto s) __attribute__((always_inline)) { sum[s] = mul_add(weight, slope[b][s], sum[s]); });
        }
        unroll<m>([&](auto s) __attribute__((always_inline)) {
          right[s] = -sum[s];
          unroll<m>([&](auto q) __attribute__((always_inline)) {
            matrix[s][q] = s == q ? jacobian[s][q] - Sparse<Pack>(Pack(diagonal[a][s])) : jacobian[s][q];
          });
        });
        sparse_cell_solve(matrix, right);
        unroll<m>([&](auto s) __attribute__((always_inline)) { (centre[s] + right[s].value).store(row.out[a][s] + i); });
      }
    }
  }

  M model_;
};

}  // namespace stiffront
