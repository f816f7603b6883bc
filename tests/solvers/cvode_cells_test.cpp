// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/solvers/cvode_cells.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "stiffront/core/error.hpp"
#include "stiffront/core/simd_math.hpp"
#include "stiffront/model/builtin/bz.hpp"
#include "stiffront/solvers/model_kernels.hpp"
#include "stiffront/solvers/radau5.hpp"

namespace stiffront {
namespace {

/// Depends on time and both coordinates; deviations from sin(t + x + 2 y) decay like exp(-5 t).
struct Forced {
  static constexpr int n_species = 1;
  static constexpr const char* name = "forced";
  static constexpr const char* source = "test";
  static constexpr std::array<const char*, 1> species{"u"};
  static constexpr std::array<double, 1> diffusion{1.0};
  static constexpr std::array<Parameter<Forced>, 0> parameters{};
  static constexpr std::array<Profile<Forced>, 0> profiles{};
  template <class T, class P>
  void rates(const T* u, T* du, const P& p) const {
    const auto s = p.t + p.x + 2.0 * p.y;
    du[0] = -5.0 * (u[0] - sin(s)) + cos(s);
  }
};

Grid small_grid() {
  Grid g;
  g.dimension = 2;
  g.points = {19, 3};
  return g;
}

class CellsOfABox : public ::testing::Test {
 protected:
  std::vector<double> hints() const { return std::vector<double>(19 * 3, 0.0); }
  const FreeBox all_{0, 19, 0, 3};
  Communicator comm_{MPI_COMM_SELF};
  Decomposition decomposition_{comm_, small_grid(), {1, 1}, 1};
  std::vector<float> cost_ = std::vector<float>(19 * 3, -1.0F);
  Work work_;
};

TEST_F(CellsOfABox, CvodeAndRadau5AgreeOnEveryCellOfAWave) {
  const ModelKernelsOf<Bz> model({});
  Field from(decomposition_, 3, 1);
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 19; ++i) {
      const double c = 0.005 * i + 0.05 * j;
      const double b = std::pow(10.0, -3.5 + 0.17 * i);
      from.at(0, i, j) = 1.6 * c / (2e-3 + b) * (j == 2 ? 1.2 : 1.0);
      from.at(1, i, j) = b;
      from.at(2, i, j) = c;
    }
  }
  Field by_cvode = from.similar();
  Field by_radau = from.similar();
  std::vector<double> hint = hints();
  const CellTolerances tolerances{1e-11, {1e-11, 1e-13, 1e-13}};
  EXPECT_FALSE(CvodeCells(model, tolerances).advance(0.0, 0.02, from, by_cvode, all_, hint, cost_, work_));
  EXPECT_EQ(hint, hints());
  for (float c : cost_) EXPECT_GT(c, 0.0F);
  EXPECT_GT(work_.reaction_steps, 0);
  EXPECT_GT(work_.reaction_jacobians, 0);
  EXPECT_FALSE(Radau5<Bz>(Bz{}, tolerances).advance(0.0, 0.02, from, by_radau, all_, hint, cost_, work_));
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 19; ++i) {
      for (int s = 0; s < 3; ++s) {
        const double size = 1e-3 + std::abs(by_radau.at(s, i, j));
        EXPECT_NEAR(by_cvode.at(s, i, j), by_radau.at(s, i, j), 3e-8 * size) << s << " " << i;
      }
    }
  }
}

TEST_F(CellsOfABox, BothKnowTimeAndPlace) {
  const ModelKernelsOf<Forced> model({});
  Field from(decomposition_, 1, 1);
  const auto exact = [](double t, int i, int j) { return std::sin(t + small_grid().position(0, i) + 2.0 * small_grid().position(1, j)); };
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 19; ++i) from.at(0, i, j) = exact(1.5, i, j);
  }
  const CellTolerances tolerances{1e-8, {1e-8}};
  Radau5<Forced> radau(Forced{}, tolerances);
  CvodeCells cvode(model, tolerances);
  for (ReactionSolver* solver : {static_cast<ReactionSolver*>(&radau), static_cast<ReactionSolver*>(&cvode)}) {
    Field to = from.similar();
    std::vector<double> hint = hints();
    EXPECT_FALSE(solver->advance(1.5, 0.7, from, to, all_, hint, cost_, work_));
    for (int j = 0; j < 3; ++j) {
      for (int i = 0; i < 19; ++i) EXPECT_NEAR(to.at(0, i, j), exact(2.2, i, j), 3e-7);
    }
  }
}

TEST_F(CellsOfABox, CvodeNamesTheFirstCellThatFailedAndLeavesItAsItWas) {
  const ModelKernelsOf<Forced> model({});
  Field from(decomposition_, 1, 1);
  from.at(0, 5, 1) = std::numeric_limits<double>::infinity();
  from.at(0, 2, 2) = std::numeric_limits<double>::infinity();
  Field to = from.similar();
  std::vector<double> hint = hints();
  const auto failure = CvodeCells(model, {1e-6, {1e-6}}).advance(0.0, 0.1, from, to, all_, hint, cost_, work_);
  ASSERT_TRUE(failure);
  EXPECT_EQ(failure->i, 5);
  EXPECT_EQ(failure->j, 1);
  EXPECT_EQ(failure->t, 0.0);
  EXPECT_EQ(failure->reason, "the rates are not finite");
  EXPECT_EQ(to.at(0, 5, 1), from.at(0, 5, 1));
  const double place = 6.0 / 18.0 + 1.0;
  EXPECT_NEAR(to.at(0, 6, 1), std::sin(0.1 + place) - std::exp(-0.5) * std::sin(place), 1e-5);  // its neighbour, from 0
}

TEST_F(CellsOfABox, CvodeRefusesWrongTolerances) {
  const ModelKernelsOf<Forced> model({});
  EXPECT_THROW(CvodeCells(model, {1e-6, {}}), Error);
  EXPECT_THROW(CvodeCells(model, {1e-6, {0.0}}), Error);
}

}  // namespace
}  // namespace stiffront
