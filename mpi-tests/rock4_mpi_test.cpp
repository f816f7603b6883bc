// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "stiffront/solvers/halo_depth.hpp"
#include "stiffront/solvers/rock4.hpp"
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

constexpr int n_species = 3;
constexpr int n_states = 2;

std::array<std::array<BoundarySide, 2>, 2> sides(const Setting& setting) {
  const auto value = [](double t, double x, double y) { return std::cos(t) + x * y; };
  return {both_sides(setting.x, n_species, value, true), both_sides(setting.y, n_species, value, true)};
}

/// Every layout of the ranks over the grid that leaves boxes wide enough.
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
  std::vector<Field> states;
  Work work;
  std::vector<double> step;
  std::optional<CellFailure> failure;
};

Field rough_field(const DiffusionProblem& p, int k, int depth = 1) {
  return p.field(depth, [k](int s, double x, double y) {
    return std::floor(3.0 * x + 0.2 * k) + 1e-3 * scatter(std::lround(1e7 * x), std::lround(1e7 * y), 2 * k + s);
  });
}

/// Two calls, begun with a step that is too long, so that there are rejections.
Outcome run(const DiffusionProblem& p, const Rock4Tolerances& tolerances, int depth = 1) {
  Outcome r;
  std::vector<Field> from;
  for (int k = 0; k < n_states; ++k) {
    from.push_back(rough_field(p, k, depth));
    r.states.push_back(p.field(depth));
  }
  Rock4 flow(p.decomposition, p.diffusion, tolerances, depth);
  const double first = 0.2;
  flow.set_state(std::span<const double>(&first, 1));
  std::vector<Transition> transitions;
  for (std::size_t k = 0; k < n_states; ++k) transitions.push_back({&from[k], &r.states[k]});
  r.failure = flow.advance(0.0, 0.2, transitions, r.work);
  for (std::size_t k = 0; k < n_states; ++k) transitions[k].from = &r.states[k];
  if (!r.failure) r.failure = flow.advance(0.2, 0.05, transitions, r.work);
  r.step = flow.state();
  return r;
}

class Rock4OnManyRanksTest : public ::testing::TestWithParam<Setting> {};

