// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/splitting/composition.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <unsupported/Eigen/MatrixFunctions>

#include "support/order_fit.hpp"

namespace stiffront {
namespace {

/// The exact flow of du/dt = A u on the one cell of a field, and the clock it was called with.
class LinearFlow final : public Flow {
 public:
  explicit LinearFlow(Eigen::Matrix2d a) : a_(std::move(a)) {}

  using Flow::advance;
  std::optional<CellFailure> advance(double t, double dt, std::span<const Transition> states, Work&) override {
    times.push_back(t);
    const Eigen::Matrix2d e = (a_ * dt).exp();
    for (const Transition& s : states) {
      const Eigen::Vector2d v = e * Eigen::Vector2d(s.from->at(0, 0), s.from->at(1, 0));
      s.to->at(0, 0) = v[0];
      s.to->at(1, 0) = v[1];
    }
    return std::nullopt;
  }

  std::vector<double> times;

 private:
  Eigen::Matrix2d a_;
};

class CompositionTest : public ::testing::Test {
 protected:
  CompositionTest() : comm_(MPI_COMM_SELF), decomposition_(comm_, grid(), {1, 1}, 1) {}

  static Grid grid() {
    Grid g;
    g.points = {2, 1};
    return g;
  }

  /// Error after t = 1 against the exact solution, with steps of h.
  double error(const Composition& composition, const Eigen::Matrix2d& reaction, const Eigen::Matrix2d& diffusion, int steps) {
    LinearFlow y(reaction);
    LinearFlow x(diffusion);
    Field u(decomposition_, 2, 0);
    u.at(0, 0) = 1.0;
    u.at(1, 0) = -0.5;
    Work work;
    for (int n = 0; n < steps; ++n) advance({&y, &x}, composition, n * (1.0 / steps), 1.0 / steps, u, u, work);
    const Eigen::Matrix2d sum = reaction + diffusion;
    const Eigen::Vector2d exact = sum.exp() * Eigen::Vector2d(1.0, -0.5);
    return (Eigen::Vector2d(u.at(0, 0), u.at(1, 0)) - exact).norm();
  }

  double order(const Composition& composition) {
    std::vector<double> h;
    std::vector<double> e;
    for (int steps : {20, 40, 80, 160, 320}) {
      h.push_back(1.0 / steps);
      e.push_back(error(composition, a_, b_, steps));
    }
    return testing::observed_order(h, e);
  }

  Communicator comm_;
  Decomposition decomposition_;
  Eigen::Matrix2d a_ = (Eigen::Matrix2d() << -0.3, 1.2, -0.7, 0.1).finished();
  Eigen::Matrix2d b_ = (Eigen::Matrix2d() << -1.0, 0.2, 0.9, -0.4).finished();
};

TEST_F(CompositionTest, LieHasOrderOne) {
  EXPECT_NEAR(order(lie(SplittingOrder::reaction_last)), 1.0, 0.05);
  EXPECT_NEAR(order(lie(SplittingOrder::diffusion_last)), 1.0, 0.05);
}

TEST_F(CompositionTest, StrangHasOrderTwo) {
  EXPECT_NEAR(order(strang(SplittingOrder::reaction_last)), 2.0, 0.05);
  EXPECT_NEAR(order(strang(SplittingOrder::diffusion_last)), 2.0, 0.05);
}

TEST_F(CompositionTest, ShiftedStrangHasOrderOneWithAnErrorProportionalToEpsilon) {
  EXPECT_NEAR(order(shifted_strang(SplittingOrder::reaction_last, 0.3)), 1.0, 0.05);
  EXPECT_NEAR(order(shifted_strang(SplittingOrder::diffusion_last, 0.3)), 1.0, 0.05);
  const double large = error(shifted_strang(SplittingOrder::reaction_last, 0.04), a_, b_, 4000);
  const double small = error(shifted_strang(SplittingOrder::reaction_last, 0.02), a_, b_, 4000);
  EXPECT_NEAR(large / small, 2.0, 0.02);
}

TEST_F(CompositionTest, CommutingFlowsAreSplitExactly) {
  const Eigen::Matrix2d polynomial = 0.5 * a_ + 0.2 * a_ * a_;
  for (const Composition& c :
       {lie(SplittingOrder::reaction_last), strang(SplittingOrder::diffusion_last), shifted_strang(SplittingOrder::reaction_last, 0.2)}) {
    EXPECT_LT(error(c, a_, polynomial, 7), 1e-13);
  }
}

TEST_F(CompositionTest, EveryProcessHasItsOwnClock) {
  LinearFlow reaction(a_);
  LinearFlow diffusion(b_);
  Field u(decomposition_, 2, 0);
  Field v = u.similar();
  Work work;
  advance({&reaction, &diffusion}, shifted_strang(SplittingOrder::reaction_last, 0.25), 3.0, 2.0, u, v, work);
  EXPECT_EQ(reaction.times, (std::vector<double>{3.0, 4.5}));
  EXPECT_EQ(diffusion.times, (std::vector<double>{3.0}));
}

TEST_F(CompositionTest, TheStateItStartsFromIsKept) {
  LinearFlow reaction(a_);
  LinearFlow diffusion(b_);
  Field u(decomposition_, 2, 0);
  u.at(0, 0) = 1.0;
  Field v = u.similar();
  Work work;
  advance({&reaction, &diffusion}, strang(SplittingOrder::reaction_last), 0.0, 0.1, u, v, work);
  EXPECT_EQ(u.at(0, 0), 1.0);
  EXPECT_NE(v.at(0, 0), 1.0);
}

}  // namespace
}  // namespace stiffront
