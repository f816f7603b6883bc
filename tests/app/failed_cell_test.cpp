// SPDX-License-Identifier: BSD-3-Clause
#include "../../src/app/failed_cell.hpp"

#include <gtest/gtest.h>

#include "app/example_case.hpp"

namespace stiffront::app {
namespace {

CellFailure failure_at(std::int64_t i, double interval) {
  CellFailure f;
  f.i = i;
  f.x = 0.1;
  f.y = 0.7;
  f.begin = 1.0 / 3.0;
  f.t = 0.34;
  f.dt = 1e-9;
  f.interval = interval;
  f.state = {0.1, 2e-300};
  f.reason = "the rates are not finite";
  return f;
}

TEST(FailedCell, TheLongestFailureOfTheCellThatFailedLastTellsMost) {
  const std::vector<CellFailure> failures{failure_at(4, 8.0), failure_at(7, 4.0), failure_at(4, 2.0), failure_at(7, 1.0)};
  EXPECT_EQ(most_telling(failures).interval, 4.0);
}

TEST(FailedCell, IsDescribedByPlaceTimeReasonAndState) {
  CellFailure f = failure_at(4, 0.25);
  EXPECT_EQ(describe(f, {"u", "v"}),
            "cell (4, 0) at x = 0.1, y = 0.7, t = 0.34000000000000002: the rates are not finite (inner step 1e-09); state at t = "
            "0.33333333333333331, 0.25 before the end of the sub-step: u = 0.10000000000000001, v = 2.0000000000000001e-300");
  f.species = 1;
  EXPECT_NE(describe(f, {"u", "v"}).find(": species v: the rates"), std::string::npos);
}

TEST(FailedCell, ItsCaseHasTheCellAloneAtItsPlaceWithEveryBitOfItsState) {
  const Case c = parse_example({"output.directory=o", "model.diffusion.u=0.5", "reaction_solver.positivity=reject-step"}, custom_text);
  const Case alone = parse_case({"failed-cell.toml", failed_cell_case(c, failure_at(4, 0.25), 1e-7), {}}, example_models());
  EXPECT_EQ(alone.grid.points, (std::vector<std::int64_t>{3, 3}));
  for (std::size_t d = 0; d < 2; ++d) {
    EXPECT_EQ(alone.grid.lower[d], d == 0 ? 0.1 : 0.7);
    EXPECT_NEAR(alone.grid.upper[d], alone.grid.lower[d], 1e-6);
  }
  EXPECT_EQ(std::get<double>(alone.initial.expressions[0].second), 0.1);
  EXPECT_EQ(std::get<double>(alone.initial.expressions[1].second), 2e-300);
  for (const auto& entry : alone.model.diffusion) EXPECT_EQ(std::get<double>(entry.second), 0.0);
  EXPECT_EQ(alone.model.reaction, c.model.reaction);
  EXPECT_EQ(alone.model.parameters, c.model.parameters);
  EXPECT_EQ(alone.time.start, 1.0 / 3.0);
  EXPECT_EQ(alone.time.end, 1.0 / 3.0 + 0.25);
  EXPECT_EQ(std::get<LieOptions>(alone.method).step, 0.25);
  EXPECT_EQ(alone.reaction_solver.tolerance, 1e-7);
  EXPECT_EQ(alone.reaction_solver.positivity, Positivity::reject_step);
  EXPECT_EQ(alone.output.directory, "o/failed-cell");
}

}  // namespace
}  // namespace stiffront::app
