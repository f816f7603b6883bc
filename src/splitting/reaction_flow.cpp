// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/splitting/reaction_flow.hpp"

#include <cstdint>
#include <utility>

#include "stiffront/core/timer.hpp"

namespace stiffront {
namespace {

/// So few cells take less time than ranks take to tell each other how much they have to do, by messages or through memory.
constexpr std::int64_t fewest_cells = 768;
constexpr std::int64_t fewest_cells_in_memory = 192;

/// The same on all ranks.
bool may_pay(const Decomposition& d) {
  std::int64_t cells = 1;
  for (std::size_t k = 0; k < 2; ++k) cells *= (d.grid().points[k] + d.processes()[k] - 1) / d.processes()[k];
  bool all_share = true;
  for (int rank = 0; rank < d.comm().size(); ++rank) all_share &= d.comm().node_rank(rank) >= 0;
  return d.comm().size() > 1 && cells >= (all_share ? fewest_cells_in_memory : fewest_cells);
}

}  // namespace

ReactionFlow::ReactionFlow(const Decomposition& decomposition, const Boundary& boundary, std::unique_ptr<ReactionSolver> solver,
                           bool balances)
    : boundary_(&boundary), free_(boundary.free_box(decomposition)), solver_(std::move(solver)) {
  const std::size_t cells = static_cast<std::size_t>(decomposition.n_x()) * static_cast<std::size_t>(decomposition.n_y());
  hints_.assign(cells, 0.0);
  costs_.assign(cells, 0.0F);
  if (balances && may_pay(decomposition)) balance_.emplace(decomposition, free_);
}

std::optional<CellFailure> ReactionFlow::advance(double t, double dt, std::span<const Transition> states, Work& work) {
  const ScopedTimer timer(seconds_);
  std::optional<CellFailure> first;
  for (const Transition& s : states) {
    auto failure = balance_ ? balance_->advance(*solver_, t, dt, *s.from, *s.to, hints_, costs_, work)
                            : solver_->advance(t, dt, *s.from, *s.to, free_, hints_, costs_, work);
    if (failure && !first) {
      first = std::move(failure);
      first->begin = t;
    }
    boundary_->impose(*s.to, t + dt);
  }
  return first;
}

}  // namespace stiffront
