// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>
#include <optional>
#include <vector>

#include "stiffront/mesh/boundary.hpp"
#include "stiffront/solvers/flow.hpp"
#include "stiffront/solvers/reaction_solver.hpp"
#include "stiffront/splitting/reaction_balance.hpp"

namespace stiffront {

/// Y^t: every cell integrated on its own. Dirichlet points take their values at the end of the sub-step.
class ReactionFlow final : public Flow {
 public:
  /// @param balances whether ranks with much to do send cells to others, unless all have too few for that to pay. @mpi collective if they do
  ReactionFlow(const Decomposition& decomposition, const Boundary& boundary, std::unique_ptr<ReactionSolver> solver, bool balances = false);

  using Flow::advance;
  std::optional<CellFailure> advance(double t, double dt, std::span<const Transition> states, Work& work) override;

  /// Inner step each cell's last call ended with, 0 where one step was enough: hidden state, [n_y][n_x] of this rank's box.
  std::vector<double>& hints() { return hints_; }
  /// Counted work of each cell in the last call: see ReactionSolver::run.
  const std::vector<float>& costs() const { return costs_; }
  /// What balancing has done; nothing if there is none. @mpi collective
  std::optional<BalanceCounts> balance() { return balance_ ? std::optional(balance_->counts()) : std::nullopt; }
  /// Seconds this rank has spent here.
  double seconds() const { return seconds_; }

 private:
  const Boundary* boundary_;
  FreeBox free_;
  std::unique_ptr<ReactionSolver> solver_;
  std::vector<double> hints_;
  std::vector<float> costs_;
  std::optional<ReactionBalance> balance_;
  double seconds_ = 0.0;
};

}  // namespace stiffront
