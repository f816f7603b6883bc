// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/space/diffusion_operator.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <cstring>
#include <deque>
#include <functional>
#include <limits>
#include <numbers>
#include <string>

#include "stiffront/core/error.hpp"
#include "support/assembled_diffusion.hpp"
#include "support/diffusion_problem.hpp"

namespace stiffront {
namespace {

using testing::Sides;

class DiffusionOperatorTest : public ::testing::Test {
 protected:
  /// A field of one species filled by index, Dirichlet points included, and its Laplacian with D = 1 (zero outside the free box).
  struct Applied {
    Field u;
    Field lu;
  };
  Applied apply(const Grid& grid, const Sides& x, const Sides& y, int order, const std::function<double(int, int)>& value) {
    decompositions_.emplace_back(self, grid, std::array<int, 2>{0, 0}, 1);
    const Decomposition& d = decompositions_.back();
    const Boundary boundary = testing::boundary_of(x, y, 1, testing::zero);
    const DiffusionOperator diffusion(grid, boundary, {1.0}, order);
    HaloExchange halo(d, boundary, 1, 1, diffusion.halo_width());
    Applied a{Field(d, 1, diffusion.halo_width()), Field(d, 1, diffusion.halo_width())};
    for (int j = 0; j < a.u.n_y(); ++j) {
      for (int i = 0; i < a.u.n_x(); ++i) a.u.at(0, i, j) = value(i, j);
    }
    halo.exchange(a.u);
    diffusion.apply(a.u, a.lu, boundary.free_box(d));
    return a;
  }

  const Communicator self{MPI_COMM_SELF};

