// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/solvers/model_kernels.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

#include "stiffront/model/builtin/bz.hpp"

namespace stiffront {
namespace {

/// Rates and Jacobian that depend on time and place, so that a cell evaluated at another one's place shows.
struct Placed {
  static constexpr int n_species = 2;
  static constexpr const char* name = "placed";
  static constexpr const char* source = "test";
  static constexpr std::array<const char*, 2> species{"u", "v"};
  static constexpr std::array<double, 2> diffusion{1.0, 1.0};
  static constexpr std::array<Parameter<Placed>, 0> parameters{};
  static constexpr std::array<Profile<Placed>, 0> profiles{};

  template <class T, class P>
  void rates(const T* u, T* du, const P& place) const {
    du[0] = (3.0 + place.x) * u[0] * u[1] - place.y;
    du[1] = place.t * u[0] - (9.0 + 4.0 * place.x) * u[1] * u[1];
  }
};

Grid grid_2d(int n_x, int n_y) {
  Grid grid;
  grid.dimension = 2;
  grid.points = {n_x, n_y};
  grid.lower = {-1.0, 2.0};
  grid.upper = {1.5, 3.0};
  return grid;
}

class ModelKernelsTest : public ::testing::Test {
 protected:
  ModelKernelsTest() : comm(MPI_COMM_SELF), grid(grid_2d(29, 5)), d(comm, grid, {0, 0}, 1), u(d, 2, 2), du(d, 2, 2) {
    std::mt19937_64 engine(7);
    std::uniform_real_distribution<double> uniform(0.1, 1.0);
    for (int s = 0; s < 2; ++s) {
      for (int j = 0; j < 5; ++j) {
        for (int i = 0; i < 29; ++i) u.at(s, i, j) = uniform(engine);
      }
    }
  }

  Communicator comm;
  Grid grid;
  Decomposition d;
  Field u;
  Field du;
  const ModelKernelsOf<Placed> kernels{std::map<std::string, double>{}};
};

TEST_F(ModelKernelsTest, RatesAreAddedToTheBoxAndNowhereElseWithTheBitsOfOneCell) {
  const FreeBox box{3, 27, 1, 4};
  for (int s = 0; s < 2; ++s) {
    for (int j = -2; j < 7; ++j) {
      for (int i = -2; i < 31; ++i) du.at(s, i, j) = 1.0 + i + 100 * j;
    }
  }
  kernels.add_rates(0.75, u, du, box);
  for (int j = -2; j < 7; ++j) {
    for (int i = -2; i < 31; ++i) {
      double rates[2] = {0.0, 0.0};
      if (i >= box.i_begin && i < box.i_end && j >= box.j_begin && j < box.j_end) {
        const double cell[2] = {u.at(0, i, j), u.at(1, i, j)};
        kernels.rates_at(0.75, grid.position(0, i), grid.position(1, j), cell, rates);
      }
      for (int s = 0; s < 2; ++s) {
        ASSERT_EQ(du.at(s, i, j), (1.0 + i + 100 * j) + rates[s]) << s << " at " << i << ", " << j;
      }
    }
  }
}

TEST_F(ModelKernelsTest, RatesHaveTheSameBitsHoweverTheRowIsSplit) {
  kernels.add_rates(0.75, u, du, {0, 29, 0, 5});
  for (int split = 1; split < 29; ++split) {
    Field parts = du.similar();
    kernels.add_rates(0.75, u, parts, {0, split, 0, 5});
    kernels.add_rates(0.75, u, parts, {split, 29, 0, 5});
    for (int s = 0; s < 2; ++s) {
      for (int j = 0; j < 5; ++j) {
        ASSERT_EQ(std::memcmp(parts.row(s, j), du.row(s, j), 29 * sizeof(double)), 0) << "split at " << split;
      }
    }
  }
}

TEST_F(ModelKernelsTest, JacobianBoundIsThatOfTheWorstCellHoweverTheRowIsSplit) {
  double largest = 0.0;
  double radius = 0.0;
  for (int j = 0; j < 5; ++j) {
    for (int i = 0; i < 29; ++i) {
      const double cell[2] = {u.at(0, i, j), u.at(1, i, j)};
      double a[4];
      kernels.jacobian_at(0.75, grid.position(0, i), grid.position(1, j), cell, a);
      const double rows = std::max(std::abs(a[0]) + std::abs(a[1]), std::abs(a[2]) + std::abs(a[3]));
      const double columns = std::max(std::abs(a[0]) + std::abs(a[2]), std::abs(a[1]) + std::abs(a[3]));
      largest = std::max(largest, std::min(rows, columns));
      const std::complex<double> root = std::sqrt(std::complex<double>(0.25 * (a[0] - a[3]) * (a[0] - a[3]) + a[1] * a[2]));
      radius = std::max({radius, std::abs(0.5 * (a[0] + a[3]) + root), std::abs(0.5 * (a[0] + a[3]) - root)});
    }
  }
  const double bound = kernels.jacobian_bound(0.75, u, {0, 29, 0, 5});
  EXPECT_LE(bound, largest * (1 + 1e-12));  // powers of the Jacobian do better than its norms
  EXPECT_GE(bound, radius * (1 - 1e-12));
  EXPECT_LE(bound, 1.2 * radius);
  for (int split = 1; split < 29; ++split) {
    EXPECT_EQ(std::max(kernels.jacobian_bound(0.75, u, {0, split, 0, 5}), kernels.jacobian_bound(0.75, u, {split, 29, 0, 5})), bound)
        << "split at " << split;
  }
}

TEST_F(ModelKernelsTest, JacobianBoundShowsWhatIsNotFinite) {
  for (int i = 0; i < 29; ++i) {
    Field bad = u.similar();
    bad.copy_interior(u);
    bad.at(1, i, 2) = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(kernels.jacobian_bound(0.75, bad, {0, 29, 0, 5}), std::numeric_limits<double>::infinity()) << i;
  }
}

TEST_F(ModelKernelsTest, ParametersOfTheCaseReachTheRates) {
  const ModelKernelsOf<Bz> bz(std::map<std::string, double>{{"f", 3.0}, {"mu", 1e-3}});
  const double cell[3] = {1.0, 0.5, 0.25};
  double rates[3];
  bz.rates_at(0.0, 0.0, 0.0, cell, rates);
  EXPECT_NEAR(rates[0], (3.0 * 0.25 - 2e-3 * 1.0 - 0.5) / 1e-3, 1e-10);
}

}  // namespace
}  // namespace stiffront
