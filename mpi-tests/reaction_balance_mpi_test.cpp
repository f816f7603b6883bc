// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "stiffront/model/builtin/bz.hpp"
#include "stiffront/solvers/cvode_cells.hpp"
#include "stiffront/solvers/model_kernels.hpp"
#include "stiffront/splitting/reaction_balance.hpp"
#include "stiffront/splitting/reaction_flow.hpp"
#include "support/diffusion_problem.hpp"

namespace stiffront {
namespace {

using testing::both_sides;
using testing::DiffusionProblem;
using testing::scatter;
using testing::unit_grid;

/// The excited corner of the grid is where x + y is less.
constexpr double corner = 0.6;

/// The rest is at rest.
double excited_corner(int s, double x, double y) {
  const double noise = scatter(std::lround(1e6 * x), std::lround(1e6 * y));
  // Cells of the corner are somewhere in a front, a out of balance.
  const bool excited = x + y < corner;
  const double b = excited ? std::pow(10.0, -3.0 + 2.5 * noise) : 2e-3;
  const double c = 0.05 + 0.001 * noise;
  const double values[] = {1.6 * c / (2e-3 + b) * (excited ? 30.0 : 1.0), b, c};
  return values[s];
}

/// One state, its hints and its costs, under one solver.
struct Cells {
  explicit Cells(const DiffusionProblem& p) : from(p.field(excited_corner)), to(from.similar()), hint(size(p), 0.0), cost(size(p), 0.0F) {}
  static std::size_t size(const DiffusionProblem& p) {
    return static_cast<std::size_t>(p.decomposition.n_x()) * static_cast<std::size_t>(p.decomposition.n_y());
  }
  Field from, to;
  std::vector<double> hint;
  std::vector<float> cost;
  Work work;
};

void expect_same(const Cells& a, const Cells& b) {
  EXPECT_EQ(a.hint, b.hint);
  EXPECT_EQ(a.cost, b.cost);
  for (int s = 0; s < 3; ++s) {
    for (int j = 0; j < a.to.n_y(); ++j) {
      for (int i = 0; i < a.to.n_x(); ++i) ASSERT_EQ(a.to.at(s, i, j), b.to.at(s, i, j)) << s << ' ' << i << ' ' << j;
    }
  }
}

class ReactionBalanceMpi : public ::testing::Test {
 protected:
  Communicator world_{MPI_COMM_WORLD};
  ModelKernelsOf<Bz> model_{{}};
  CellTolerances tolerances_{1e-6, {1e-6, 1e-6, 1e-6}};

