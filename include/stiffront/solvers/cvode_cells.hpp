// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>
#include <optional>
#include <vector>

#include "stiffront/model/reaction_term.hpp"
#include "stiffront/solvers/reaction_solver.hpp"

namespace stiffront {

/// CVODE in every cell of a box, one cell after the other: variable-order BDF, dense Jacobians from duals, restarted for each cell.
///
/// A second opinion on Radau5, some hundred times slower. Its tolerances are CVODE's, not transformed. Hints are neither read nor
/// written: each cell starts with the step that CVODE estimates. The cost of a cell is its
/// number of Newton iterations, and attempt_cost for each step tried.
class CvodeCells final : public ReactionSolver {
 public:
  /// @param term must outlive the solver. @throws Error(bug) unless there is one positive absolute tolerance per species and a
  ///        positive relative one; and if CVODE refuses to be set up
  CvodeCells(const ReactionTerm& term, const CellTolerances& tolerances);
  ~CvodeCells() override;
  CvodeCells(const CvodeCells&) = delete;
  CvodeCells& operator=(const CvodeCells&) = delete;

  void begin(const Grid& grid, double t, double dt) override;
  void run(const CellRun& cells) override;
  std::optional<CellFailure> finish(Work& work) override;

 private:
  class Integrator;
  std::unique_ptr<Integrator> integrator_;
  const Grid* grid_ = nullptr;
  double t_ = 0.0;
  double dt_ = 0.0;
  Work work_;
  std::optional<CellFailure> first_;
};

}  // namespace stiffront
