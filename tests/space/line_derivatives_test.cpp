// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/space/line_derivatives.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "stiffront/mesh/halo_exchange.hpp"
#include "stiffront/space/sub_cell_closure.hpp"
#include "stiffront/space/three_point.hpp"
#include "support/grids.hpp"
#include "support/order_fit.hpp"

namespace stiffront {
namespace {

using testing::Sides;

/// First and second derivatives of a function on [0, 1].
struct Derived {
  Derived(int order, int intervals, const Sides& sides, double (*f)(double))
      : grid(testing::unit_grid_of_order(order, intervals + (sides == testing::periodic ? 0 : 1), 0, sides)),
        decomposition(self, grid, {0, 0}, 1),
        boundary(testing::boundary_of(sides, testing::neumann, 1, testing::zero)),
        box(boundary.free_box(decomposition)),
        u(decomposition, 1, order / 2),
        u_x(u.similar()),
        u_xx(u.similar()) {
    for (int i = 0; i < u.n_x(); ++i) u.at(0, i) = f(grid.position(0, i));
    HaloExchange(decomposition, boundary, 1, 1, order / 2).exchange(u);
    const LineDerivatives derivatives(grid, order);
    derivatives.first(u, u_x, box);
    derivatives.second(u, u_xx, box);
  }
  double worst(const Field& derivative, double (*exact)(double)) const {
    double e = 0.0;
    for (int i = box.i_begin; i < box.i_end; ++i) e = std::max(e, std::abs(derivative.at(0, i) - exact(grid.position(0, i))));
    return e;
  }

  Communicator self{MPI_COMM_SELF};
  Grid grid;
  Decomposition decomposition;
  Boundary boundary;
  FreeBox box;
  Field u, u_x, u_xx;
};

TEST(LineDerivativesTest, HaveTheirOrderUpToTheSides) {
  const auto f = [](double x) { return std::exp(std::sin(2.0 * M_PI * x)); };
  const auto df = [](double x) { return 2.0 * M_PI * std::cos(2.0 * M_PI * x) * std::exp(std::sin(2.0 * M_PI * x)); };
  const auto ddf = [](double x) {
    const double s = std::sin(2.0 * M_PI * x), c = std::cos(2.0 * M_PI * x);
    return 4.0 * M_PI * M_PI * (c * c - s) * std::exp(s);
  };
  for (const int order : {2, 4, 8}) {
    std::vector<double> h, first, second, closed_first, closed_second;
    for (const int n : {64, 96, 128, 160}) {
      const Derived inside(order, n, testing::periodic, f);
      const Derived to_the_sides(order, n, testing::dirichlet, f);
      h.push_back(1.0 / n);
      first.push_back(inside.worst(inside.u_x, df));
      second.push_back(inside.worst(inside.u_xx, ddf));
      closed_first.push_back(to_the_sides.worst(to_the_sides.u_x, df));
      closed_second.push_back(to_the_sides.worst(to_the_sides.u_xx, ddf));
    }
    EXPECT_NEAR(testing::observed_order(h, first), order, 0.4) << order;
    EXPECT_NEAR(testing::observed_order(h, second), order, 0.4) << order;
    if (order == 8) {
      EXPECT_GE(testing::observed_order(h, closed_first), 7.5);
      EXPECT_GE(testing::observed_order(h, closed_second), 7.5);
    }
  }
}

TEST(LineDerivativesTest, OfOrderEightArePolynomialsOfDegreeNineAtTheSides) {
  const auto f = [](double x) { return std::pow(x - 0.4, 9); };
  const Derived d(8, 10, testing::dirichlet, f);
  EXPECT_LE(d.worst(d.u_x, [](double x) { return 9.0 * std::pow(x - 0.4, 8); }), 2e-3);  // the centred rows are of degree 8
  for (const int i : {1, 2, 3, 4, 8, 9, 10, 11}) {
    const double x = d.grid.position(0, i);
    EXPECT_NEAR(d.u_x.at(0, i), 9.0 * std::pow(x - 0.4, 8), 1e-12) << i;
    EXPECT_NEAR(d.u_xx.at(0, i), 72.0 * std::pow(x - 0.4, 7), 1e-10) << i;
  }
}

TEST(LineDerivativesTest, ConstantsHaveNone) {
  for (const int order : {2, 4, 8}) {
    for (const Sides& sides : {testing::periodic, testing::neumann, testing::dirichlet}) {
      const Derived d(order, 24, sides, [](double) { return 0.1; });
      EXPECT_EQ(d.worst(d.u_x, [](double) { return 0.0; }), 0.0);
      EXPECT_EQ(d.worst(d.u_xx, [](double) { return 0.0; }), 0.0);
    }
  }
}

TEST(ThreePointTest, TheClosureIsBoundedByTwiceTheThreePointOperator) {
  // The generalised eigenvalues of the second differences of order eight and of three points lie between 1 and 2.134.
  const int n = 60;
  const Grid grid = testing::unit_grid_of_order(8, n + 1, 0, testing::dirichlet);
  const int size = static_cast<int>(grid.points[0]) - 2;
  const Communicator self(MPI_COMM_SELF);
  const Decomposition decomposition(self, grid, {0, 0}, 1);
  const LineDerivatives derivatives(grid, 8);
  Field u(decomposition, 1, 4);
  Field u_xx(u.similar());
  Eigen::MatrixXd eight(size, size);
  Eigen::MatrixXd three = Eigen::MatrixXd::Zero(size, size);
  const double h2 = grid.spacing(0) * grid.spacing(0);
  for (int k = 0; k < size; ++k) {
    u.at(0, k + 1) = 1.0;
    derivatives.second(u, u_xx, {1, size + 1, 0, 1});
    u.at(0, k + 1) = 0.0;
    for (int i = 0; i < size; ++i) eight(i, k) = h2 * u_xx.at(0, i + 1);
    const ThreePoint w = three_point_second(grid, 0, k + 1);
    three(k, k) = -(w.before + w.after);
    if (k > 0) three(k, k - 1) = w.before;
    if (k + 1 < size) three(k, k + 1) = w.after;
  }
  const Eigen::VectorXcd quotients = (three.inverse() * eight).eigenvalues();
  EXPECT_NEAR(quotients.real().minCoeff(), 1.0, 1e-3);
  EXPECT_NEAR(quotients.real().maxCoeff(), 2.134, 2e-3);
}

TEST(ThreePointTest, DifferentiatesParabolasExactly) {
  const Grid grid = testing::unit_grid_of_order(8, 12, 0, testing::dirichlet);
  for (int i = 1; i < grid.points[0] - 1; ++i) {
    const auto f = [&](int k) { return grid.place(0, k) * grid.place(0, k); };
    const ThreePoint first = three_point_first(grid, 0, i);
    const ThreePoint second = three_point_second(grid, 0, i);
    const auto apply = [&](const ThreePoint& w) { return w.before * (f(i - 1) - f(i)) + w.after * (f(i + 1) - f(i)); };
    EXPECT_NEAR(apply(first), 2.0 * grid.place(0, i), 1e-12);
    EXPECT_NEAR(apply(second), 2.0, 1e-12);
  }
}

}  // namespace
}  // namespace stiffront