  /// Calls of several lengths, in place and not, with and without balancing.
  BalanceCounts compare(const Grid& grid, BoundaryKind kind, ReactionSolver& solver, int largest_group, std::vector<double> lengths) {
    const auto value = [](double, double, double) { return 0.003; };
    const DiffusionProblem p(world_, grid, {both_sides(kind, 3, value), both_sides(BoundaryKind::neumann, 3)}, {1.0, 1.0, 1.0}, 2);
    const FreeBox box = p.boundary.free_box(p.decomposition);
    ReactionBalance balance(p.decomposition, box, largest_group);
    Cells with(p);
    Cells without(p);
    double t = 0.0;
    for (double dt : lengths) {
      EXPECT_FALSE(balance.advance(solver, t, dt, with.from, with.to, with.hint, with.cost, with.work));
      EXPECT_FALSE(solver.advance(t, dt, without.from, without.to, box, without.hint, without.cost, without.work));
      expect_same(with, without);
      t += dt;
      // And on from there, in place.
      EXPECT_FALSE(balance.advance(solver, t, 0.1 * dt, with.to, with.to, with.hint, with.cost, with.work));
      EXPECT_FALSE(solver.advance(t, 0.1 * dt, without.to, without.to, box, without.hint, without.cost, without.work));
      expect_same(with, without);
      t += 0.1 * dt;
      swap(with.from, with.to);
      swap(without.from, without.to);
    }
    for (const auto count : {&Work::reaction_steps, &Work::reaction_rejections, &Work::reaction_newton_iterations, &Work::reaction_rhs,
                             &Work::reaction_jacobians}) {
      EXPECT_EQ(world_.sum(with.work.*count), world_.sum(without.work.*count)) << "moved work is counted once";
    }
    return balance.counts();
  }
};

TEST_F(ReactionBalanceMpi, BitsHintsAndCostsAreThoseWithoutBalancing) {
  const auto radau = model_.make_radau5(tolerances_);
  const std::vector<double> lengths{2e-3, 2e-3, 1.5e-3, 4e-3, 1e-4, 1e-4, 2e-3};
  for (int largest_group : {1024, 2}) {
    compare(unit_grid(203, 1), BoundaryKind::neumann, *radau, largest_group, lengths);
    compare(unit_grid(67, 61), BoundaryKind::neumann, *radau, largest_group, lengths);
    compare(unit_grid(67, 61), BoundaryKind::dirichlet, *radau, largest_group, lengths);
  }
  CvodeCells cvode(model_, tolerances_);
  compare(unit_grid(41, 23), BoundaryKind::neumann, cvode, 1024, {2e-3, 2e-3});
}

TEST_F(ReactionBalanceMpi, TheBusiestRankDoesFivePercentMoreThanTheMeanInsteadOfTwiceAsMuch) {
  const auto radau = model_.make_radau5(tolerances_);
  const DiffusionProblem p(world_, unit_grid(96, 96), {both_sides(BoundaryKind::neumann, 3), both_sides(BoundaryKind::neumann, 3)},
                           {1.0, 1.0, 1.0}, 2);
  ReactionBalance balance(p.decomposition, p.boundary.free_box(p.decomposition));
  Cells cells(p);
  constexpr int calls = 24;
  for (int n = 0; n < calls; ++n) {
    EXPECT_FALSE(balance.advance(*radau, 0.0, 2e-2, cells.from, cells.to, cells.hint, cells.cost, cells.work));
  }
  const BalanceCounts c = balance.counts();
  EXPECT_EQ(world_.sum(static_cast<std::int64_t>(c.work_owned)), world_.sum(static_cast<std::int64_t>(c.work_done)));
  const double before = c.largest_owned / c.mean;
  const double after = c.largest_done / c.mean;
  if (world_.size() == 1) {
    EXPECT_EQ(before, 1.0);
    EXPECT_EQ(c.messages_sent, 0);
    return;
  }
  EXPECT_GT(before, 1.25);
  // The first call has nothing to go by.
  EXPECT_LT(after, 1.05 + (before - 1.0) / calls);
  EXPECT_GT(world_.sum(c.messages_sent), 0);
  EXPECT_LT(world_.sum(c.cells_sent), 96 * 96 * calls / 10) << "few cells move";
}

TEST_F(ReactionBalanceMpi, ACellThatFailsElsewhereIsReportedWithItsPlaceAndLeavesItsState) {
  const auto radau = model_.make_radau5(tolerances_);
  const DiffusionProblem p(world_, unit_grid(96, 96), {both_sides(BoundaryKind::neumann, 3), both_sides(BoundaryKind::neumann, 3)},
                           {1.0, 1.0, 1.0}, 2);
  const FreeBox box = p.boundary.free_box(p.decomposition);
  ReactionBalance balance(p.decomposition, box);
  Cells cells(p);
  for (int n = 0; n < 2; ++n) {
    EXPECT_FALSE(balance.advance(*radau, 0.0, 2e-3, cells.from, cells.to, cells.hint, cells.cost, cells.work));
  }
  const std::int64_t moved_before = world_.sum(balance.counts().cells_sent);
  // Every cell of the excited corner of rank 0 fails, so that some fail where they were sent.
  for (int j = 0; j < cells.from.n_y(); ++j) {
    for (int i = 0; i < cells.from.n_x() && world_.rank() == 0; ++i) {
      if (cells.from.at(0, i, j) > 1.0) cells.from.at(0, i, j) = std::numeric_limits<double>::infinity();
    }
  }
  const auto failure = balance.advance(*radau, 0.0, 2e-3, cells.from, cells.to, cells.hint, cells.cost, cells.work);
  const std::int64_t moved = world_.sum(balance.counts().cells_sent) - moved_before;
  EXPECT_EQ(moved > 0, world_.size() > 1);
  const std::int64_t reporting = world_.sum(std::int64_t{failure.has_value()});
  EXPECT_GE(reporting, world_.size() > 1 ? 2 : 1) << "the owner, and who integrated its cells";
  if (failure) {
    EXPECT_TRUE(std::isinf(failure->state.at(0)));
    EXPECT_EQ(failure->x, p.grid.position(0, failure->i));
    EXPECT_EQ(failure->y, p.grid.position(1, failure->j));
    EXPECT_LT(failure->x + failure->y, corner);
    EXPECT_EQ(failure->reason, "the rates are not finite");
  }
  for (int j = 0; j < cells.from.n_y(); ++j) {
    for (int i = 0; i < cells.from.n_x(); ++i) {
      if (std::isinf(cells.from.at(0, i, j))) {
        EXPECT_EQ(cells.to.at(0, i, j), cells.from.at(0, i, j));
        EXPECT_EQ(cells.to.at(1, i, j), cells.from.at(1, i, j));
      }
    }
  }
}

TEST_F(ReactionBalanceMpi, AFlowBalancesIfToldTo) {
  const DiffusionProblem p(world_, unit_grid(64, 64), {both_sides(BoundaryKind::neumann, 3), both_sides(BoundaryKind::neumann, 3)},
                           {1.0, 1.0, 1.0}, 2);
  ReactionFlow with(p.decomposition, p.boundary, model_.make_radau5(tolerances_), true);
  ReactionFlow without(p.decomposition, p.boundary, model_.make_radau5(tolerances_));
  EXPECT_EQ(with.balance().has_value(), world_.size() > 1);
  EXPECT_FALSE(without.balance());
  Field a = p.field(excited_corner);
  Field b = p.field(excited_corner);
  Work work;
  for (int n = 0; n < 5; ++n) {
    EXPECT_FALSE(with.advance(0.0, 1e-3, a, a, work));
    EXPECT_FALSE(without.advance(0.0, 1e-3, b, b, work));
    for (int s = 0; s < 3; ++s) {
      for (int j = 0; j < a.n_y(); ++j) {
        for (int i = 0; i < a.n_x(); ++i) ASSERT_EQ(a.at(s, i, j), b.at(s, i, j));
      }
    }
    EXPECT_EQ(with.hints(), without.hints());
  }
}

}  // namespace
}  // namespace stiffront
