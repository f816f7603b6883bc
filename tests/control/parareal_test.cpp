// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/parareal.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "stiffront/control/collocation.hpp"
#include "stiffront/control/deferred_correction.hpp"
#include "stiffront/control/evolve.hpp"
#include "stiffront/core/error.hpp"
#include "stiffront/mesh/field_algebra.hpp"
#include "support/split_brusselator.hpp"

namespace stiffront {
namespace {

class PararealTest : public testing::SplitBrusselator {
 protected:
  void split(double t, double dt, int steps, Field& from, Field& to) {
    const Composition composition = lie(SplittingOrder::reaction_last);
    Work work;
    for (int n = 0; n < steps; ++n) {
      const auto failure = stiffront::advance(flows_, composition, t + n * dt / steps, dt / steps, n == 0 ? from : to, to, work);
      ASSERT_FALSE(failure);
    }
  }

  SplitFlows flows_{&reaction_, &rock4_};
};

TEST_F(PararealTest, ConvergesToTheFineSolution) {
  constexpr int intervals = 8, fine_steps = 20;
  constexpr double dt = 0.1;
  std::vector<Field> fine;
  for (int i = 0; i < intervals; ++i) {
    fine.push_back(u_.similar());
    split(i * dt, dt, fine_steps, i == 0 ? u_ : fine[static_cast<std::size_t>(i) - 1], fine.back());
  }
  Parareal parareal(u_, intervals, comm_, [&](int i, Field& from, Field& to) { split(i * dt, dt, 1, from, to); });
  parareal.predict(u_);
  double before = distance(parareal.state(intervals), fine.back());
  EXPECT_GT(before, 1e-2);
  for (int k = 1; k <= intervals; ++k) {
    parareal.iterate([&](std::vector<Field>& states, std::vector<Field>& results) {
      for (int i = 0; i < intervals; ++i) {
        split(i * dt, dt, fine_steps, states[static_cast<std::size_t>(i)], results[static_cast<std::size_t>(i)]);
      }
    });
    // The first k intervals are done, and every iteration improves the rest.
    for (int i = 1; i <= k; ++i) EXPECT_LT(distance(parareal.state(i), fine[static_cast<std::size_t>(i) - 1]), 1e-11) << k;
    const double now = distance(parareal.state(intervals), fine.back());
    EXPECT_LT(now, std::max(0.5 * before, 1e-11)) << k;
    before = now;
  }
}

TEST_F(PararealTest, IsDeferredCorrectionWithTheQuadratureAsItsFinePropagator) {
  constexpr double dt = 0.02;
  const CollocationNodes nodes = collocation_nodes(NodeFamily::gauss_radau, 3);
  Parareal parareal(u_, 3, comm_, [&](int i, Field& from, Field& to) {
    split(i == 0 ? 0.0 : nodes.c[static_cast<std::size_t>(i) - 1] * dt, nodes.interval(i) * dt, 1, from, to);
  });
  std::vector<Field> f;
  for (int i = 0; i < 3; ++i) f.push_back(u_.similar());
  parareal.predict(u_);
  for (int k = 1; k <= 4; ++k) {
    // (13): from the states at all nodes, not from the left end of the interval alone.
    parareal.iterate([&](std::vector<Field>& states, std::vector<Field>& results) {
      for (std::size_t i = 0; i < 3; ++i) rhs_.evaluate(nodes.c[i] * dt, states[i + 1], f[i]);
      for (std::size_t i = 0; i < 3; ++i) {
        std::vector<Term> terms{{1.0, &states[i]}};
        for (std::size_t j = 0; j < 3; ++j) terms.push_back({dt * nodes.between(static_cast<int>(i), static_cast<int>(j)), &f[j]});
        combine(terms, results[i]);
      }
    });
    DeferredCorrectionOptions o;
    o.fixed_step = dt;
    o.iterations = k;
    DeferredCorrection method(u_, rhs_, reaction_, rock4_, o);
    Field u = u_.similar();
    u.copy_interior(u_);
    Schedule schedule;
    schedule.end = dt;
    Progress progress;
    Observer nobody;
    evolve(method, schedule, u, progress, nobody);
    EXPECT_LT(distance(parareal.state(3), u), 1e-13) << k;
  }
}

TEST_F(PararealTest, RefusesMoreGroupsThanIntervals) {
  EXPECT_THROW(Parareal(u_, 0, comm_, [](int, Field&, Field&) {}), Error);
}

TEST(PararealSpeedUp, IsBoundedByGroupsOverIterations) {
  EXPECT_NEAR(parareal_speed_up(8, 2, 0.0), 4.0, 1e-12);
  EXPECT_NEAR(parareal_speed_up(4, 2, 0.05), 1.0 / (0.05 + 0.5 * 1.05), 1e-12);
}

}  // namespace
}  // namespace stiffront
