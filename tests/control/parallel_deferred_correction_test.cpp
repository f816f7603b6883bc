// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/parallel_deferred_correction.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "stiffront/control/evolve.hpp"
#include "stiffront/core/error.hpp"
#include "stiffront/model/builtin/brusselator.hpp"
#include "support/grids.hpp"
#include "support/order_fit.hpp"

namespace stiffront {
namespace {

using Options = ParallelDeferredCorrectionOptions;

/// The Brusselator over one time unit from smooth data, on an interval or a rectangle.
class BrusselatorProblem {
 public:
  explicit BrusselatorProblem(Grid grid, const testing::Sides& along_x = testing::neumann, int order = 2)
      : comm_(MPI_COMM_SELF),
        grid_(grid),
        boundary_(testing::boundary_of(along_x, testing::neumann, 2, [](double, double, double) { return 1.0; })),
        decomposition_(comm_, grid_, {1, 1}, 2),
        diffusion_(grid_, boundary_, {0.02, 0.01}, order),
        model_({{"A", 1.0}, {"B", 3.0}}),
        rhs_(decomposition_, diffusion_, model_) {}

  Field solve(Options o, Progress* progress = nullptr) {
    Field u(decomposition_, 2, 2);
    for (int j = 0; j < u.n_y(); ++j) {
      for (int i = 0; i < u.n_x(); ++i) {
        const double x = 2.0 * M_PI * grid_.position(0, i), y = grid_.dimension == 2 ? M_PI * grid_.position(1, j) : 0.0;
        u.at(0, i, j) = 1.0 + 0.3 * std::sin(x) * std::cos(y);
        u.at(1, i, j) = 3.0 + 0.4 * std::cos(x) * std::cos(y);
      }
    }
    boundary_.impose(u, 0.0);
    ParallelDeferredCorrection method(u, rhs_, model_, o);
    Schedule schedule;
    schedule.end = 1.0;
    Progress own;
    Observer nobody;
    evolve(method, schedule, u, progress == nullptr ? own : *progress, nobody);
    return u;
  }
  Field solve(int steps, int nodes, int k, int corrections) {
    Options o;
    o.fixed_step = 1.0 / steps;
    o.node_count = nodes;
    o.starting_order = k;
    o.corrections = corrections;
    return solve(o);
  }
  double order(const Field& exact, int nodes, int k, int corrections, std::vector<int> steps) {
    std::vector<double> h, error;
    for (int n : steps) {
      h.push_back(1.0 / n);
      error.push_back(distance(exact, solve(n, nodes, k, corrections)));
    }
    return testing::observed_order(h, error);
  }

  static double distance(const Field& a, const Field& b) {
    double largest = 0.0;
    for (int s = 0; s < 2; ++s) {
      for (int j = 0; j < a.n_y(); ++j) {
        for (int i = 0; i < a.n_x(); ++i) largest = std::max(largest, std::abs(a.at(s, i, j) - b.at(s, i, j)));
      }
    }
    return largest;
  }

 private:
  Communicator comm_;
  Grid grid_;
  Boundary boundary_;
  Decomposition decomposition_;
  DiffusionOperator diffusion_;
  ModelKernelsOf<Brusselator> model_;
  CoupledRhs rhs_;
};

TEST(ParallelDeferredCorrectionTest, EverySweepAddsAnOrderUpToThatOfTheQuadrature) {
  BrusselatorProblem problem(testing::unit_grid(21, 0, testing::neumann));
  const Field exact = problem.solve(320, 5, 2, 8);
  for (int corrections = 0; corrections <= 3; ++corrections) {
    EXPECT_NEAR(problem.order(exact, 3, 2, corrections, {40, 80, 160}), 2.0 + corrections, 0.4) << corrections << " corrections";
  }
  EXPECT_NEAR(problem.order(exact, 3, 2, 6, {20, 40}), 5.0, 0.5);
  EXPECT_NEAR(problem.order(exact, 2, 2, 4, {40, 80, 160}), 3.0, 0.3);
}

TEST(ParallelDeferredCorrectionTest, AStartOfHigherOrderSavesSweeps) {
  BrusselatorProblem problem(testing::unit_grid(21, 0, testing::neumann));
  const Field exact = problem.solve(320, 5, 2, 8);
  EXPECT_NEAR(problem.order(exact, 4, 3, 1, {80, 160, 320}), 4.0, 0.5);
}

TEST(ParallelDeferredCorrectionTest, HasItsOrderInTwoDimensionsAndWithDifferencesOfOrderFour) {
  BrusselatorProblem plane(testing::unit_grid(21, 18, testing::periodic), testing::periodic);
  EXPECT_NEAR(plane.order(plane.solve(200, 5, 2, 8), 3, 2, 2, {40, 80}), 4.0, 0.4);
  BrusselatorProblem fourth(testing::unit_grid(21, 18, testing::neumann), testing::neumann, 4);
  EXPECT_NEAR(fourth.order(fourth.solve(320, 5, 2, 8), 3, 2, 2, {40, 80}), 4.0, 0.4);
}

TEST(ParallelDeferredCorrectionTest, RowsShorterThanAPackAndDirichletSidesAreServed) {
  BrusselatorProblem narrow(testing::unit_grid(6, 9, testing::dirichlet), testing::dirichlet);
  EXPECT_NEAR(narrow.order(narrow.solve(200, 5, 2, 8), 3, 2, 1, {40, 80}), 3.0, 0.4);
}

TEST(ParallelDeferredCorrectionTest, ErrorsOfAdaptiveStepsFollowTheTolerance) {
  BrusselatorProblem problem(testing::unit_grid(21, 0, testing::neumann));
  const Field exact = problem.solve(320, 5, 2, 8);
  for (double tolerance : {1e-5, 1e-7, 1e-9, 1e-11}) {
    Options o;
    o.tolerance = tolerance;
    o.node_count = 5;
    o.corrections = 7;
    Progress progress;
    EXPECT_LT(BrusselatorProblem::distance(exact, problem.solve(o, &progress)), 30.0 * tolerance);
  }
}

TEST(ParallelDeferredCorrectionTest, OptionsOutOfRangeAreRefused) {
  BrusselatorProblem problem(testing::unit_grid(21, 0, testing::neumann));
  const auto refused = [&](auto&& change) {
    Options o;
    o.fixed_step = 0.1;
    change(o);
    EXPECT_THROW(problem.solve(o), Error);
  };
  refused([](Options& o) { o.node_count = 9; });
  refused([](Options& o) { o.starting_order = 5; });
  refused([](Options& o) { o.fixed_step = 0.0; });
  refused([](Options& o) { o.corrections = -1; });
  refused([](Options& o) { o.shift = -1.0; });
}

}  // namespace
}  // namespace stiffront