 private:
  std::deque<Decomposition> decompositions_;  // fields refer to theirs
};

double rough(int i, int j) { return testing::scatter(i, j) - 0.5; }

TEST_F(DiffusionOperatorTest, SpectralRadiusIsABoundAndAtMostATenthTooLarge) {
  for (const int order : {2, 4, 8}) {
    for (const Sides& x : testing::all_sides) {
      for (const int n : {16, 17}) {
        const testing::AssembledDiffusion line(self, testing::unit_grid_of_order(order, n, 0, x), x, testing::neumann, testing::zero,
                                               order);
        const Eigen::VectorXcd eigenvalues = Eigen::MatrixXd(line.matrix).eigenvalues();
        const double exact = -eigenvalues.real().minCoeff();
        const double bound = line.diffusion.spectral_radius(0);
        const std::string what = testing::name_of(x) + ", order " + std::to_string(order) + ", " + std::to_string(n) + " points";
        // Where the bound is attained, it is up to the rounding errors of the eigenvalue solver.
        EXPECT_GE(bound, exact * (1.0 - 1e-13)) << what;
        EXPECT_LE(bound, exact * 1.1) << what;
        EXPECT_LE(eigenvalues.imag().cwiseAbs().maxCoeff(), 1e-9 * exact) << what;
        EXPECT_LE(eigenvalues.real().maxCoeff(), 1e-12 * exact) << what;
      }
      for (const Sides& y : testing::all_sides) {
        const testing::AssembledDiffusion plane(self, testing::unit_grid_of_order(order, 11, 12, x, y), x, y, testing::zero, order);
        const double exact = -Eigen::MatrixXd(plane.matrix).eigenvalues().real().minCoeff();
        const double bound = plane.diffusion.spectral_radius(0);
        const std::string what = testing::name_of(x) + "/" + testing::name_of(y) + ", order " + std::to_string(order);
        EXPECT_GE(bound, exact * (1.0 - 1e-13)) << what;
        EXPECT_LE(bound, exact * 1.1) << what;
      }
    }
  }
}

TEST_F(DiffusionOperatorTest, SpectralRadiusOfAllIsThatOfTheFastestSpecies) {
  const Grid grid = testing::unit_grid(11, 21, testing::neumann);
  const Boundary boundary = Boundary::natural(grid);
  const DiffusionOperator diffusion(grid, boundary, {0.5, 0.0, 2.0}, 2);
  EXPECT_NEAR(diffusion.spectral_radius(), 4.0 * 2.0 * (100.0 + 400.0), 1e-9);
  EXPECT_NEAR(diffusion.spectral_radius(0), 4.0 * 0.5 * (100.0 + 400.0), 1e-9);
  EXPECT_EQ(diffusion.spectral_radius(1), 0.0);
  EXPECT_EQ(diffusion.diffusing_species(), (std::vector<int>{0, 2}));
}

TEST_F(DiffusionOperatorTest, CosinesAreEigenvectorsWithTheSymbolAsEigenvalue) {
  constexpr int n = 40;  // intervals
  for (const int order : {2, 4}) {
    for (const Sides& x : {testing::neumann, testing::periodic}) {
      for (int k = 0; k <= (x == testing::neumann ? n : n / 2); ++k) {
        const int half_waves = x == testing::neumann ? k : 2 * k;
        const auto mode = [&](int i) { return std::cos(std::numbers::pi * (half_waves * i % (2 * n)) / n); };
        const Applied a = apply(testing::unit_grid(x == testing::neumann ? n + 1 : n, 0, x), x, testing::neumann, order,
                                [&](int i, int) { return mode(i); });
        const double symbol = order == 2 ? 2.0 * mode(1) - 2.0 : (-2.0 * mode(2) + 32.0 * mode(1) - 30.0) / 12.0;
        for (int i = 0; i < a.u.n_x(); ++i) {
          ASSERT_NEAR(a.lu.at(0, i) / (n * n), symbol * mode(i), 1e-14) << "mode " << k << ", point " << i;
        }
      }
    }
  }
}

TEST_F(DiffusionOperatorTest, ConstantsGiveExactlyZero) {
  for (const int order : {2, 4, 8}) {
    for (const Sides& x : testing::all_sides) {
      for (const double c : {1.0, 0.1, -1e300, 3e-300, 4e-4}) {
        const Applied a =
            apply(testing::unit_grid_of_order(order, 19, 13, x, testing::neumann), x, testing::neumann, order, [&](int, int) { return c; });
        for (int j = 0; j < 13; ++j) {
          for (int i = 0; i < a.u.n_x(); ++i) ASSERT_EQ(a.lu.at(0, i, j), 0.0) << c << ", " << testing::name_of(x) << ", order " << order;
        }
      }
    }
  }
}

TEST_F(DiffusionOperatorTest, DataConstantInYHaveTheBitsOfOneDimension) {
  for (const int order : {2, 4}) {
    for (const Sides& x : testing::all_sides) {
      for (const Sides& y : {testing::periodic, testing::neumann}) {
        const Applied line = apply(testing::unit_grid(19, 0, x), x, testing::neumann, order, [](int i, int) { return rough(i, 0); });
        const Applied plane = apply(testing::unit_grid(19, 13, x, y), x, y, order, [](int i, int) { return rough(i, 0); });
        for (int j = 0; j < 13; ++j) {
          ASSERT_EQ(std::memcmp(plane.lu.row(0, j), line.lu.row(0, 0), 19 * sizeof(double)), 0) << testing::name_of(x) << ", row " << j;
        }
      }
    }
  }
}

TEST_F(DiffusionOperatorTest, TransposedDataGiveTransposedBits) {
  for (const int order : {2, 4, 8}) {
    for (const Sides& x : testing::all_sides) {
      for (const Sides& y : testing::all_sides) {
        const Applied a = apply(testing::unit_grid_of_order(order, 21, 21, x, y), x, y, order, rough);
        const Applied b = apply(testing::unit_grid_of_order(order, 21, 21, y, x), y, x, order, [](int i, int j) { return rough(j, i); });
        for (int j = 0; j < a.u.n_y(); ++j) {
          for (int i = 0; i < a.u.n_x(); ++i) {
            const double p = a.lu.at(0, i, j);
            const double q = b.lu.at(0, j, i);
            // Spacings are equal where both directions are periodic or both are not.
            if ((x == testing::periodic) == (y == testing::periodic)) {
              ASSERT_EQ(std::memcmp(&p, &q, sizeof p), 0) << testing::name_of(x) << "/" << testing::name_of(y) << " at " << i << ", " << j;
            } else {
              ASSERT_NEAR(p, q, 1e-12 * 21 * 21) << testing::name_of(x) << "/" << testing::name_of(y) << " at " << i << ", " << j;
            }
          }
        }
      }
    }
  }
}

TEST_F(DiffusionOperatorTest, MirroredDataGiveMirroredBits) {
  for (const int order : {2, 4, 8}) {
    for (const Sides& x : testing::all_sides) {
      for (const Sides& y : testing::all_sides) {
        const Sides x_mirrored{x[1], x[0]};
        const Sides y_mirrored{y[1], y[0]};
        const Grid grid = testing::unit_grid_of_order(order, 21, 14, x, y);
        const auto n = static_cast<int>(grid.points[0]);
        const auto m = static_cast<int>(grid.points[1]);
        const Applied a = apply(grid, x, y, order, rough);
        const Applied b = apply(testing::unit_grid_of_order(order, 21, 14, x_mirrored, y), x_mirrored, y, order,
                                [n](int i, int j) { return rough(n - 1 - i, j); });
        const Applied c = apply(testing::unit_grid_of_order(order, 21, 14, x, y_mirrored), x, y_mirrored, order,
                                [m](int i, int j) { return rough(i, m - 1 - j); });
        for (int j = 0; j < m; ++j) {
          for (int i = 0; i < n; ++i) {
            const double p = a.lu.at(0, i, j);
            const double q = b.lu.at(0, n - 1 - i, j);
            const double r = c.lu.at(0, i, m - 1 - j);
            ASSERT_EQ(std::memcmp(&p, &q, sizeof p), 0) << testing::name_of(x) << "/" << testing::name_of(y) << " at " << i << ", " << j;
            ASSERT_EQ(std::memcmp(&p, &r, sizeof p), 0) << testing::name_of(x) << "/" << testing::name_of(y) << " at " << i << ", " << j;
          }
        }
      }
    }
  }
}

TEST_F(DiffusionOperatorTest, RowsSplitAnywhereGiveTheSameBits) {
  constexpr int n = 37;
  const Grid grid = testing::unit_grid(n, 9, testing::periodic, testing::neumann);
  const Boundary boundary = Boundary::natural(grid);
  for (const int order : {2, 4, 8}) {
    const Applied whole = apply(grid, testing::periodic, testing::neumann, order, rough);
    const DiffusionOperator diffusion(grid, boundary, {1.0}, order);
    for (int split = 0; split <= n; ++split) {
      Field parts = whole.lu.similar();
      diffusion.apply(whole.u, parts, {0, split, 0, 9});
      diffusion.apply(whole.u, parts, {split, n, 0, 9});
      for (int j = 0; j < 9; ++j) {
        ASSERT_EQ(std::memcmp(parts.row(0, j), whole.lu.row(0, j), n * sizeof(double)), 0) << "order " << order << ", split " << split;
      }
    }
  }
}

TEST_F(DiffusionOperatorTest, OnlyTheBoxIsWritten) {
  const Grid grid = testing::unit_grid(19, 9, testing::neumann);
  const Boundary boundary = Boundary::natural(grid);
  const Decomposition d(self, grid, {0, 0}, 1);
  const DiffusionOperator diffusion(grid, boundary, {1.0, 0.0}, 2);
  Field u(d, 2, 1);
  Field lu(d, 2, 1);
  for (int s = 0; s < 2; ++s) {
    for (int j = -1; j < 10; ++j) std::fill(lu.row(s, j) - 1, lu.row(s, j) + 20, 7.0);
  }
  diffusion.apply(u, lu, {2, 17, 1, 8});
  for (int s = 0; s < 2; ++s) {
    for (int j = -1; j < 10; ++j) {
      for (int i = -1; i < 20; ++i) {
        ASSERT_EQ(lu.at(s, i, j), i >= 2 && i < 17 && j >= 1 && j < 8 ? 0.0 : 7.0) << s << " at " << i << ", " << j;
      }
    }
  }
}

TEST_F(DiffusionOperatorTest, WhatDoesNotDiffuseIsZeroWhateverItsHaloHolds) {
  const Grid grid = testing::unit_grid(9, 0, testing::neumann);
  const Boundary boundary = Boundary::natural(grid);
  const Decomposition d(self, grid, {0, 0}, 1);
  const DiffusionOperator diffusion(grid, boundary, {0.0, 1.0}, 2);
  Field u(d, 2, 1);
  Field lu(d, 2, 1);
  u.at(0, -1) = u.at(0, 9) = std::numeric_limits<double>::quiet_NaN();
  u.at(0, 4) = std::numeric_limits<double>::infinity();
  diffusion.apply(u, lu, {0, 9, 0, 1});
  for (int i = 0; i < 9; ++i) {
    EXPECT_EQ(lu.at(0, i), 0.0);
    EXPECT_FALSE(std::signbit(lu.at(0, i)));
  }
}

// One explicit step after the other changes the integral by rounding errors alone, and those do not add up in one direction.
TEST_F(DiffusionOperatorTest, TheIntegralIsConservedWithoutFlux) {
  for (const int order : {2, 4}) {
    for (const Sides& x : {testing::periodic, testing::neumann}) {
      constexpr int n = 65;
      const Grid grid = testing::unit_grid(n, 0, x);
      const Boundary boundary = Boundary::natural(grid);
      const Decomposition d(self, grid, {0, 0}, 1);
      const DiffusionOperator diffusion(grid, boundary, {1.0}, order);
      HaloExchange halo(d, boundary, 1, 1, diffusion.halo_width());
      Field u(d, 1, diffusion.halo_width());
      Field lu = u.similar();
      for (int i = 0; i < n; ++i) u.at(0, i) = 1.0 + rough(i, 0);
      // The weights of the trapezoidal rule are the left null vector of the second-order operator; of the fourth-order one at a mirror, too.
      const auto integral = [&] {
        double sum = 0.0;
        for (int i = 0; i < n; ++i) sum += u.at(0, i) * (x == testing::neumann && (i == 0 || i == n - 1) ? 0.5 : 1.0);
        return sum;
      };
      const double before = integral();
      const double dt = 1.5 / diffusion.spectral_radius();
      for (int step = 0; step < 1000; ++step) {
        halo.exchange(u);
        diffusion.apply(u, lu, {0, n, 0, 1});
        for (int i = 0; i < n; ++i) u.at(0, i) += dt * lu.at(0, i);
      }
      EXPECT_NEAR(integral(), before, 1e-13 * before) << testing::name_of(x) << ", order " << order;
    }
  }
}

TEST_F(DiffusionOperatorTest, BadSettingsAreInputErrors) {
  const Grid grid = testing::unit_grid(9, 0, testing::neumann);
  const Boundary boundary = Boundary::natural(grid);
  const auto expect = [&](std::vector<double> coefficients, int order, const std::string& start) {
    try {
      const DiffusionOperator diffusion(grid, boundary, std::move(coefficients), order);
      ADD_FAILURE() << start;
    } catch (const Error& e) {
      EXPECT_EQ(e.kind(), ErrorKind::input);
      EXPECT_EQ(std::string(e.what()).rfind(start, 0), 0U) << e.what();
    }
  };
  expect({1.0}, 3, "space.order: expected 2, 4 or 8, got 3");
  expect({1.0, -0.5}, 2, "model.diffusion: expected a coefficient >= 0, got -0.5");
  expect({std::numeric_limits<double>::quiet_NaN()}, 2, "model.diffusion: ");
  expect({std::numeric_limits<double>::infinity()}, 2, "model.diffusion: ");
}

}  // namespace
}  // namespace stiffront
