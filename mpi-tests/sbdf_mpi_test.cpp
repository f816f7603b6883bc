// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "stiffront/control/evolve.hpp"
#include "stiffront/control/sbdf.hpp"
#include "stiffront/model/builtin/bz.hpp"
#include "stiffront/model/builtin/pulse.hpp"
#include "support/diffusion_problem.hpp"

namespace stiffront {
namespace {

using testing::both_sides;
using testing::DiffusionProblem;
using testing::scatter;
using testing::unit_grid;

struct Setting {
  const char* name;
  Grid grid;
  BoundaryKind x, y;
  int order;
};
void PrintTo(const Setting& setting, std::ostream* out) { *out << setting.name; }

/// Every layout of the ranks over the grid.
std::vector<std::array<int, 2>> layouts(int ranks, const Grid& grid) {
  std::vector<std::array<int, 2>> all;
  for (int p = 1; p <= ranks; ++p) {
    if (ranks % p != 0) continue;
    if (grid.dimension == 1 && p != ranks) continue;
    all.push_back({p, ranks / p});
  }
  return all;
}

struct Outcome {
  Field u;
  std::vector<double> dt;
  std::vector<double> error;
  Work work;
};

class Recorder final : public Observer {
 public:
  Recorder(Outcome& outcome, std::int64_t steps) : outcome_(&outcome), steps_(steps) {}
  void attempted(const StepRecord& r) override {
    outcome_->dt.push_back(r.dt);
    outcome_->error.push_back(r.attempt.error);
    outcome_->work += r.attempt.work;
  }
  bool carry_on(std::uint64_t, std::int64_t step, double, double, Field&) override { return step < steps_; }

