// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/solvers/radau5.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "stiffront/model/builtin/bz.hpp"
#include "support/order_fit.hpp"
#include "support/stiff_problems.hpp"

namespace stiffront {
namespace {

template <class M, class T>
Radau5Kernel<M, T> make_kernel(double tolerance, int max_attempts = 100000) {
  double absolute[M::n_species];
  for (double& a : absolute) a = tolerance;
  return Radau5Kernel<M, T>(M{}, Radau5Tolerances<M::n_species>(tolerance, absolute), max_attempts);
}

/// Cells of one model, species-major, with hints and costs.
template <class M>
struct Cells {
  static constexpr int m = M::n_species;
  int n;
  std::vector<double> u;
  std::vector<double> hint;
  std::vector<float> cost;
  double x_of_cell = 0.0;  ///< x = number of the cell times this

  explicit Cells(int count) : n(count), u(size(m * count)), hint(size(count), 0.0), cost(size(count), -1.0F) {}
  static std::size_t size(int k) { return static_cast<std::size_t>(k); }
  double& at(int s, int i) { return u[size(s * n + i)]; }
  double at(int s, int i) const { return u[size(s * n + i)]; }

  template <class T>
  std::optional<Radau5Failure> advance(Radau5Kernel<M, T>& kernel, double t, double dt) {
    kernel.begin(t, dt);
    kernel.row({n, u.data(), n, u.data(), n, hint.data(), cost.data(), 0}, [this](int i, int) {
      Place<T> p{T(0.0), T(0.0), T(0.0)};
      for (int l = 0; l < ScalarTraits<T>::size; ++l) ScalarTraits<T>::set_lane(p.x, l, x_of_cell * std::min(i + l, n - 1));
      return p;
    });
    return kernel.finish();
  }
};

// ---- accuracy ----

/// u' = -lambda (u - g(t + x)) + g'(t + x), g = sin: depends on time and place, known solution.
struct Forced {
  static constexpr int n_species = 2;
  static constexpr const char* name = "forced";
  double lambda = 3.0;
  template <class T, class P>
  void rates(const T* u, T* du, const P& p) const {
    const auto s = p.t + p.x;
    du[0] = u[1];
    du[1] = -lambda * (u[1] - cos(s)) - sin(s) - (u[0] - sin(s)) * u[0];
  }
};

/// Error at t = 1 of n equal steps, none of them subject to error control.
template <class M, class T>
double fixed_step_error(int n, double x) {
  constexpr double absolute[] = {1.0, 1.0};
  Radau5Kernel<M, T> kernel(M{}, Radau5Tolerances<2>(1.0, absolute, 1e-13));
  Cells<M> cells(1);
  cells.x_of_cell = 0.0;
  double u[2] = {std::sin(x), std::cos(x)};
  std::vector<double> hint{0.0};
  float cost;
  const double h = 1.0 / n;
  for (int k = 0; k < n; ++k) {
    kernel.begin(k * h, h);
    kernel.row({1, u, 1, u, 1, hint.data(), &cost, 0}, [x](int, int) { return Place<T>{T(0.0), T(x), T(0.0)}; });
    EXPECT_FALSE(kernel.finish());
    EXPECT_EQ(kernel.counts().steps, 1);
  }
  return std::hypot(u[0] - std::sin(1.0 + x), u[1] - std::cos(1.0 + x));
}

TEST(Radau5, HasOrderFiveInTimeDependentProblems) {
  std::vector<double> h;
  std::vector<double> packed;
  std::vector<double> scalar;
  for (int n : {4, 6, 8, 12, 16, 24}) {
    h.push_back(1.0 / n);
    packed.push_back(fixed_step_error<Forced, Pack>(n, 0.7));
    scalar.push_back(fixed_step_error<Forced, double>(n, 0.7));
  }
  EXPECT_NEAR(testing::observed_order(h, packed), 5.0, 0.2);
  EXPECT_NEAR(testing::observed_order(h, scalar), 5.0, 0.2);
  EXPECT_LT(packed.back(), 1e-9);
}

template <class P>
class StiffTestSet : public ::testing::Test {
 public:
  /// Largest relative error over the species, cells of a full pack and one more.
  double error(double tolerance) {
    constexpr int m = P::n_species;
    double absolute[m];
    for (int s = 0; s < m; ++s) absolute[s] = tolerance * P::scale[static_cast<std::size_t>(s)];
    Radau5Kernel<P> kernel(P{}, Radau5Tolerances<m>(tolerance, absolute));
    Cells<P> cells(pack_size + 1);
    for (int i = 0; i < cells.n; ++i) {
      cells.hint[Cells<P>::size(i)] = P::first_step;
      for (int s = 0; s < m; ++s) cells.at(s, i) = P::start[static_cast<std::size_t>(s)];
    }
    EXPECT_FALSE(cells.advance(kernel, 0.0, P::end));
    double worst = 0.0;
    for (int s = 0; s < m; ++s) {
      const double exact = P::solution[static_cast<std::size_t>(s)];
      const double size = std::max(std::abs(exact), 1e-24);  // what E5 cannot have below rounding
      for (int i = 0; i < cells.n; ++i) worst = std::max(worst, std::abs(cells.at(s, i) - exact) / size);
    }
    return worst;
  }
};

using StiffProblems = ::testing::Types<testing::Robertson, testing::Hires, testing::Oregonator, testing::VanDerPol>;
struct ProblemName {
  template <class P>
  static std::string GetName(int) {
    return P::name;
  }
};
TYPED_TEST_SUITE(StiffTestSet, StiffProblems, ProblemName);

TYPED_TEST(StiffTestSet, ReachesThePublishedEndValuesWithErrorsThatFollowTheTolerance) {
  std::vector<double> tolerances;
  std::vector<double> errors;
  for (double tolerance : {1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10}) {
    tolerances.push_back(tolerance);
    errors.push_back(this->error(tolerance));
    EXPECT_LT(errors.back(), 20.0 * tolerance) << tolerance;
  }
  EXPECT_GT(testing::observed_order(tolerances, errors), 0.75);  // 5/6 where neither stiffness nor damping interferes
  EXPECT_LT(testing::observed_order(tolerances, errors), 1.25);
}

using StiffTestSetE5 = StiffTestSet<testing::E5>;
TEST_F(StiffTestSetE5, ReachesThePublishedEndValuesUpToItsOwnCancellation) {
  // y2 - y3 - y4 = 0 holds from values near 1e-10 down to 1e-22: rounding alone leaves some 1e-3
  EXPECT_LT(error(1e-5), 1e-2);
  EXPECT_LT(error(1e-9), 1e-2);
}

// ---- lanes ----

/// States all along a wave: at rest, igniting, recovering.
Cells<Bz> wave_states(int n, unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const Bz bz;
  Cells<Bz> cells(n);
  for (int i = 0; i < n; ++i) {
    const double b = std::pow(10.0, -4.0 + 4.0 * unit(random));
    const double c = 0.2 * unit(random);
    cells.at(0, i) = bz.f * c / (bz.q + b) * (unit(random) < 0.3 ? 1.0 + 0.5 * unit(random) : 1.0);
    cells.at(1, i) = b;
    cells.at(2, i) = c;
    if (i % 5 == 4) cells.hint[Cells<Bz>::size(i)] = 1e-4 * (1.0 + unit(random));
  }
  return cells;
}

TEST(Radau5, ACellsBitsDoNotDependOnItsNeighboursNorOnItsPlaceInTheRow) {
  constexpr double dt = 3e-4;
  constexpr int n = 20;
  const Cells<Bz> start = wave_states(n, 1);
  auto kernel = make_kernel<Bz, Pack>(1e-6);
  Cells<Bz> alone(n);
  std::vector<Radau5Counts> counts_alone;
  for (int i = 0; i < n; ++i) {
    Cells<Bz> one(1);
    for (int s = 0; s < 3; ++s) one.at(s, 0) = start.at(s, i);
    one.hint[0] = start.hint[Cells<Bz>::size(i)];
    EXPECT_FALSE(one.advance(kernel, 0.0, dt));
    for (int s = 0; s < 3; ++s) alone.at(s, i) = one.at(s, 0);
    alone.hint[Cells<Bz>::size(i)] = one.hint[0];
    alone.cost[Cells<Bz>::size(i)] = one.cost[0];
    counts_alone.push_back(kernel.counts());
  }
  const auto several = [](const Radau5Counts& c) { return c.steps > 1; };
  EXPECT_GT(std::count_if(counts_alone.begin(), counts_alone.end(), several), 5);  // both passes have work
  EXPECT_LT(std::count_if(counts_alone.begin(), counts_alone.end(), several), 15);

  std::mt19937_64 random(2);
  for (int count = 1; count <= n; ++count) {
    std::vector<int> order(n);
    std::iota(order.begin(), order.end(), 0);
    std::shuffle(order.begin(), order.end(), random);
    Cells<Bz> some(count);
    Radau5Counts expected;
    for (int i = 0; i < count; ++i) {
      const int k = order[Cells<Bz>::size(i)];
      for (int s = 0; s < 3; ++s) some.at(s, i) = start.at(s, k);
      some.hint[Cells<Bz>::size(i)] = start.hint[Cells<Bz>::size(k)];
      const Radau5Counts& c = counts_alone[Cells<Bz>::size(k)];
      expected.steps += c.steps;
      expected.error_rejections += c.error_rejections;
      expected.newton_failures += c.newton_failures;
      expected.newton_iterations += c.newton_iterations;
      expected.rhs += c.rhs;
      expected.jacobians += c.jacobians;
    }
    EXPECT_FALSE(some.advance(kernel, 0.0, dt));
    EXPECT_EQ(kernel.counts(), expected) << count;
    for (int i = 0; i < count; ++i) {
      const int k = order[Cells<Bz>::size(i)];
      for (int s = 0; s < 3; ++s) EXPECT_EQ(some.at(s, i), alone.at(s, k)) << count;
      EXPECT_EQ(some.hint[Cells<Bz>::size(i)], alone.hint[Cells<Bz>::size(k)]);
      EXPECT_EQ(some.cost[Cells<Bz>::size(i)], alone.cost[Cells<Bz>::size(k)]);
    }
  }
}

TEST(Radau5, ANeighbourThatNeedsRowExchangesChangesNothing) {
  // d(du1)/du0 is -1e6 (2 u0 u1 + 1): far above gamma/h in some cells, 0 in others
  using Vdp = testing::VanDerPol;
  constexpr int n = 3 * pack_size;
  Cells<Vdp> all(n);
  for (int i = 0; i < n; ++i) {
    all.at(0, i) = 1.2 + 0.05 * (i % 7);
    all.at(1, i) = i % 3 == 0 ? all.at(0, i) / (1.0 - all.at(0, i) * all.at(0, i)) : -0.5 / all.at(0, i);
    all.hint[Cells<Vdp>::size(i)] = i % 2 == 0 ? 0.0 : 1e-5;
  }
  const Cells<Vdp> start = all;
  auto kernel = make_kernel<Vdp, Pack>(1e-6);
  EXPECT_FALSE(all.advance(kernel, 0.0, 1e-4));
  for (int i = 0; i < n; ++i) {
    Cells<Vdp> one(1);
    for (int s = 0; s < 2; ++s) one.at(s, 0) = start.at(s, i);
    one.hint[0] = start.hint[Cells<Vdp>::size(i)];
    EXPECT_FALSE(one.advance(kernel, 0.0, 1e-4));
    for (int s = 0; s < 2; ++s) EXPECT_EQ(all.at(s, i), one.at(s, 0)) << i;
    EXPECT_EQ(all.hint[Cells<Vdp>::size(i)], one.hint[0]);
    EXPECT_EQ(all.cost[Cells<Vdp>::size(i)], one.cost[0]);
  }
}

TEST(Radau5, ListsLongerThanOneBatchChangeNothing) {
  constexpr int n = 5000;
  Cells<Bz> start = wave_states(n, 3);
  for (double& h : start.hint) h = 1e-4;  // all of them on the list
  auto kernel = make_kernel<Bz, Pack>(1e-5);
  Cells<Bz> all = start;
  EXPECT_FALSE(all.advance(kernel, 0.0, 1e-3));
  for (int i = 0; i < n; i += 37) {
    Cells<Bz> one(1);
    for (int s = 0; s < 3; ++s) one.at(s, 0) = start.at(s, i);
    one.hint[0] = 1e-4;
    EXPECT_FALSE(one.advance(kernel, 0.0, 1e-3));
    for (int s = 0; s < 3; ++s) EXPECT_EQ(all.at(s, i), one.at(s, 0));
  }
}

TEST(Radau5, DoublesDoTheSameAsPacks) {
  Cells<Bz> packed = wave_states(200, 4);
  Cells<Bz> scalar = packed;
  auto packs = make_kernel<Bz, Pack>(1e-6);
  auto doubles = make_kernel<Bz, double>(1e-6);
  EXPECT_FALSE(packed.advance(packs, 0.0, 2e-3));
  EXPECT_FALSE(scalar.advance(doubles, 0.0, 2e-3));
  EXPECT_EQ(packs.counts(), doubles.counts());
  EXPECT_EQ(packed.u, scalar.u);
  EXPECT_EQ(packed.hint, scalar.hint);
  EXPECT_EQ(packed.cost, scalar.cost);
}

// ---- hints, costs, failures ----

TEST(Radau5, HintsSpareTheNextCallItsRejections) {
  constexpr double dt = 5e-3;
  Cells<Bz> cells = wave_states(400, 5);
  auto kernel = make_kernel<Bz, Pack>(1e-9);
  EXPECT_FALSE(cells.advance(kernel, 0.0, dt));
  Cells<Bz> without = cells;
  for (double& h : without.hint) {
    EXPECT_TRUE(h == 0.0 || (h > 0.0 && h < dt));
    h = 0.0;
  }
  EXPECT_FALSE(without.advance(kernel, dt, dt));
  const Radau5Counts cold = kernel.counts();
  EXPECT_FALSE(cells.advance(kernel, dt, dt));
  const Radau5Counts warm = kernel.counts();
  EXPECT_LT(warm.error_rejections + warm.newton_failures, (cold.error_rejections + cold.newton_failures) / 2);
  EXPECT_LT(warm.newton_iterations, cold.newton_iterations);
}

TEST(Radau5, CostsAreTheCountedWorkOfTheCells) {
  Cells<Bz> cells = wave_states(123, 6);
  auto kernel = make_kernel<Bz, Pack>(1e-7);
  EXPECT_FALSE(cells.advance(kernel, 0.0, 2e-3));
  const double sum = std::accumulate(cells.cost.begin(), cells.cost.end(), 0.0);
  const Radau5Counts c = kernel.counts();
  EXPECT_EQ(sum, static_cast<double>(c.newton_iterations) + ReactionSolver::attempt_cost * static_cast<double>(c.jacobians));
  EXPECT_GE(*std::min_element(cells.cost.begin(), cells.cost.end()), 1.0F);
  EXPECT_EQ(c.jacobians, c.steps + c.error_rejections + c.newton_failures);
  EXPECT_GE(c.rhs, c.jacobians + 3 * c.newton_iterations);
}

/// Reaches infinity at t = 1/u(0).
struct Explosion {
  static constexpr int n_species = 1;
  static constexpr const char* name = "explosion";
  template <class T, class P>
  void rates(const T* u, T* du, const P&) const {
    du[0] = u[0] * u[0];
  }
};

TEST(Radau5, ACellThatCannotBeIntegratedIsReportedAndTheOthersAreNot) {
  Cells<Explosion> cells(21);
  for (int i = 0; i < cells.n; ++i) cells.at(0, i) = 0.5;
  cells.at(0, 7) = 4.0;
  cells.at(0, 18) = 5.0;
  auto kernel = make_kernel<Explosion, Pack>(1e-6);
  const auto failure = cells.advance(kernel, 2.0, 1.0);
  ASSERT_TRUE(failure);
  EXPECT_EQ(failure->cell, 7);
  EXPECT_NEAR(failure->t, 2.25, 1e-4);
  EXPECT_LT(failure->h, 1e-6);
  EXPECT_EQ(std::string(failure->reason), "the inner step size has become too small");
  EXPECT_EQ(cells.at(0, 7), 4.0);  // as it was
  EXPECT_EQ(cells.at(0, 18), 5.0);
  for (int i = 0; i < cells.n; ++i) {
    if (i != 7 && i != 18) {
      EXPECT_NEAR(cells.at(0, i), 1.0, 1e-5);
    }
  }
}

TEST(Radau5, TooManyInnerStepsAreAFailure) {
  Cells<testing::VanDerPol> cells(1);
  cells.at(0, 0) = 2.0;
  cells.at(1, 0) = 0.0;
  auto kernel = make_kernel<testing::VanDerPol, Pack>(1e-8, 50);
  const auto failure = cells.advance(kernel, 0.0, 2.0);
  ASSERT_TRUE(failure);
  EXPECT_EQ(std::string(failure->reason), "too many inner steps");
  EXPECT_EQ(kernel.counts().jacobians, 50);
}

TEST(Radau5, RatesThatAreNotFiniteAreFoundAtOnce) {
  Cells<Bz> cells = wave_states(10, 8);
  cells.at(1, 3) = std::nan("");
  auto kernel = make_kernel<Bz, Pack>(1e-6);
  const auto failure = cells.advance(kernel, 0.0, 1e-3);
  ASSERT_TRUE(failure);
  EXPECT_EQ(failure->cell, 3);
  EXPECT_EQ(std::string(failure->reason), "the rates are not finite");
  for (int i = 0; i < cells.n; ++i) {
    EXPECT_EQ(std::isnan(cells.at(1, i)), i == 3);
  }
}

// ---- the solver of a box ----

class Radau5OfABox : public ::testing::Test {
 protected:
  static constexpr int n_x = 21;
  static constexpr int n_y = 5;
  Radau5OfABox() {
    const Cells<Bz> states = wave_states(n_x * n_y, 9);
    for (int j = 0; j < n_y; ++j) {
      for (int i = 0; i < n_x; ++i) {
        for (int s = 0; s < 3; ++s) from_.at(s, i, j) = states.at(s, j * n_x + i);
      }
    }
  }
  static Grid grid() {
    Grid g;
    g.dimension = 2;
    g.points = {n_x, n_y};
    return g;
  }
  static CellTolerances tolerances() { return {1e-6, {1e-6, 1e-6, 1e-6}}; }

