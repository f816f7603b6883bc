// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "species_count.hpp"
#include "stiffront/core/error.hpp"
#include "stiffront/solvers/implicit_part.hpp"
#include "stiffront/solvers/line_coupling.hpp"
#include "stiffront/space/three_point.hpp"

namespace stiffront {
namespace {

template <int m>
class LinePart final : public ImplicitPart {
 public:
  LinePart(const Field& shape, const DiffusionOperator& diffusion, const ReactionTerm& reaction, ImplicitTerms terms)
      : reaction_(&reaction),
        terms_(terms),
        decomposition_(&shape.decomposition()),
        free_(diffusion.boundary().free_box(*decomposition_)),
        jacobian_(*decomposition_, m * m, 0),
        system_(*decomposition_, decomposition_->grid().periodic[0]) {
    for (int s = 0; s < m; ++s) k_[s] = terms.gamma_diffusion * diffusion.k_x(s);
    for (int i = 0; i < shape.n_x(); ++i) weights_.push_back(three_point_second(decomposition_->grid(), 0, decomposition_->offset_x() + i));
  }

  void solve(double t, double h, const Field& at, Field& b, Work& work) override {
    if (terms_.reaction) reaction_->jacobian(t, at, jacobian_, free_);
    const int n = b.n_x();
    for (int r = 0; r < m; ++r) {
      for (int c = 0; c < m; ++c) {
        double* to = system_.diagonal(r, c);
        const double* from = jacobian_.row(r * m + c, 0);
        for (int i = 0; i < n; ++i) to[i] = -h * from[i];
      }
      const double hk = h * k_[r];
      double* const lower = system_.lower(r);
      double* const diagonal = system_.diagonal(r, r);
      double* const upper = system_.upper(r);
      for (int i = 0; i < n; ++i) {
        const ThreePoint& w = weights_[static_cast<std::size_t>(i)];
        lower[i] = -(hk * w.before);
        diagonal[i] = (1.0 + hk * (w.before + w.after)) + diagonal[i];
        upper[i] = -(hk * w.after);
      }
      std::copy_n(b.row(r, 0), n, system_.right_side(r));
    }
    fix_points(system_, free_, n);
    system_.factor_and_solve();
    for (int r = 0; r < m; ++r) std::copy_n(system_.right_side(r), n, b.row(r, 0));
    if (terms_.reaction) work.reaction_jacobians += free_.i_end - free_.i_begin;
    ++work.line_solves;
  }

 private:
  const ReactionTerm* reaction_;
  ImplicitTerms terms_;
  const Decomposition* decomposition_;
  FreeBox free_;
  Field jacobian_;  // zero if the reaction is no part
  BlockTridiagonal<m> system_;
  double k_[m];
  std::vector<ThreePoint> weights_;
};

}  // namespace

std::unique_ptr<ImplicitPart> make_block_tridiagonal_part(const Field& shape, const DiffusionOperator& diffusion, const ReactionTerm& reaction,
                                                          ImplicitTerms terms) {
  if (diffusion.dimension() != 1) throw Error(ErrorKind::input, "method.implicit_solver: \"block-tridiagonal\" is for one dimension");
  return for_species_count<std::unique_ptr<ImplicitPart>>(
      shape.n_species(), [&]<int m>() { return std::make_unique<LinePart<m>>(shape, diffusion, reaction, terms); });
}

}  // namespace stiffront
