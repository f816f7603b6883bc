// SPDX-License-Identifier: BSD-3-Clause
// The order of the semi-discrete solution, by manufactured solutions of sigma u - Laplacian(u) = f on four grids. It is the error of
// the solution that counts, not that of the operator: at boundaries the operator may be, and is, of lower order.
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <Eigen/SparseLU>
#include <cmath>
#include <numbers>
#include <vector>

#include "support/assembled_diffusion.hpp"
#include "support/order_fit.hpp"

namespace stiffront {
namespace {

using testing::Sides;

/// exp(g) and its second derivative: all Fourier modes, and smooth beyond Neumann sides when continued evenly.
struct Profile1d {
  double value;
  double second;
};

Profile1d profile(const Sides& sides, double x) {
  double g = 0.0;
  double dg = 0.0;
  double ddg = 0.0;
  if (sides == testing::periodic) {
    const double w = 2.0 * std::numbers::pi;
    g = std::sin(w * x);
    dg = w * std::cos(w * x);
    ddg = -w * w * g;
  } else if (sides == testing::dirichlet) {
    const double w = 3.0;
    g = std::sin(w * x);
    dg = w * std::cos(w * x);
    ddg = -w * w * g;
  } else {
    // Even about x = 1, and for Neumann on both sides about x = 0 too.
    const double w = sides == testing::neumann ? std::numbers::pi : 2.5;
    g = std::cos(w * (1.0 - x));
    dg = w * std::sin(w * (1.0 - x));
    ddg = -w * w * g;
  }
  return {std::exp(g), std::exp(g) * (dg * dg + ddg)};
}

/// Maximum error of the discrete solution with the given numbers of intervals (0: one dimension).
double solution_error(const Communicator& self, int n_x, int n_y, const Sides& x, const Sides& y, int order) {
  const bool plane = n_y != 0;
  const auto points = [](int intervals, const Sides& sides) { return intervals + (sides == testing::periodic ? 0 : 1); };
  const Grid grid = testing::unit_grid_of_order(order, points(n_x, x), plane ? points(n_y, y) : 0, x, y);
  const auto exact = [&](double px, double py) { return profile(x, px).value * (plane ? profile(y, py).value : 1.0); };
  const auto laplacian = [&](double px, double py) {
    const Profile1d a = profile(x, px);
    if (!plane) return a.second;
    const Profile1d b = profile(y, py);
    return a.second * b.value + a.value * b.second;
  };
  const testing::AssembledDiffusion a(
      self, grid, x, y, [&](double, double px, double py) { return exact(px, py); }, order);
  const double sigma = a.boundary.has_dirichlet() ? 0.0 : 1.0;
  Eigen::SparseMatrix<double> m(a.size(), a.size());
  m.setIdentity();
  m = sigma * m - a.matrix;
  Eigen::VectorXd f = a.boundary_part;
  Eigen::VectorXd u(a.size());
  a.for_each_point([&](int row, int i, int j) {
    const double px = grid.position(0, i);
    const double py = plane ? grid.position(1, j) : 0.0;
    u[row] = exact(px, py);
    f[row] += sigma * u[row] - laplacian(px, py);
  });
  const Eigen::SparseLU<Eigen::SparseMatrix<double>> lu(m);
  return (lu.solve(f) - u).cwiseAbs().maxCoeff();
}

class DiffusionOrderTest : public ::testing::TestWithParam<int> {
 protected:
  static void expect_order(const std::vector<double>& h, const std::vector<double>& error, const std::string& what) {
    const double order = testing::observed_order(h, error);
    EXPECT_NEAR(order, GetParam(), GetParam() == 2 ? 0.1 : (GetParam() == 4 ? 0.2 : 0.5))
        << what << fmt::format(", errors {:.2e}", fmt::join(error, " "));
  }
  const Communicator self{MPI_COMM_SELF};
};

TEST_P(DiffusionOrderTest, IsThatOfTheStencilForEveryBoundaryInOneDimension) {
  for (const Sides& x : testing::all_sides) {
    std::vector<double> h;
    std::vector<double> error;
    // Of order eight, so few that rounding does not show: waves need more points than what the other sides let pass.
    const std::array of_order_8 = x == testing::periodic ? std::array{48, 56, 64, 72} : std::array{16, 20, 26, 32};
    for (const int n : GetParam() == 8 ? of_order_8 : std::array{32, 48, 72, 108}) {
      h.push_back(1.0 / n);
      error.push_back(solution_error(self, n, 0, x, testing::neumann, GetParam()));
    }
    expect_order(h, error, testing::name_of(x));
  }
}

TEST_P(DiffusionOrderTest, IsThatOfTheStencilForEveryBoundaryInTwoDimensions) {
  const std::vector<std::array<Sides, 2>> pairs{{testing::periodic, testing::neumann},    {testing::neumann, testing::dirichlet},
                                                {testing::dirichlet, testing::dirichlet}, {testing::dirichlet, testing::mixed},
                                                {testing::mixed, testing::periodic},      {testing::neumann, testing::neumann}};
  for (const auto& [x, y] : pairs) {
    std::vector<double> h;
    std::vector<double> error;
    const bool waves = x == testing::periodic || y == testing::periodic;
    const std::array of_order_8 = waves ? std::array{32, 36, 42, 48} : std::array{16, 20, 24, 28};
    for (const int n : GetParam() == 8 ? of_order_8 : std::array{16, 24, 32, 48}) {
      h.push_back(1.0 / n);
      error.push_back(solution_error(self, n, n + n / 2, x, y, GetParam()));
    }
    expect_order(h, error, testing::name_of(x) + "/" + testing::name_of(y));
  }
}

INSTANTIATE_TEST_SUITE_P(Orders, DiffusionOrderTest, ::testing::Values(2, 4, 8),
                         [](const auto& p) { return "order" + std::to_string(p.param); });

}  // namespace
}  // namespace stiffront
