// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/solvers/trapezoidal_cells.hpp"

#include <cmath>
#include <optional>
#include <utility>

#include "species_count.hpp"
#include "stiffront/solvers/cell_solve.hpp"

namespace stiffront {
namespace {

constexpr int most_iterations = 50;

template <int m>
class TrapezoidalCells final : public ReactionSolver {
 public:
  TrapezoidalCells(const ReactionTerm& reaction, CellTolerances tolerances) : reaction_(&reaction), tolerances_(std::move(tolerances)) {}

  void begin(const Grid& grid, double t, double dt) override {
    grid_ = &grid;
    t_ = t;
    dt_ = dt;
  }

  void run(const CellRun& cells) override {
    const double y = grid_->dimension == 2 ? grid_->position(1, cells.j) : 0.0;
    for (int k = 0; k < cells.n; ++k) {
      const double x = grid_->position(0, cells.i + k);
      double from[m];
      double value[m];
      for (int s = 0; s < m; ++s) value[s] = from[s] = cells.from[s * cells.from_stride + k];
      const bool solved = step(x, y, value, cells.cost[k]);
      if (!solved) note_failure(cells.i + k, cells.j, x, y, from);
      for (int s = 0; s < m; ++s) cells.to[s * cells.to_stride + k] = solved ? value[s] : from[s];
    }
  }

  std::optional<CellFailure> finish(Work& work) override {
    work += std::exchange(work_, Work{});
    return std::exchange(first_, std::nullopt);
  }

 private:
  /// @return whether Newton's iteration converges; then the values are those at the end
  bool step(double x, double y, double* value, float& cost) {
    const double h = 0.5 * dt_;
    double base[m];
    double rates[m];
    double jacobian[m * m];
    reaction_->rates_at(t_, x, y, value, rates);
    for (int s = 0; s < m; ++s) base[s] = value[s] + h * rates[s];
    ++work_.reaction_steps;
    for (int iteration = 1; iteration <= most_iterations; ++iteration) {
      reaction_->rates_at(t_ + dt_, x, y, value, rates);
      reaction_->jacobian_at(t_ + dt_, x, y, value, jacobian);
      ++work_.reaction_rhs;
      ++work_.reaction_jacobians;
      ++work_.reaction_newton_iterations;
      cost = static_cast<float>(iteration);
      CellLu<double, m, true> lu;
      double change[m];
      for (int r = 0; r < m; ++r) {
        change[r] = base[r] + h * rates[r] - value[r];
        for (int c = 0; c < m; ++c) lu(r, c) = (r == c ? 1.0 : 0.0) - h * jacobian[r * m + c];
      }
      lu.factor();
      lu.solve(change);
      bool converged = true;
      for (int r = 0; r < m; ++r) {
        value[r] += change[r];
        converged = converged &&
                    std::abs(change[r]) <= tolerances_.absolute[static_cast<std::size_t>(r)] + tolerances_.relative * std::abs(value[r]);
      }
      if (converged) return true;
    }
    return false;
  }

  void note_failure(std::int64_t i, std::int64_t j, double x, double y, const double* state) {
    if (first_ && std::pair(first_->j, first_->i) < std::pair(j, i)) return;
    first_.emplace();
    first_->i = i;
    first_->j = j;
    first_->x = x;
    first_->y = y;
    first_->begin = first_->t = t_;
    first_->dt = first_->interval = dt_;
    first_->state.assign(state, state + m);
    first_->reason = "Newton's iteration for the trapezoidal rule does not converge";
  }

  const ReactionTerm* reaction_;
  CellTolerances tolerances_;
  const Grid* grid_ = nullptr;
  double t_ = 0.0;
  double dt_ = 0.0;
  Work work_;
  std::optional<CellFailure> first_;
};

}  // namespace

std::unique_ptr<ReactionSolver> make_trapezoidal_cells(const ReactionTerm& reaction, const CellTolerances& tolerances) {
  return for_species_count<std::unique_ptr<ReactionSolver>>(
      reaction.n_species(), [&]<int m>() { return std::make_unique<TrapezoidalCells<m>>(reaction, tolerances); });
}

}  // namespace stiffront