 private:
  Outcome* outcome_;
  std::int64_t steps_;
};

template <class M>
Outcome run(const DiffusionProblem& p, double tolerance, const std::vector<double>& amplitude, int max_sweeps, int depth = 0,
            std::int64_t steps = 100, bool rough = true) {
  ModelKernelsOf<M> model({});
  CoupledRhs rhs(p.decomposition, p.diffusion, model);
  Outcome r{p.field([&](int s, double x, double y) {
              const auto species = static_cast<std::size_t>(s);
              if (!rough) return amplitude[species] * (1.0 + 0.3 * std::cos(6.0 * x + 2.0) * std::cos(5.0 * y));
              return amplitude[species] * (0.2 + (x + y < 0.4 ? 1.0 : 0.0) + 0.01 * scatter(std::lround(1e6 * x), std::lround(1e6 * y), s));
            }),
            {},
            {},
            {}};
  SbdfOptions options;
  options.relative_tolerance = tolerance;
  options.max_sweeps = max_sweeps;
  options.wavefront_depth = depth;
  Sbdf method(r.u, rhs, model, options);
  Progress progress;
  Recorder recorder(r, steps);
  evolve(method, Schedule{}, r.u, progress, recorder);
  return r;
}

class SbdfMpi : public ::testing::TestWithParam<Setting> {};

TEST_P(SbdfMpi, StepsAndBitsDoNotDependOnTheNumberOfRanks) {
  const Setting& setting = GetParam();
  const Communicator world(MPI_COMM_WORLD);
  const Communicator self(MPI_COMM_SELF);
  const auto value = [](double t, double x, double y) { return 0.3 + 0.1 * std::cos(9.0 * t) + 0.1 * x * y; };
  std::int64_t coupled = 0;
  const auto compare = [&]<class M>(const M&, std::vector<double> diffusion, const std::vector<double>& amplitude,
                                    int max_sweeps = sbdf_max_sweeps, std::int64_t steps = 100, bool rough = true) {
    const std::array<std::array<BoundarySide, 2>, 2> sides{both_sides(setting.x, M::n_species, value, true),
                                                           both_sides(setting.y, M::n_species, value, true)};
    const DiffusionProblem alone(self, setting.grid, sides, diffusion, setting.order);
    for (double tolerance : {1e-2, 1e-5}) {
      const Outcome expected = run<M>(alone, tolerance, amplitude, max_sweeps, 0, steps, rough);
      coupled += expected.work.line_solves + expected.work.linear_iterations;
      if (tolerance == 1e-2 && max_sweeps > 1) {
        EXPECT_GT(expected.work.sweeps, static_cast<std::int64_t>(expected.dt.size())) << "several sweeps a step are tested";
      }
      for (const std::array<int, 2>& layout : layouts(world.size(), setting.grid)) {
        const DiffusionProblem shared(world, setting.grid, sides, diffusion, setting.order, layout);
        const std::int64_t before = world.reductions();
        const Outcome got = run<M>(shared, tolerance, amplitude, max_sweeps, 0, steps, rough);
        EXPECT_EQ(got.dt, expected.dt);
        EXPECT_EQ(got.error, expected.error);
        // One exchange per step where a division does not cut a periodic direction in x.
        const bool served = setting.x != BoundaryKind::periodic || layout[0] == 1;
        if (served && world.size() > 1 && got.work.line_solves + got.work.linear_iterations == 0 &&
            got.work.sweeps > static_cast<std::int64_t>(got.dt.size()) && got.work.sweeps < 8 * static_cast<std::int64_t>(got.dt.size())) {
          EXPECT_LT(got.work.halo_exchanges, got.work.sweeps) << "steps of several sweeps exchange once";
        }
        EXPECT_LE(got.work.halo_exchanges, got.work.sweeps + got.work.line_solves + got.work.linear_iterations);
        EXPECT_EQ(got.work.line_solves, expected.work.line_solves);
        EXPECT_EQ(got.work.linear_iterations, expected.work.linear_iterations);
        // One agreement per attempt, and those of the first step.
        EXPECT_LE(world.reductions() - before, static_cast<std::int64_t>(got.dt.size()) + 3);
        const Decomposition& d = shared.decomposition;
        for (int s = 0; s < M::n_species; ++s) {
          for (int j = 0; j < got.u.n_y(); ++j) {
            for (int i = 0; i < got.u.n_x(); ++i) {
              ASSERT_EQ(got.u.at(s, i, j), expected.u.at(s, static_cast<int>(d.offset_x()) + i, static_cast<int>(d.offset_y()) + j))
                  << s << ' ' << i << ' ' << j;
            }
          }
        }
      }
    }
  };
  const bool large = setting.grid.points[0] * setting.grid.points[1] > 5000;
  if (!large) compare(Bz{}, {0.25, 0.25, 0.15}, {5.0, 0.5, 0.2});
  const std::int64_t before = coupled;
  setting.grid.dimension == 1 ? compare(Pulse{}, {100.0, 0.0}, {1.0, 1.0}, 1, 250)
                              : compare(Pulse{}, {3000.0, 0.0}, {1.0, 1.0}, sbdf_max_sweeps, 75, false);
  EXPECT_GT(coupled, before) << "cells are coupled where diffusion is stiff";
  if (!large) compare(Pulse{}, {0.5, 0.0}, {1.0, 1.0});
}

// Sweeps per pass over memory, and next to other ranks per exchange: deeper steps there exchange for every sweep.
TEST_P(SbdfMpi, BitsDoNotDependOnTheDepth) {
  const Setting& setting = GetParam();
  if (setting.grid.points[0] * setting.grid.points[1] > 5000) GTEST_SKIP() << "smaller grids show it";
  const Communicator world(MPI_COMM_WORLD);
  const Communicator self(MPI_COMM_SELF);
  const auto value = [](double t, double x, double y) { return 0.3 + 0.1 * std::cos(9.0 * t) + 0.1 * x * y; };
  const std::array<std::array<BoundarySide, 2>, 2> sides{both_sides(setting.x, Bz::n_species, value, true),
                                                         both_sides(setting.y, Bz::n_species, value, true)};
  const std::vector<double> diffusion{200.0, 200.0, 120.0};
  const std::vector<double> amplitude{5.0, 0.5, 0.2};
  const DiffusionProblem alone(self, setting.grid, sides, diffusion, setting.order);
  const Outcome expected = run<Bz>(alone, 1e-2, amplitude, sbdf_max_sweeps, 1, 80);
  if (setting.grid.dimension == 2) {
    EXPECT_GT(expected.work.sweeps, 2 * static_cast<std::int64_t>(expected.dt.size())) << "steps of many sweeps are tested";
  }
  const std::array<int, 2> layout = layouts(world.size(), setting.grid)[layouts(world.size(), setting.grid).size() / 2];
  const DiffusionProblem shared(world, setting.grid, sides, diffusion, setting.order, layout);
  for (int depth = 1; depth <= 16; ++depth) {
    const Outcome got = run<Bz>(shared, 1e-2, amplitude, sbdf_max_sweeps, depth, 80);
    EXPECT_EQ(got.error, expected.error) << "depth " << depth;
    const Decomposition& d = shared.decomposition;
    int different = 0;
    for (int s = 0; s < Bz::n_species; ++s) {
      for (int j = 0; j < got.u.n_y(); ++j) {
        for (int i = 0; i < got.u.n_x(); ++i) {
          if (got.u.at(s, i, j) != expected.u.at(s, static_cast<int>(d.offset_x()) + i, static_cast<int>(d.offset_y()) + j)) ++different;
        }
      }
    }
    EXPECT_EQ(different, 0) << "depth " << depth;
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, SbdfMpi,
    ::testing::Values(Setting{"plane_neumann_periodic_2", unit_grid(67, 17, false, true), BoundaryKind::neumann, BoundaryKind::periodic, 2},
                      Setting{"plane_neumann_periodic_4", unit_grid(67, 33, false, true), BoundaryKind::neumann, BoundaryKind::periodic, 4},
                      Setting{"plane_periodic_neumann_2", unit_grid(33, 67, true, false), BoundaryKind::periodic, BoundaryKind::neumann, 2},
                      Setting{"line_neumann_2", unit_grid(203, 1), BoundaryKind::neumann, BoundaryKind::neumann, 2},
                      Setting{"line_dirichlet_4", unit_grid(101, 1), BoundaryKind::dirichlet, BoundaryKind::neumann, 4},
                      Setting{"line_periodic_4", unit_grid(97, 1, true), BoundaryKind::periodic, BoundaryKind::neumann, 4},
                      Setting{"square_neumann_2", unit_grid(61, 47), BoundaryKind::neumann, BoundaryKind::neumann, 2},
                      Setting{"square_neumann_4", unit_grid(45, 52), BoundaryKind::neumann, BoundaryKind::neumann, 4},
                      Setting{"square_with_divided_coarser_grids_4", unit_grid(90, 101), BoundaryKind::neumann, BoundaryKind::neumann, 4},
                      Setting{"square_periodic_2", unit_grid(40, 37, true, true), BoundaryKind::periodic, BoundaryKind::periodic, 2},
                      Setting{"square_mixed_4", unit_grid(50, 33, false, true), BoundaryKind::dirichlet, BoundaryKind::periodic, 4},
                      Setting{"square_dirichlet_2", unit_grid(33, 50), BoundaryKind::neumann, BoundaryKind::dirichlet, 2}),
    [](const auto& parameter) { return std::string(parameter.param.name); });

}  // namespace
}  // namespace stiffront
