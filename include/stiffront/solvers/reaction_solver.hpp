// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <cstdint>
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

/// n consecutive cells of one row of the grid, species-major: species s of cell k is at from[s * from_stride + k]. Whoever holds the
/// cells holds this; they need not lie in a field, nor belong to this rank.
struct CellRun {
  int n;
  const double* from;
  std::ptrdiff_t from_stride;
  double* to;  ///< may be `from`, with the same stride
  std::ptrdiff_t to_stride;
  double* hint;       ///< one per cell: the inner step the cell's last call ended with, or 0 if one step was enough; read and updated
  float* cost;        ///< one per cell: counted work of this call, a whole number
  std::int64_t i, j;  ///< global index of the first cell
};

/// Integrates cells on their own: du/dt = rates(t, x, y, u), no communication.
///
///     solver.begin(grid, t, dt);
///     for (...) solver.run(cells);      // not done yet: cells may be kept back until finish()
///     failure = solver.finish(work);
///
/// More runs and another finish() may follow. What becomes of a cell, its hint and its cost depend on that cell's state, place and hint
/// alone, to the last bit: not on the other cells of the run, nor on the rank.
class ReactionSolver {
 public:
  /// Counted work of an attempt at an inner step besides its Newton iterations, in such iterations: the Jacobian, its decompositions and
  /// the error estimate.
  static constexpr double attempt_cost = 2.0;

  virtual ~ReactionSolver() = default;

  /// What follows is to be advanced from t to t + dt.
  virtual void begin(const Grid& grid, double t, double dt) = 0;
  /// @pre the memory of the run stays where it is until finish()
  virtual void run(const CellRun& cells) = 0;
  /// Completes the runs since the last finish(), and adds their counts.
  /// @return the first failed cell in index order, if any; its value in `to` is then that of `from`.
  virtual std::optional<CellFailure> finish(Work& work) = 0;

  /// Advances the cells of the box; other points of `to` are left alone. from and to may be the same field. Hints and costs are those of
  /// the *whole* local box, [n_y][n_x].
  std::optional<CellFailure> advance(double t, double dt, const Field& from, Field& to, const FreeBox& box, std::vector<double>& hint,
                                     std::vector<float>& cost, Work& work);
};

/// The cells i_begin <= i < i_end of row j of a field, as a run.
CellRun run_of(const Field& from, Field& to, int i_begin, int i_end, int j, std::vector<double>& hint, std::vector<float>& cost);

}  // namespace stiffront
