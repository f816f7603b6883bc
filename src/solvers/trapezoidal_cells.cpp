// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/solvers/trapezoidal_cells.hpp"

#include <cmath>

#include "species_count.hpp"
#include "stiffront/mesh/field_algebra.hpp"
#include "stiffront/solvers/cell_solve.hpp"

namespace stiffront {
namespace {

constexpr int most_iterations = 50;

template <int m>
class TrapezoidalCells final : public ReactionSolver {
 public:
  TrapezoidalCells(const Field& shape, const ReactionTerm& reaction, CellTolerances tolerances)
      : reaction_(&reaction),
        tolerances_(std::move(tolerances)),
        base_(shape.decomposition(), m, 0),
        value_(shape.decomposition(), m, 0),
        rates_(shape.decomposition(), m, 0),
        jacobian_(shape.decomposition(), m * m, 0) {}

  std::optional<CellFailure> advance(double t, double dt, const Field& from, Field& to, const FreeBox& box, std::vector<double>&,
                                     std::vector<float>& cost, Work& work) override {
    const double h = 0.5 * dt;
    value_.copy_interior(from);
    rate(t, box);
    for (int s = 0; s < m; ++s) {
      for (int j = box.j_begin; j < box.j_end; ++j) {
        for (int i = box.i_begin; i < box.i_end; ++i) base_.at(s, i, j) = value_.at(s, i, j) + h * rates_.at(s, i, j);
      }
    }
    const auto cells = static_cast<std::int64_t>(box.i_end - box.i_begin) * (box.j_end - box.j_begin);
    // 1: the cell still moves. Cells that have converged stay as they are, whatever becomes of the others.
    moving_.assign(static_cast<std::size_t>(value_.n_x()) * static_cast<std::size_t>(value_.n_y()), 1);
    bool all_done = false;
    for (int iteration = 0; iteration < most_iterations && !all_done; ++iteration) {
      rate(t + dt, box);
      reaction_->jacobian(t + dt, value_, jacobian_, box);
      work.reaction_jacobians += cells;
      work.reaction_rhs += cells;
      all_done = true;
      for (int j = box.j_begin; j < box.j_end; ++j) {
        for (int i = box.i_begin; i < box.i_end; ++i) {
          const std::size_t cell = static_cast<std::size_t>(j) * static_cast<std::size_t>(value_.n_x()) + static_cast<std::size_t>(i);
          if (moving_[cell] == 0) continue;
          moving_[cell] = newton(h, i, j) ? 0 : 1;
          all_done = all_done && moving_[cell] == 0;
          cost[cell] = static_cast<float>(iteration + 1);
          ++work.reaction_newton_iterations;
        }
      }
    }
    work.reaction_steps += cells;
    std::optional<CellFailure> failure;
    for (int j = box.j_begin; j < box.j_end; ++j) {
      for (int i = box.i_begin; i < box.i_end; ++i) {
        const std::size_t cell = static_cast<std::size_t>(j) * static_cast<std::size_t>(value_.n_x()) + static_cast<std::size_t>(i);
        const bool solved = moving_[cell] == 0;
        if (!solved && !failure) failure = failure_at(t, dt, from, i, j);
        for (int s = 0; s < m; ++s) to.at(s, i, j) = solved ? value_.at(s, i, j) : from.at(s, i, j);
      }
    }
    return failure;
  }

 private:
  void rate(double t, const FreeBox& box) {
    for (int s = 0; s < m; ++s) {
      for (int j = box.j_begin; j < box.j_end; ++j) std::fill(rates_.row(s, j) + box.i_begin, rates_.row(s, j) + box.i_end, 0.0);
    }
    reaction_->add_rates(t, value_, rates_, box);
  }

  /// @return whether the cell has converged
  bool newton(double h, int i, int j) {
    double x[m];
    CellLu<double, m, true> lu;
    for (int r = 0; r < m; ++r) {
      x[r] = base_.at(r, i, j) + h * rates_.at(r, i, j) - value_.at(r, i, j);
      for (int c = 0; c < m; ++c) lu(r, c) = (r == c ? 1.0 : 0.0) - h * jacobian_.at(r * m + c, i, j);
    }
    lu.factor();
    lu.solve(x);
    bool converged = true;
    for (int r = 0; r < m; ++r) {
      double& v = value_.at(r, i, j);
      v += x[r];
      converged = converged && std::abs(x[r]) <= tolerances_.absolute[static_cast<std::size_t>(r)] + tolerances_.relative * std::abs(v);
    }
    return converged;
  }

  CellFailure failure_at(double t, double dt, const Field& from, int i, int j) const {
    const Decomposition& d = from.decomposition();
    CellFailure f;
    f.i = d.offset_x() + i;
    f.j = d.offset_y() + j;
    f.x = d.grid().position(0, f.i);
    f.y = d.grid().dimension == 2 ? d.grid().position(1, f.j) : 0.0;
    f.begin = f.t = t;
    f.dt = f.interval = dt;
    for (int s = 0; s < m; ++s) f.state.push_back(from.at(s, i, j));
    f.reason = "Newton's iteration for the trapezoidal rule does not converge";
    return f;
  }

  const ReactionTerm* reaction_;
  CellTolerances tolerances_;
  Field base_, value_, rates_, jacobian_;
  std::vector<char> moving_;
};

}  // namespace

std::unique_ptr<ReactionSolver> make_trapezoidal_cells(const Field& shape, const ReactionTerm& reaction, const CellTolerances& tolerances) {
  return for_species_count<std::unique_ptr<ReactionSolver>>(
      shape.n_species(), [&]<int m>() { return std::make_unique<TrapezoidalCells<m>>(shape, reaction, tolerances); });
}

}  // namespace stiffront
