// SPDX-License-Identifier: BSD-3-Clause
#include <cstddef>
#include <vector>

#include "species_count.hpp"
#include "stiffront/solvers/cell_solve.hpp"
#include "stiffront/solvers/implicit_part.hpp"

namespace stiffront {
namespace {

Pack load(const double* p, int n) { return n == pack_size ? Pack::load(p) : Pack::load_partial(p, n); }

template <int m>
class CellLocalPart final : public ImplicitPart {
 public:
  CellLocalPart(const Field& shape, const DiffusionOperator& diffusion, const ReactionTerm& reaction, ImplicitTerms terms)
      : reaction_(&reaction),
        terms_(terms),
        free_(diffusion.boundary().free_box(shape.decomposition())),
        jacobian_(shape.decomposition(), m * m, 0) {
    for (int s = 0; s < m; ++s) diagonal_[s] = 2.0 * terms.gamma_diffusion * (diffusion.k_x(s) + diffusion.k_y(s));
  }

  void solve(double t, double h, const Field& at, Field& b, Work& work) override {
    if (terms_.reaction && terms_.stiff_rates_only) {
      reaction_->stiff_jacobian(t, at, jacobian_, free_);
    } else if (terms_.reaction) {
      reaction_->jacobian(t, at, jacobian_, free_);
    }
    for (int j = free_.j_begin; j < free_.j_end; ++j) {
      for_each_pack(free_.i_begin, free_.i_end, [&](int i, int n) {
        Pack x[m];
        const auto solved = [&](auto lu) {
          for (int r = 0; r < m; ++r) {
            x[r] = load(b.row(r, j) + i, n);
            for (int c = 0; c < m; ++c) {
              lu(r, c) = neg_mul_add(Pack(h), load(jacobian_.row(r * m + c, j) + i, n), Pack(r == c ? 1.0 + h * diagonal_[r] : 0.0));
            }
          }
          const bool good = lu.factor();
          if (good) lu.solve(x);
          return good;
        };
        if (!solved(CellLu<Pack, m, false>())) solved(CellLu<Pack, m, true>());
        for (int r = 0; r < m; ++r) x[r].store_partial(b.row(r, j) + i, n);
      });
    }
    if (terms_.reaction) work.reaction_jacobians += static_cast<std::int64_t>(free_.i_end - free_.i_begin) * (free_.j_end - free_.j_begin);
    ++work.sweeps;
  }

 private:
  const ReactionTerm* reaction_;
  ImplicitTerms terms_;
  FreeBox free_;
  Field jacobian_;  // zero if the reaction is no part
  double diagonal_[m];
};

}  // namespace

std::unique_ptr<ImplicitPart> make_cell_local_part(const Field& shape, const DiffusionOperator& diffusion, const ReactionTerm& reaction,
                                                   ImplicitTerms terms) {
  return for_species_count<std::unique_ptr<ImplicitPart>>(
      shape.n_species(), [&]<int m>() { return std::make_unique<CellLocalPart<m>>(shape, diffusion, reaction, terms); });
}

}  // namespace stiffront
