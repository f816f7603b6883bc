// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <fmt/format.h>

#include <optional>
#include <utility>
#include <vector>

#include "stiffront/core/error.hpp"
#include "stiffront/solvers/radau5_kernel.hpp"
#include "stiffront/solvers/reaction_solver.hpp"

namespace stiffront {

/// Radau IIA of order 5 in every cell of a box, many cells at once, each with inner steps of its own.
/// @see Radau5Kernel for the method, Radau5Tolerances for what tolerances mean
template <Model M>
class Radau5 final : public ReactionSolver {
 public:
  /// @throws Error(bug) unless there is one positive absolute tolerance per species and a positive relative one
  Radau5(M model, const CellTolerances& tolerances) : kernel_(std::move(model), checked(tolerances)) {}

  void begin(const Grid& grid, double t, double dt) override {
    grid_ = &grid;
    t_ = t;
    dt_ = dt;
    kernel_.begin(t, dt);
  }

  void run(const CellRun& cells) override {
    const CellRow row{cells.n,         cells.from, cells.from_stride, cells.to,
                      cells.to_stride, cells.hint, cells.cost,        cells.j * grid_->points[0] + cells.i};
    kernel_.row(row, [&](int i, int n) { return place_of_cells(*grid_, t_, cells.i + i, cells.j, n); });
  }

  std::optional<CellFailure> finish(Work& work) override {
    const std::optional<Radau5Failure> failure = kernel_.finish();
    const Radau5Counts counts = kernel_.counts();
    work.reaction_steps += counts.steps;
    work.reaction_rejections += counts.error_rejections + counts.newton_failures;
    work.reaction_newton_iterations += counts.newton_iterations;
    work.reaction_rhs += counts.rhs;
    work.reaction_jacobians += counts.jacobians;
    kernel_.begin(t_, dt_);

    if (!failure) return std::nullopt;
    CellFailure f;
    f.i = failure->cell % grid_->points[0];
    f.j = failure->cell / grid_->points[0];
    f.x = grid_->position(0, f.i);
    f.y = grid_->dimension == 2 ? grid_->position(1, f.j) : 0.0;
    f.t = failure->t;
    f.dt = failure->h;
    f.interval = dt_;
    for (int s = 0; s < M::n_species; ++s) f.state.push_back(failure->to[s * failure->stride]);
    f.reason = failure->reason;
    return f;
  }

 private:
  static Radau5Tolerances<M::n_species> checked(const CellTolerances& tolerances) {
    bool valid = tolerances.relative > 0.0 && tolerances.absolute.size() == static_cast<std::size_t>(M::n_species);
    for (double a : tolerances.absolute) valid = valid && a > 0.0;
    if (!valid) throw Error(ErrorKind::bug, fmt::format("Radau5: {} needs a positive tolerance for each species", M::name));
    return Radau5Tolerances<M::n_species>(tolerances.relative, tolerances.absolute.data());
  }

  Radau5Kernel<M> kernel_;
  const Grid* grid_ = nullptr;
  double t_ = 0.0;
  double dt_ = 0.0;
};

}  // namespace stiffront
