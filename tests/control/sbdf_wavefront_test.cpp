// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/sbdf_wavefront.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "stiffront/control/evolve.hpp"
#include "stiffront/control/sbdf.hpp"
#include "stiffront/model/builtin/bz.hpp"
#include "support/diffusion_problem.hpp"

namespace stiffront {
namespace {

using testing::both_sides;
using testing::DiffusionProblem;
using testing::scatter;
using testing::unit_grid;

struct Outcome {
  Field u;
  std::int64_t steps = 0;
  std::int64_t sweeps = 0;
};

class Count final : public Observer {
 public:
  explicit Count(Outcome& run) : outcome_(&run) {}
  void attempted(const StepRecord& r) override {
    ++outcome_->steps;
    outcome_->sweeps += r.attempt.work.sweeps;
  }
  bool carry_on(std::uint64_t, std::int64_t step, double, double, Field&) override { return step < 120; }

 private:
  Outcome* outcome_;
};

Outcome run(const DiffusionProblem& p, int depth, int steps = 0, double tolerance = 1e-2) {
  ModelKernelsOf<Bz> model({});
  CoupledRhs rhs(p.decomposition, p.diffusion, model);
  Outcome r{p.field([](int s, double x, double y) {
    constexpr double size[] = {5.0, 0.5, 0.2};
    return size[s] * (0.2 + (x + y < 0.4 ? 1.0 : 0.0) + 0.01 * scatter(std::lround(1e6 * x), std::lround(1e6 * y), s));
  })};
  SbdfOptions options;
  options.relative_tolerance = tolerance;
  options.wavefront_depth = depth;
  options.wavefront_steps = steps;
  Sbdf method(r.u, rhs, model, options);
  Progress progress;
  Count count(r);
  evolve(method, Schedule{}, r.u, progress, count);
  return r;
}

// Depth 1 is a pass per sweep.
TEST(SbdfWavefront, BitsDoNotDependOnTheDepth) {
  const Communicator self(MPI_COMM_SELF);
  for (BoundaryKind kind : {BoundaryKind::neumann, BoundaryKind::periodic}) {
    const bool periodic = kind == BoundaryKind::periodic;
    for (int order : {2, 4}) {
      const DiffusionProblem p(self, unit_grid(21, 70, periodic, periodic),
                               {both_sides(kind, 3), both_sides(kind, 3)}, {200.0, 200.0, 120.0}, order);
      const Outcome expected = run(p, 1);
      EXPECT_GT(expected.sweeps, 3 * expected.steps) << "steps of many sweeps are tested";
      for (int depth : {0, 2, 3, 5, 16}) {
        const Outcome got = run(p, depth);
        ASSERT_EQ(got.steps, expected.steps);
        for (int s = 0; s < 3; ++s) {
          for (int j = 0; j < 70; ++j) {
            for (int i = 0; i < 21; ++i) ASSERT_EQ(got.u.at(s, i, j), expected.u.at(s, i, j)) << depth << ' ' << i << ' ' << j;
          }
        }
      }
    }
  }
}

// Steps made ahead are used when nothing changes and thrown away when something does.
TEST(SbdfWavefront, BitsDoNotDependOnTheStepsInAPass) {
  const Communicator self(MPI_COMM_SELF);
  for (double tolerance : {1e-2, 1e-4}) {
    for (int order : {2, 4}) {
      const DiffusionProblem p(self, unit_grid(21, 70), {both_sides(BoundaryKind::neumann, 3), both_sides(BoundaryKind::neumann, 3)},
                               {0.5, 0.5, 0.3}, order);
      const Outcome expected = run(p, 16, 1, tolerance);
      for (int steps : {2, 3}) {
        const Outcome got = run(p, 16, steps, tolerance);
        ASSERT_EQ(got.steps, expected.steps);
        ASSERT_EQ(got.sweeps, expected.sweeps);
        for (int s = 0; s < 3; ++s) {
          for (int j = 0; j < 70; ++j) {
            for (int i = 0; i < 21; ++i) ASSERT_EQ(got.u.at(s, i, j), expected.u.at(s, i, j)) << steps << ' ' << i << ' ' << j;
          }
        }
      }
    }
  }
}

TEST(SbdfWavefront, ServesBoxesThatAreAlone) {
  const Communicator self(MPI_COMM_SELF);
  const auto serves = [&](const Grid& grid, BoundaryKind kind) {
    const DiffusionProblem p(self, grid, {both_sides(kind, 3, [](double, double, double) { return 0.0; }), both_sides(kind, 3, [](double, double, double) { return 0.0; })},
                             {0.5, 0.5, 0.3}, 2);
    return SbdfWavefront::serves(p.decomposition, p.boundary);
  };
  EXPECT_TRUE(serves(unit_grid(20, 20), BoundaryKind::neumann));
  EXPECT_TRUE(serves(unit_grid(20, 20, true, true), BoundaryKind::periodic));
  EXPECT_TRUE(serves(unit_grid(20, 1), BoundaryKind::neumann));
  EXPECT_FALSE(serves(unit_grid(20, 1, true), BoundaryKind::periodic));
  EXPECT_FALSE(serves(unit_grid(20, 20), BoundaryKind::dirichlet));
}

}  // namespace
}  // namespace stiffront
