// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <optional>
#include <vector>

#include "stiffront/mesh/boundary.hpp"
#include "stiffront/solvers/flow.hpp"

namespace stiffront {

/// Tolerances of a per-cell integrator: |error_s| <= absolute[s] + relative |u_s|, root mean square over the species of a cell.
struct CellTolerances {
  double relative = 1e-5;
  std::vector<double> absolute;  ///< one per species
};

/// Integrates every cell of a box on its own: du/dt = rates(t, x, y, u), no communication.
class ReactionSolver {
 public:
  virtual ~ReactionSolver() = default;

  /// Advances the cells of the box from t to t + dt; other points of `to` are left alone. from and to may be the same field.
  ///
  /// @param hint one number per cell of the *whole* local box, [n_y][n_x]: the inner step the cell's last call ended with, or 0 if one
  ///        step was enough (then the first step tried is the whole of dt). Read and updated; hidden state of the run.
  /// @param cost one number per cell, [n_y][n_x]: Newton iterations (or right-hand sides) of this call, for load balancing.
  /// @return the first failed cell in index order, if any; its value in `to` is then that of `from`.
  virtual std::optional<CellFailure> advance(double t, double dt, const Field& from, Field& to, const FreeBox& box,
                                             std::vector<double>& hint, std::vector<float>& cost, Work& work) = 0;
};

}  // namespace stiffront
