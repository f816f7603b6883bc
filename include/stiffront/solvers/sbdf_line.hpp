// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <utility>

#include "stiffront/model/model.hpp"
#include "stiffront/solvers/line_coupling.hpp"
#include "stiffront/solvers/sbdf_kernel.hpp"
#include "stiffront/space/diffusion_operator.hpp"

namespace stiffront {

/// One Newton iteration towards the solution v of the BDF equation v = r + gamma (rates(t, v) + D Laplacian(v)) that
/// couples all cells of a line:
///
///     (1 - gamma J - gamma c D Laplacian_2) delta = r - v + gamma (rates(t, v) + D Laplacian(v)),    out = v + delta,
///
/// with the second-order Laplacian on the left. On the right it has the order of the operator: at order 4 its
/// eigenvalues are 1 to 4/3 times those on the left, and some iterations with different c solve the equation.
class SbdfLine {
 public:
  virtual ~SbdfLine() = default;
  /// @param sweep as for SbdfKernel; its shift is not used
  /// @pre the field has one dimension. @mpi collective
  virtual void iterate(const DiffusionOperator& diffusion, const SbdfSweep& sweep, double c, const FreeBox& box) = 0;
};

template <Model M>
class SbdfLineOf final : public SbdfLine {
 public:
  SbdfLineOf(M model, const Decomposition& decomposition)
      : model_(std::move(model)), solver_(decomposition, decomposition.grid().periodic[0]) {}

  void iterate(const DiffusionOperator& diffusion, const SbdfSweep& sweep, double c, const FreeBox& box) override {
    diffusion.dispatch([&]<int Order, int Dimension>() {
      if constexpr (Dimension == 1) equations<Order>(diffusion, sweep, c, box);
    });
    const Decomposition& d = *sweep.decomposition;
    double coupling[m];
    for (int s = 0; s < m; ++s) {
      coupling[s] = -(sweep.gamma * c) * diffusion.k_x(s);
      // Points that do not evolve.
      if (box.i_begin > 0) solver_.right_side(s)[0] = 0.0;
      if (box.i_end < d.n_x()) solver_.right_side(s)[d.n_x() - 1] = 0.0;
    }
    couple_line(solver_, d, box, coupling);
    solver_.factor_and_solve();
    for (int s = 0; s < m; ++s) {
      const double* v = sweep.v.row(s, 0);
      const double* delta = solver_.right_side(s);
      double* out = sweep.out.row(s, 0);
      for_each_pack(box.i_begin, box.i_end, [&](int i, int n) { (Pack::load(v + i) + Pack::load(delta + i)).store_partial(out + i, n); });
    }
  }

 private:
  static constexpr int m = M::n_species;

  /// Diagonal blocks and right sides.
  template <int Order>
  void equations(const DiffusionOperator& diffusion, const SbdfSweep& sweep, double c, const FreeBox& box) {
    const Decomposition& d = *sweep.decomposition;
    const Pack gamma(sweep.gamma);
    for_each_pack(box.i_begin, box.i_end, [&](int i, int n) {
      Pack v[m];
      Pack rate[m];
      Pack jacobian[m][m];
      for (int s = 0; s < m; ++s) v[s] = Pack::load_partial(sweep.v.row(s, 0) + i, n);
      rates_and_jacobian(model_, v, rate, jacobian, place_of_pack(d, sweep.t, i, 0, n));
      // Whole packs: the solver's arrays go on beyond the last point, and so do the fields.
      for (int s = 0; s < m; ++s) {
        const double k = diffusion.k_x(s);
        const double* row = sweep.v.row(s, 0) + i;
        const Pack change = mul_add(Pack(k), second_difference<Order>(row, 1, v[s]), rate[s]);
        mul_add(gamma, change, Pack::load(sweep.r.row(s, 0) + i) - v[s]).store(solver_.right_side(s) + i);
        const Pack one(1.0 + 2.0 * (sweep.gamma * c) * k);
        for (int q = 0; q < m; ++q) {
          neg_mul_add(gamma, jacobian[s][q], s == q ? one : Pack(0.0)).store(solver_.diagonal(s, q) + i);
        }
      }
    });
  }

  M model_;
  BlockTridiagonal<m> solver_;
};

}  // namespace stiffront
