// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/splitting/reaction_flow.hpp"

#include <utility>

#include "stiffront/core/timer.hpp"

namespace stiffront {

ReactionFlow::ReactionFlow(const Decomposition& decomposition, const Boundary& boundary, std::unique_ptr<ReactionSolver> solver)
    : boundary_(&boundary), free_(boundary.free_box(decomposition)), solver_(std::move(solver)) {
  const std::size_t cells = static_cast<std::size_t>(decomposition.n_x()) * static_cast<std::size_t>(decomposition.n_y());
  hints_.assign(cells, 0.0);
  costs_.assign(cells, 0.0F);
}

std::optional<CellFailure> ReactionFlow::advance(double t, double dt, std::span<const Transition> states, Work& work) {
  const ScopedTimer timer(seconds_);
  std::optional<CellFailure> first;
  for (const Transition& s : states) {
    auto failure = solver_->advance(t, dt, *s.from, *s.to, free_, hints_, costs_, work);
    if (failure && !first) {
      first = std::move(failure);
      first->begin = t;
    }
    boundary_->impose(*s.to, t + dt);
  }
  return first;
}

}  // namespace stiffront
