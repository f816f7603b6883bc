// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <cstdint>
#include <type_traits>
#include <utility>

#include "stiffront/core/sparse_dual.hpp"
#include "stiffront/mesh/boundary.hpp"
#include "stiffront/mesh/rows.hpp"
#include "stiffront/model/model.hpp"
#include "stiffront/solvers/sparse_cell_solve.hpp"
#include "stiffront/space/diffusion_operator.hpp"

namespace stiffront {

/// One sweep towards the solution v of the BDF equation v = r + gamma (rates(t, v) + D Laplacian(v)): in every cell
///
///     (1 - gamma J + gamma g rho/2) delta = r - v + gamma (rates(t, v) + D Laplacian(v)),    out = v + delta,
///
/// with the reaction Jacobian J of the cell at v and rho, for each species, the spectral radius of its diffusion.
struct SbdfSweep {
  double t = 0.0;
  double gamma = 0.0;
  double shift = 0.0;  ///< g
  const Decomposition* decomposition = nullptr;
  ConstRows v;  ///< halo up to date
  ConstRows r;
  Rows out;  ///< distinct from v
};

/// The sweeps of one model's equations.
class SbdfKernel {
 public:
  virtual ~SbdfKernel() = default;
  /// Makes a sweep at the points of the box; other points of `out` are left alone. No communication. Rows beyond the
  /// ends of a periodic direction are those at its other end.
  virtual void sweep(const DiffusionOperator& diffusion, const SbdfSweep& sweep, const FreeBox& box) const = 0;
};

template <Model M>
class SbdfKernelOf final : public SbdfKernel {
 public:
  explicit SbdfKernelOf(M model) : model_(std::move(model)) {}

  void sweep(const DiffusionOperator& diffusion, const SbdfSweep& sweep, const FreeBox& box) const override {
    diffusion.dispatch([&]<int Order, int Dimension>() { rows<Order, Dimension>(diffusion, sweep, box); });
  }

 private:
  static constexpr int m = M::n_species;

  /// A row of cells seen from one of its points: what the cell loop reads and writes, and where it is.
  struct Row {
    const double* v[m];
    const double* r[m];
    double* out[m];
    std::ptrdiff_t below, above, far_below, far_above;  ///< from the row to rows -1, 1, -2, 2 of v
    double first;                                       ///< global index of the point
    Pack lane;                                          ///< offsets of the cells of a pack from its first
    double y;
  };

