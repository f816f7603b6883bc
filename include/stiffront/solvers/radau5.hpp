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

  std::optional<CellFailure> advance(double t, double dt, const Field& from, Field& to, const FreeBox& box,
                                     std::vector<double>& hint, std::vector<float>& cost, Work& work) override {
    const Decomposition& d = from.decomposition();
    const int n = box.i_end - box.i_begin;
    kernel_.begin(t, dt);
    for (int j = box.j_begin; j < box.j_end; ++j) {
      const std::ptrdiff_t first = static_cast<std::ptrdiff_t>(j) * from.n_x() + box.i_begin;
      const CellRow row{n,
                        from.row(0, j) + box.i_begin,
                        from.species_stride(),
                        to.row(0, j) + box.i_begin,
                        to.species_stride(),
                        hint.data() + first,
                        cost.data() + first,
                        first};
      kernel_.row(row, [&](int i, int lanes) { return place_of_pack(d, t, box.i_begin + i, j, lanes); });
    }
    const std::optional<Radau5Failure> failure = kernel_.finish();

    const Radau5Counts counts = kernel_.counts();
    work.reaction_steps += counts.steps;
    work.reaction_rejections += counts.error_rejections + counts.newton_failures;
    work.reaction_newton_iterations += counts.newton_iterations;
    work.reaction_rhs += counts.rhs;
    work.reaction_jacobians += counts.jacobians;

    if (!failure) return std::nullopt;
    CellFailure f;
    const int i = static_cast<int>(failure->cell % from.n_x());
    const int j = static_cast<int>(failure->cell / from.n_x());
    f.i = d.offset_x() + i;
    f.j = d.offset_y() + j;
    f.x = d.grid().position(0, f.i);
    f.y = d.grid().dimension == 2 ? d.grid().position(1, f.j) : 0.0;
    f.t = failure->t;
    f.dt = failure->h;
    f.interval = dt;
    for (int s = 0; s < M::n_species; ++s) f.state.push_back(to.at(s, i, j));
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
};

}  // namespace stiffront
