// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>
#include <vector>

#include "stiffront/mesh/boundary.hpp"
#include "stiffront/solvers/flow.hpp"
#include "stiffront/solvers/reaction_solver.hpp"

namespace stiffront {

/// Y^t: every cell integrated on its own. Dirichlet points take their values at the end of the sub-step.
class ReactionFlow final : public Flow {
 public:
  ReactionFlow(const Decomposition& decomposition, const Boundary& boundary, std::unique_ptr<ReactionSolver> solver);

  using Flow::advance;
  std::optional<CellFailure> advance(double t, double dt, std::span<const Transition> states, Work& work) override;

  /// Inner step each cell's last call ended with, 0 where one step was enough: hidden state, [n_y][n_x] of this rank's box.
  std::vector<double>& hints() { return hints_; }
  /// Newton iterations each cell needed in the last call.
  const std::vector<float>& costs() const { return costs_; }
  /// Seconds this rank has spent here.
  double seconds() const { return seconds_; }

 private:
  const Boundary* boundary_;
  FreeBox free_;
  std::unique_ptr<ReactionSolver> solver_;
  std::vector<double> hints_;
  std::vector<float> costs_;
  double seconds_ = 0.0;
};

}  // namespace stiffront
