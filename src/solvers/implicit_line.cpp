// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "species_count.hpp"
#include "stiffront/core/error.hpp"
#include "stiffront/solvers/implicit_part.hpp"
#include "stiffront/solvers/line_coupling.hpp"

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
      std::copy_n(b.row(r, 0), n, system_.right_side(r));
    }
    double coupling[m];
    for (int r = 0; r < m; ++r) coupling[r] = -(h * k_[r]);
    couple_line(system_, *decomposition_, free_, coupling);
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
};

}  // namespace

std::unique_ptr<ImplicitPart> make_block_tridiagonal_part(const Field& shape, const DiffusionOperator& diffusion, const ReactionTerm& reaction,
                                                          ImplicitTerms terms) {
  if (diffusion.dimension() != 1) throw Error(ErrorKind::input, "method.implicit_solver: \"block-tridiagonal\" is for one dimension");
  return for_species_count<std::unique_ptr<ImplicitPart>>(
      shape.n_species(), [&]<int m>() { return std::make_unique<LinePart<m>>(shape, diffusion, reaction, terms); });
}

}  // namespace stiffront