  template <int Order, int Dimension>
  void rows(const DiffusionOperator& diffusion, const SbdfSweep& sweep, const FreeBox& box) const {
    const Decomposition& d = *sweep.decomposition;
    const std::int64_t n_rows = d.grid().points[1];
    const int n = box.i_end - box.i_begin;
    for (int j = box.j_begin; j < box.j_end && n > 0; ++j) {
      Row row;
      for (int s = 0; s < m; ++s) {
        row.v[s] = sweep.v.row(s, j) + box.i_begin;
        row.r[s] = sweep.r.row(s, j) + box.i_begin;
        row.out[s] = sweep.out.row(s, j) + box.i_begin;
      }
      row.below = sweep.v.distance(j, -1);
      row.above = sweep.v.distance(j, 1);
      row.far_below = sweep.v.distance(j, -2);
      row.far_above = sweep.v.distance(j, 2);
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

  /// Makes a row of fewer cells than a pack holds a full one; the other lanes hold the halo's last value, or the last
  /// cell's where nothing diffuses and the halo is not kept, so that no rate is evaluated at made-up states.
  template <int Order, int Dimension>
  void short_row(const DiffusionOperator& diffusion, const SbdfSweep& sweep, Row row, int n) const {
    constexpr int w = Order / 2;
    constexpr int w_y = Dimension == 2 ? w : 0;
    constexpr int length = pack_size + 2 * w;
    double v[m][2 * w_y + 1][length];
    double r[m][pack_size];
    double out[m][pack_size];
    double* target[m];
    for (int s = 0; s < m; ++s) {
      const int last = diffusion.coefficient(s) > 0.0 ? n - 1 + w : n - 1;
      const std::ptrdiff_t to_row[] = {row.far_below, row.below, 0, row.above, row.far_above};
      for (int j = -w_y; j <= w_y; ++j) {
        for (int i = -w; i < pack_size + w; ++i) v[s][j + w_y][i + w] = row.v[s][to_row[j + 2] + std::min(i, last)];
      }
      for (int i = 0; i < pack_size; ++i) r[s][i] = row.r[s][std::min(i, n - 1)];
    }
    for (int s = 0; s < m; ++s) {
      target[s] = row.out[s];
      row.v[s] = &v[s][w_y][w];
      row.r[s] = r[s];
      row.out[s] = out[s];
    }
    row.below = -length;
    row.above = length;
    row.far_below = -2 * length;
    row.far_above = 2 * length;
    cells<Order, Dimension>(diffusion, sweep, row, pack_size);
    for (int s = 0; s < m; ++s) std::copy_n(out[s], n, target[s]);
  }

  /// Rates and Jacobian at a pack of states, by sparse duals.
  struct DualRates {
    SparseDual<Pack, m> of[m];

    STIFFRONT_ALWAYS_INLINE Pack rate(int s) const { return of[s].value; }
    STIFFRONT_ALWAYS_INLINE Sparse<Pack> jacobian(int s, int q) const { return of[s].derivative[q]; }
  };
  /// The same from an interpreted model.
  template <class Values>
  struct InterpretedRates {
    Values of;

    STIFFRONT_ALWAYS_INLINE Pack rate(int s) const { return of.output(s); }
    STIFFRONT_ALWAYS_INLINE Sparse<Pack> jacobian(int s, int q) const { return of.output(m + s * m + q); }
  };
  /// The instructions of such a model are looked up once for several packs.
  static constexpr bool is_interpreted = requires { M::packs_together; };

  /// n >= pack_size cells. The last pack overlaps the one before: its common cells are computed twice, with the same
  /// bits.
  template <int Order, int Dimension>
  [[gnu::flatten]] void cells(const DiffusionOperator& diffusion, const SbdfSweep& sweep, const Row& row, int n) const {
    // Everything the loop needs in locals: what is reached through a pointer would be read again after every store.
    const M model = model_;
    const Pack inverse_gamma(1.0 / sweep.gamma);
    const Pack time(sweep.t);
    const Grid& grid = sweep.decomposition->grid();
    const Pack lower(grid.lower[0]);
    const Pack spacing(grid.spacing(0));
    const Pack y(row.y);
    const Pack lane = row.lane;
    const double first = row.first;
    const std::ptrdiff_t below = row.below;
    const std::ptrdiff_t above = row.above;
    const std::ptrdiff_t far_below = row.far_below;
    const std::ptrdiff_t far_above = row.far_above;
    const Pack anisotropy(diffusion.anisotropy());
    double k[m];
    double diagonal[m];
    const double* v[m];
    const double* r[m];
    double* out[m];
    for (int s = 0; s < m; ++s) {
      v[s] = row.v[s];
      r[s] = row.r[s];
      out[s] = row.out[s];
      k[s] = diffusion.k_x(s);
      diagonal[s] = 1.0 / sweep.gamma + 0.5 * sweep.shift * diffusion.spectral_radius(s);
    }
    const auto place_of = [&](int i) __attribute__((always_inline)) {
      return Place<Pack>{time, lower + (Pack(first + i) + lane) * spacing, y};
    };
    const auto correct = [&](int i, const Pack* centre, const auto& reaction) __attribute__((always_inline)) {
      Sparse<Pack> a[m][m];
      Sparse<Pack> b[m];
      unroll<m>([&](auto s) __attribute__((always_inline)) {
        // A species that does not diffuse takes part with k = 0: cheaper than a branch. Its halo is finite.
        Pack difference = second_difference<Order>(v[s] + i, 1, centre[s]);
        // With equal spacings the factor is 1 and x and y enter alike: symmetric data stay symmetric.
        if constexpr (Dimension == 2) {
          const double* const at = v[s] + i;
          Pack far_before = centre[s];
          Pack far_after = centre[s];
          if constexpr (Order == 4) {
            far_before = Pack::load(at + far_below);
            far_after = Pack::load(at + far_above);
          }
          const Pack along_y = second_difference<Order>(centre[s], Pack::load(at + below), Pack::load(at + above), far_before, far_after);
          difference = mul_add(anisotropy, along_y, difference);
        }
        const Pack change = mul_add(Pack(k[s]), difference, reaction.rate(s));
        b[s] = neg_mul_add(inverse_gamma, Pack::load(r[s] + i) - centre[s], -change);
        unroll<m>([&](auto q) __attribute__((always_inline)) {
          a[s][q] = s == q ? reaction.jacobian(s, q) - Sparse<Pack>(Pack(diagonal[s])) : reaction.jacobian(s, q);
        });
      });
      sparse_cell_solve(a, b);
      unroll<m>([&](auto s) __attribute__((always_inline)) { (centre[s] + b[s].value).store(out[s] + i); });
    };

    if constexpr (is_interpreted) {
      // As many packs at a time as there are, or nearly so. Like packs, groups of them may overlap.
      const auto groups = [&]<int together>(std::integral_constant<int, together>) __attribute__((always_inline)) {
        typename M::template Evaluation<Pack, together> evaluation(model);
        Place<Pack> places[together];
        for (int begin = 0; begin < n; begin += together * pack_size) {
          const int at = std::min(begin, std::max(0, n - together * pack_size));
          const auto cell_of = [&](int p) __attribute__((always_inline)) { return std::min(at + p * pack_size, n - pack_size); };
          for (int p = 0; p < together; ++p) {
            const int i = cell_of(p);
            if (evaluation.needs_places()) places[p] = place_of(i);
            for (int s = 0; s < m; ++s) evaluation.u(s, p) = Pack::load(v[s] + i);
          }
          evaluation.run(places);
          for (int p = 0; p < together; ++p) {
            const InterpretedRates<decltype(evaluation.values(p))> reaction{evaluation.values(p)};
            Pack centre[m];
            unroll<m>([&](auto s) __attribute__((always_inline)) { centre[s] = reaction.of.input(s); });
            correct(cell_of(p), centre, reaction);
          }
        }
      };
      if (n > M::packs_together * pack_size / 2) {
        groups(std::integral_constant<int, M::packs_together>());
      } else {
        groups(std::integral_constant<int, 1>());
      }
    } else {
      for (int begin = 0; begin < n; begin += pack_size) {
        const int i = std::min(begin, n - pack_size);
        Pack centre[m];
        SparseDual<Pack, m> u[m];
        DualRates reaction;
        unroll<m>([&](auto s) __attribute__((always_inline)) {
          centre[s] = Pack::load(v[s] + i);
          u[s] = SparseDual<Pack, m>::variable(centre[s], s);
        });
        // Called from here, since flatten reaches calls of this function only.
        model.rates(u, reaction.of, place_of(i));
        correct(i, centre, reaction);
      }
    }
  }

  M model_;
};

}  // namespace stiffront