TEST_P(Rock4OnManyRanksTest, FieldsStepsAndCountsHaveTheBitsOfOneRankOnEveryLayout) {
  const Setting& setting = GetParam();
  const Communicator self(MPI_COMM_SELF);
  const Communicator world(MPI_COMM_WORLD);
  const std::vector<double> coefficients{0.02, 0.0, 0.05};
  const Rock4Tolerances tolerances{1e-5, {1e-5, 1e-5, 1e-5}};
  DiffusionProblem whole(self, setting.grid, sides(setting), coefficients, setting.order);
  const Outcome expected = run(whole, tolerances);
  ASSERT_FALSE(expected.failure);
  EXPECT_GT(expected.work.diffusion_rejections, 0);
  EXPECT_GT(expected.work.diffusion_steps, 4);

  for (const std::array<int, 2>& layout : layouts(world.size(), setting.grid)) {
    for (int depth = 1; depth <= 16; ++depth) {
      DiffusionProblem part(world, setting.grid, sides(setting), coefficients, setting.order, layout);
      const std::int64_t exchanges_before = world.traffic().halo_exchanges;
      const Outcome found = run(part, tolerances, depth);
      ASSERT_FALSE(found.failure);
      EXPECT_EQ(found.work.diffusion_steps, expected.work.diffusion_steps);
      EXPECT_EQ(found.work.diffusion_rejections, expected.work.diffusion_rejections);
      EXPECT_EQ(found.work.diffusion_stages, expected.work.diffusion_stages);
      EXPECT_EQ(found.work.halo_exchanges, world.traffic().halo_exchanges - exchanges_before);
      if (depth == 1) {
        EXPECT_EQ(found.work.halo_exchanges, expected.work.halo_exchanges);
      }
      // Alone no halo limits the depth.
      const int used =
          world.size() == 1 ? depth : std::min(depth, largest_halo_depth(part.decomposition, part.boundary, setting.order / 2));
      const std::int64_t attempts = found.work.diffusion_steps + found.work.diffusion_rejections;
      EXPECT_GE(found.work.halo_exchanges * used, found.work.diffusion_stages);
      EXPECT_LE(found.work.halo_exchanges * used, found.work.diffusion_stages + attempts * (used - 1)) << "exchanges fall by the depth";
      EXPECT_EQ(found.step, expected.step);
      const int offset_x = static_cast<int>(part.decomposition.offset_x());
      const int offset_y = static_cast<int>(part.decomposition.offset_y());
      int different = 0;
      for (std::size_t k = 0; k < n_states; ++k) {
        for (int s = 0; s < n_species; ++s) {
          for (int j = 0; j < part.decomposition.n_y(); ++j) {
            for (int i = 0; i < part.decomposition.n_x(); ++i) {
              if (found.states[k].at(s, i, j) != expected.states[k].at(s, offset_x + i, offset_y + j)) ++different;
            }
          }
        }
      }
      EXPECT_EQ(different, 0) << layout[0] << " x " << layout[1] << " ranks, depth " << depth;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Grids, Rock4OnManyRanksTest,
    ::testing::Values(Setting{"line_neumann_2", unit_grid(131, 1), BoundaryKind::neumann, BoundaryKind::neumann, 2},
                      Setting{"line_periodic_4", unit_grid(90, 1, true), BoundaryKind::periodic, BoundaryKind::neumann, 4},
                      Setting{"line_dirichlet_4", unit_grid(103, 1), BoundaryKind::dirichlet, BoundaryKind::neumann, 4},
                      Setting{"narrow_line_neumann_4", unit_grid(19, 1), BoundaryKind::neumann, BoundaryKind::neumann, 4},
                      Setting{"plane_neumann_2", unit_grid(67, 61), BoundaryKind::neumann, BoundaryKind::neumann, 2},
                      Setting{"plane_periodic_4", unit_grid(66, 41, true, true), BoundaryKind::periodic, BoundaryKind::periodic, 4},
                      Setting{"plane_dirichlet_periodic_2", unit_grid(59, 40, false, true), BoundaryKind::dirichlet, BoundaryKind::periodic,
                              2},
                      Setting{"plane_neumann_dirichlet_4", unit_grid(75, 33), BoundaryKind::neumann, BoundaryKind::dirichlet, 4},
                      Setting{"narrow_plane_neumann_4", unit_grid(17, 19), BoundaryKind::neumann, BoundaryKind::neumann, 4}),
    [](const auto& test) { return std::string(test.param.name); });

TEST(Rock4OnManyRanksTest, AValueThatIsNotFiniteStopsEveryRankAndIsReportedByItsOwner) {
  const Communicator world(MPI_COMM_WORLD);
  const Setting setting{"", unit_grid(64, 40), BoundaryKind::neumann, BoundaryKind::neumann, 2};
  for (int owner = 0; owner < world.size(); ++owner) {
    DiffusionProblem p(world, setting.grid, sides(setting), {0.02, 0.0, 0.05}, 2);
    Field u = rough_field(p, 0);
    if (world.rank() == owner) u.at(2, 3, 5) = std::numeric_limits<double>::quiet_NaN();
    Rock4 flow(p.decomposition, p.diffusion, {1e-5, {1e-5, 1e-5, 1e-5}});
    Work work;
    const auto failure = flow.advance(0.0, 0.1, u, u, work);
    EXPECT_EQ(failure.has_value(), world.rank() == owner);
    if (failure) {
      EXPECT_EQ(failure->i, p.decomposition.offset_x() + 3);
      EXPECT_EQ(failure->j, p.decomposition.offset_y() + 5);
    }
    EXPECT_EQ(work.diffusion_steps, 0);
    for (int s = 0; s < n_species; ++s) {
      for (int i = 0; i < u.n_x(); ++i) EXPECT_TRUE(std::isfinite(u.at(s, i, 5)));
    }
  }
}

TEST(Rock4OnManyRanksTest, OneStepIsOneReduction) {
  const Communicator world(MPI_COMM_WORLD);
  const Setting setting{"", unit_grid(64, 40), BoundaryKind::neumann, BoundaryKind::neumann, 2};
  DiffusionProblem p(world, setting.grid, sides(setting), {0.02, 0.0, 0.05}, 2);
  Field u = rough_field(p, 0);
  Rock4 flow(p.decomposition, p.diffusion, {1e-5, {1e-5, 1e-5, 1e-5}});
  const std::int64_t before = world.reductions();
  Work work;
  ASSERT_FALSE(flow.advance(0.0, 0.1, u, u, work));
  EXPECT_EQ(world.reductions() - before, work.diffusion_steps + work.diffusion_rejections);
}

}  // namespace
}  // namespace stiffront
