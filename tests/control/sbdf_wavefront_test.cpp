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

struct Sides {
  BoundaryKind x, y;
};

// Depth 1 is a pass per sweep.
TEST(SbdfWavefront, BitsDoNotDependOnTheDepth) {
  const Communicator self(MPI_COMM_SELF);
  const auto value = [](double t, double x, double y) { return 0.2 * (1.0 + x * y) * (2.0 + std::cos(1e3 * t)); };
  for (const Sides sides : {Sides{BoundaryKind::neumann, BoundaryKind::neumann}, Sides{BoundaryKind::periodic, BoundaryKind::periodic},
                            Sides{BoundaryKind::dirichlet, BoundaryKind::dirichlet}, Sides{BoundaryKind::dirichlet, BoundaryKind::periodic},
                            Sides{BoundaryKind::periodic, BoundaryKind::dirichlet}}) {
    for (int order : {2, 4}) {
      const Grid grid = unit_grid(21, 70, sides.x == BoundaryKind::periodic, sides.y == BoundaryKind::periodic);
      const DiffusionProblem p(self, grid, {both_sides(sides.x, 3, value, true), both_sides(sides.y, 3, value, true)},
                               {200.0, 200.0, 120.0}, order);
      const Outcome expected = run(p, 1);
      EXPECT_GT(expected.sweeps, 3 * expected.steps) << "steps of many sweeps are tested";
      for (int depth = 0; depth <= 16; ++depth) {
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

TEST(SbdfWavefront, ServesEveryBoxOfASingleRank) {
  const Communicator self(MPI_COMM_SELF);
  for (const bool periodic : {false, true}) {
    for (const int n_y : {1, 20}) {
      EXPECT_TRUE(SbdfWavefront::serves(Decomposition(self, unit_grid(20, n_y, periodic, periodic), {0, 0}, 4)));
    }
  }
}

}  // namespace
}  // namespace stiffront
