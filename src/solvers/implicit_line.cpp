// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "species_count.hpp"
#include "stiffront/core/error.hpp"
#include "stiffront/solvers/block_tridiagonal.hpp"
#include "stiffront/solvers/implicit_part.hpp"

namespace stiffront {
namespace {

template <int m>
class LinePart final : public ImplicitPart {
 public:
  LinePart(const Field& shape, const DiffusionOperator& diffusion, const ReactionTerm& reaction, ImplicitTerms terms)
      : reaction_(&reaction),
        terms_(terms),
        decomposition_(&shape.decomposition()),
        boundary_(&diffusion.boundary()),
        free_(boundary_->free_box(*decomposition_)),
        jacobian_(*decomposition_, m * m, 0),
        system_(*decomposition_, decomposition_->grid().periodic[0]) {
    for (int s = 0; s < m; ++s) k_[s] = terms.gamma_diffusion * diffusion.k_x(s);
  }

  void solve(double t, double h, const Field& at, Field& b, Work& work) override {
    if (terms_.reaction) reaction_->jacobian(t, at, jacobian_, free_);
    const int n = b.n_x();
    for (int r = 0; r < m; ++r) {
      for (int c = 0; c < m; ++c) {
        double* to = system_.diagonal(r, c);
        const double* from = jacobian_.row(r * m + c, 0);
        const double unit = r == c ? 1.0 + 2.0 * (h * k_[r]) : 0.0;
        for (int i = 0; i < n; ++i) to[i] = unit - h * from[i];
      }
      std::fill_n(system_.lower(r), n, -(h * k_[r]));
      std::fill_n(system_.upper(r), n, -(h * k_[r]));
      std::copy_n(b.row(r, 0), n, system_.right_side(r));
    }
    for (int which = 0; which < 2; ++which) {
      if (!decomposition_->at_boundary(0, which)) continue;
      end_row(h, which, which == 0 ? 0 : n - 1);
    }
    system_.factor_and_solve();
    for (int r = 0; r < m; ++r) std::copy_n(system_.right_side(r), n, b.row(r, 0));
    if (terms_.reaction) work.reaction_jacobians += free_.i_end - free_.i_begin;
    ++work.line_solves;
  }

 private:
  void end_row(double h, int which, int i) {
    for (int r = 0; r < m; ++r) {
      double* outward = which == 0 ? system_.lower(r) : system_.upper(r);
      double* inward = which == 0 ? system_.upper(r) : system_.lower(r);
      outward[i] = 0.0;
      if (boundary_->side(0, which).kind == BoundaryKind::dirichlet) {
        inward[i] = 0.0;
        for (int c = 0; c < m; ++c) system_.diagonal(r, c)[i] = r == c ? 1.0 : 0.0;
      } else {
        inward[i] = -2.0 * (h * k_[r]);  // the mirrored neighbour
      }
    }
  }

  const ReactionTerm* reaction_;
  ImplicitTerms terms_;
  const Decomposition* decomposition_;
  const Boundary* boundary_;
  FreeBox free_;
  Field jacobian_;  // zero if the reaction is no part
  BlockTridiagonal<m> system_;
  double k_[m];
};

}  // namespace

std::unique_ptr<ImplicitPart> make_block_tridiagonal_part(const Field& shape, const DiffusionOperator& diffusion, const ReactionTerm& reaction,
                                                          ImplicitTerms terms) {
  if (diffusion.dimension() != 1) throw Error(ErrorKind::input, "method.implicit_solver: \"block-tridiagonal\" is for one dimension");
  return for_species_count<std::unique_ptr<ImplicitPart>>(
      shape.n_species(), [&]<int m>() { return std::make_unique<LinePart<m>>(shape, diffusion, reaction, terms); });
}

}  // namespace stiffront
