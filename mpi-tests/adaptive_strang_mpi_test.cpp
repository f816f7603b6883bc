// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "stiffront/control/adaptive_strang.hpp"
#include "stiffront/control/evolve.hpp"
#include "stiffront/model/builtin/bz.hpp"
#include "stiffront/solvers/model_kernels.hpp"
#include "stiffront/solvers/rock4.hpp"
#include "support/diffusion_problem.hpp"

namespace stiffront {
namespace {

using testing::both_sides;
using testing::DiffusionProblem;
using testing::scatter;
using testing::unit_grid;

struct Outcome {
  std::vector<double> dt, error, epsilon, critical_dt;
  std::vector<bool> accepted;
  Progress progress;
};

class Recorder final : public Observer {
 public:
  explicit Recorder(Outcome& outcome) : outcome_(&outcome) {}
  void attempted(const StepRecord& r) override {
    outcome_->dt.push_back(r.dt);
    outcome_->error.push_back(r.attempt.error);
    outcome_->epsilon.push_back(r.attempt.epsilon);
    outcome_->critical_dt.push_back(r.attempt.critical_dt);
    outcome_->accepted.push_back(r.attempt.accepted);
  }
  bool carry_on(std::uint64_t, std::int64_t step, double, double, Field&) override { return step < 40; }

 private:
  Outcome* outcome_;
};

Outcome run(const DiffusionProblem& p, double tolerance, Field& u) {
  const ModelKernelsOf<Bz> model({});
  const double inner = 0.01 * tolerance;
  const std::vector<double> absolute(3, 0.1 * inner);
  ReactionFlow reaction(p.decomposition, p.boundary, model.make_radau5({inner, absolute}));
  Rock4 diffusion(p.decomposition, p.diffusion, {inner, absolute});
  AdaptiveStrangOptions options;
  options.tolerance = tolerance;
  options.initial_step = 1e-2;  // far too long: the run begins with rejections
  options.period = 5;
  options.final_error = 1e-2;  // soon spent: the limit on the step is tested
  AdaptiveStrang method(u, p.boundary, model, reaction, diffusion, options);
  Outcome outcome;
  Recorder recorder(outcome);
  evolve(method, Schedule{}, u, outcome.progress, recorder);
  return outcome;
}

/// @return whether epsilon changed in the run
bool compare(const Grid& grid, BoundaryKind kind, int order, double tolerance) {
  const Communicator world(MPI_COMM_WORLD);
  const Communicator self(MPI_COMM_SELF);
  const auto value = [](double t, double x, double y) { return 0.003 + 0.001 * std::cos(9.0 * t) + 0.001 * x * y; };
  const std::array<std::array<BoundarySide, 2>, 2> sides{both_sides(kind, 3, value, true), both_sides(BoundaryKind::neumann, 3)};
  const auto start = [](int s, double x, double y) {
    const double amplitude[] = {5.0, 0.5, 0.2};
    return amplitude[s] * (0.2 + (x + y < 0.4 ? 1.0 : 0.0) + 0.01 * scatter(std::lround(1e6 * x), std::lround(1e6 * y), s));
  };
  const std::vector<double> coefficients{2.5e-3, 2.5e-3, 1.5e-3};
  const DiffusionProblem alone(self, grid, sides, coefficients, order);
  Field expected = alone.field(start);
  const Outcome one = run(alone, tolerance, expected);
  EXPECT_NE(std::count(one.accepted.begin(), one.accepted.end(), false), 0) << "rejections are tested";
  const DiffusionProblem shared(world, grid, sides, coefficients, order);
  Field u = shared.field(start);
  const Outcome all = run(shared, tolerance, u);
  EXPECT_EQ(all.dt, one.dt);
  EXPECT_EQ(all.error, one.error);
  EXPECT_EQ(all.epsilon, one.epsilon);
  EXPECT_EQ(all.critical_dt, one.critical_dt);
  EXPECT_EQ(all.accepted, one.accepted);
  EXPECT_EQ(all.progress.t, one.progress.t);
  const Decomposition& d = shared.decomposition;
  for (int s = 0; s < 3; ++s) {
    for (int j = 0; j < u.n_y(); ++j) {
      for (int i = 0; i < u.n_x(); ++i) {
        EXPECT_EQ(u.at(s, i, j), expected.at(s, static_cast<int>(d.offset_x()) + i, static_cast<int>(d.offset_y()) + j))
            << s << ' ' << i << ' ' << j;
      }
    }
  }
  return *std::max_element(one.epsilon.begin(), one.epsilon.end()) != *std::min_element(one.epsilon.begin(), one.epsilon.end());
}

TEST(AdaptiveStrangMpi, BitsRejectionsAndEpsilonDoNotDependOnTheNumberOfRanks) {
  int changes = 0;
  for (double tolerance : {1e-3, 1e-6}) {
    changes += compare(unit_grid(203, 1), BoundaryKind::neumann, 2, tolerance);
    changes += compare(unit_grid(101, 1), BoundaryKind::dirichlet, 4, tolerance);
    changes += compare(unit_grid(45, 38), BoundaryKind::neumann, 2, tolerance);
  }
  EXPECT_GE(changes, 3) << "changes of epsilon are tested";
}

}  // namespace
}  // namespace stiffront