  Communicator comm_{MPI_COMM_SELF};
  Decomposition decomposition_{comm_, grid(), {1, 1}, 1};
  Field from_{decomposition_, 3, 2};
  std::vector<double> hint_ = std::vector<double>(n_x * n_y, 0.0);
  std::vector<float> cost_ = std::vector<float>(n_x * n_y, -1.0F);
};

TEST_F(Radau5OfABox, AdvancesThePointsOfTheBoxAndNoOthers) {
  Radau5<Bz> solver(Bz{}, tolerances());
  Field to = from_.similar();
  Work work;
  EXPECT_FALSE(solver.advance(0.0, 1e-3, from_, to, {1, n_x - 1, 1, n_y}, hint_, cost_, work));
  for (int j = 0; j < n_y; ++j) {
    for (int i = 0; i < n_x; ++i) {
      const bool inside = i >= 1 && i < n_x - 1 && j >= 1;
      EXPECT_EQ(to.at(1, i, j) != 0.0, inside);
      EXPECT_EQ(cost_[static_cast<std::size_t>(j * n_x + i)] >= 1.0F, inside);
      if (!inside) continue;
      Cells<Bz> one(1);
      for (int s = 0; s < 3; ++s) one.at(s, 0) = from_.at(s, i, j);
      auto kernel = make_kernel<Bz, Pack>(1e-6);
      EXPECT_FALSE(one.advance(kernel, 0.0, 1e-3));
      for (int s = 0; s < 3; ++s) EXPECT_EQ(to.at(s, i, j), one.at(s, 0));
    }
  }
  EXPECT_GE(work.reaction_steps, (n_x - 2) * (n_y - 1));
  EXPECT_EQ(work.reaction_jacobians, work.reaction_steps + work.reaction_rejections);
}

TEST_F(Radau5OfABox, InPlaceGivesTheSameBits) {
  Radau5<Bz> solver(Bz{}, tolerances());
  Field to = from_.similar();
  Work work;
  std::vector<double> hint = hint_;
  EXPECT_FALSE(solver.advance(0.0, 1e-3, from_, to, {0, n_x, 0, n_y}, hint, cost_, work));
  EXPECT_FALSE(solver.advance(0.0, 1e-3, from_, from_, {0, n_x, 0, n_y}, hint_, cost_, work));
  EXPECT_EQ(hint, hint_);
  for (int j = 0; j < n_y; ++j) {
    for (int i = 0; i < n_x; ++i) {
      for (int s = 0; s < 3; ++s) EXPECT_EQ(to.at(s, i, j), from_.at(s, i, j));
    }
  }
}

TEST_F(Radau5OfABox, NamesTheCellThatFailed) {
  from_.at(0, 4, 3) = std::numeric_limits<double>::infinity();
  Radau5<Bz> solver(Bz{}, tolerances());
  Field to = from_.similar();
  Work work;
  const auto failure = solver.advance(0.5, 1e-3, from_, to, {0, n_x, 0, n_y}, hint_, cost_, work);
  ASSERT_TRUE(failure);
  EXPECT_EQ(failure->i, 4);
  EXPECT_EQ(failure->j, 3);
  EXPECT_EQ(failure->x, grid().position(0, 4));
  EXPECT_EQ(failure->y, grid().position(1, 3));
  EXPECT_EQ(failure->t, 0.5);
  EXPECT_EQ(failure->interval, 1e-3);
  ASSERT_EQ(failure->state.size(), 3U);
  EXPECT_EQ(failure->state[1], from_.at(1, 4, 3));
}

TEST_F(Radau5OfABox, WrongTolerancesAreRefused) {
  EXPECT_THROW(Radau5<Bz>(Bz{}, {1e-6, {1e-6, 1e-6}}), Error);
  EXPECT_THROW(Radau5<Bz>(Bz{}, {0.0, {1e-6, 1e-6, 1e-6}}), Error);
}

}  // namespace
}  // namespace stiffront
