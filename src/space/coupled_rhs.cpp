// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/space/coupled_rhs.hpp"

#include <cstring>

namespace stiffront {

CoupledRhs::CoupledRhs(const Decomposition& decomposition, const DiffusionOperator& diffusion, const ReactionTerm& reaction)
    : diffusion_(&diffusion),
      reaction_(&reaction),
      free_(diffusion.boundary().free_box(decomposition)),
      halo_(decomposition, diffusion.boundary(), diffusion.n_species(), 1, diffusion.halo_width(), diffusion.diffusing_species()) {}

void CoupledRhs::evaluate(double t, Field& u, Field& du) {
  halo_.exchange(u);
  if (diffusion_->boundary().has_dirichlet()) {
    for (int s = 0; s < du.n_species(); ++s) {
      for (int j = 0; j < du.n_y(); ++j) std::memset(du.row(s, j), 0, static_cast<std::size_t>(du.n_x()) * sizeof(double));
    }
  }
  diffusion_->apply(u, du, free_);
  reaction_->add_rates(t, u, du, free_);
}

}  // namespace stiffront
