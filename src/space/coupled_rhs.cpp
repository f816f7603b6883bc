// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/space/coupled_rhs.hpp"

#include <cstring>

#include "stiffront/core/error.hpp"

namespace stiffront {

CoupledRhs::CoupledRhs(const Decomposition& decomposition, const DiffusionOperator& diffusion, const ReactionTerm& reaction,
                       const TransportTerm* transport)
    : diffusion_(&diffusion),
      reaction_(&reaction),
      transport_(transport),
      free_(diffusion.boundary().free_box(decomposition)),
      // Of a species that does not diffuse there may be first derivatives.
      halo_(decomposition, diffusion.boundary(), diffusion.n_species(), 1, diffusion.halo_width(),
            transport == nullptr ? diffusion.diffusing_species() : std::vector<int>()) {
  if (transport == nullptr) return;
  if (diffusion.dimension() != 1) throw Error(ErrorKind::input, "model.name: first derivatives are for grids of one dimension");
  derivatives_.emplace(Derivatives{LineDerivatives(decomposition.grid(), diffusion.order()), Field(decomposition, diffusion.n_species(), 0),
                                   Field(decomposition, diffusion.n_species(), 0)});
}

void CoupledRhs::evaluate(double t, Field& u, Field& du) {
  evaluate_without_rates(t, u, du);
  reaction_->add_rates(t, u, du, free_);
}

void CoupledRhs::evaluate_without_rates(double t, Field& u, Field& du) {
  halo_.exchange(u);
  if (diffusion_->boundary().has_dirichlet()) {
    for (int s = 0; s < du.n_species(); ++s) {
      for (int j = 0; j < du.n_y(); ++j) std::memset(du.row(s, j), 0, static_cast<std::size_t>(du.n_x()) * sizeof(double));
    }
  }
  diffusion_->apply(u, du, free_);
  if (derivatives_) {
    derivatives_->of.first(u, derivatives_->u_x, free_);
    derivatives_->of.second(u, derivatives_->u_xx, free_);
    transport_->add(t, u, derivatives_->u_x, derivatives_->u_xx, du, free_);
  }
}

}  // namespace stiffront
