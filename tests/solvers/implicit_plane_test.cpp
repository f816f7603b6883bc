// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "stiffront/mesh/halo_exchange.hpp"
#include "stiffront/solvers/implicit_part.hpp"
#include "stiffront/solvers/model_kernels.hpp"
#include "support/coupled_model.hpp"
#include "support/diffusion_problem.hpp"
#include "support/grids.hpp"

namespace stiffront {
namespace {

using testing::Coupled;
using testing::scatter;
using testing::Sides;

struct System {
  System(const Grid& grid, const Sides& x, const Sides& y, std::vector<double> coefficients)
      : comm(MPI_COMM_SELF),
        decomposition(comm, grid, {0, 0}, 4),
        boundary(testing::boundary_of(x, y, 2, testing::zero)),
        diffusion(grid, boundary, std::move(coefficients), 2),
        model({}),
        halo(decomposition, boundary, 2, 1, 1),
        free(boundary.free_box(decomposition)),
        at(decomposition, 2, 1),
        b(at.similar()) {
    for (int s = 0; s < 2; ++s) {
      for (int j = 0; j < b.n_y(); ++j) {
        for (int i = 0; i < b.n_x(); ++i)
          at.at(s, i, j) = scatter(i, j, s), b.at(s, i, j) = (s == 0 ? 1.0 : 1e-6) * (scatter(i, j, s + 7) - 0.3);
      }
    }
  }

  /// The largest |b - (1 - h J - h gamma D Laplacian) x| of the unknowns, relative to the largest |x| of the species.
  double residual(double h, double gamma, Field& x) {
    Field lap = x.similar();
    Field jx = x.similar();
    halo.exchange(x);
    diffusion.apply(x, lap, free);
    model.add_jacobian_product(0.0, at, x, jx, free);
    double largest = 0.0;
    for (int s = 0; s < 2; ++s) {
      double most = 0.0, size = 0.0;
      for (int j = free.j_begin; j < free.j_end; ++j) {
        for (int i = free.i_begin; i < free.i_end; ++i) {
          const double r = b.at(s, i, j) - (x.at(s, i, j) - h * (gamma * lap.at(s, i, j) + jx.at(s, i, j)));
          most = std::max(most, std::abs(r));
          size = std::max(size, std::abs(x.at(s, i, j)));
        }
      }
      largest = std::max(largest, most / size);
    }
    return largest;
  }

  std::int64_t solve(double h, double gamma, double tolerance, Field& x) {
    const auto part = make_multigrid_part(b, diffusion, model, {true, gamma}, tolerance);
    x.copy_interior(b);
    Work work;
    part->solve(0.0, h, at, x, work);
    return work.linear_iterations;
  }

  Communicator comm;
  Decomposition decomposition;
  Boundary boundary;
  DiffusionOperator diffusion;
  ModelKernelsOf<Coupled> model;
  HaloExchange halo;
  FreeBox free;
  Field at, b;
};

TEST(ImplicitPlaneTest, SolvesOnEveryKindOfBoundaryAndOddSizes) {
  for (const Sides& x : testing::all_sides) {
    for (const Sides& y : testing::all_sides) {
      for (const auto& [n_x, n_y] : {std::pair{37, 30}, {16, 45}, {5, 9}}) {
        System system(testing::unit_grid(n_x, n_y, x, y), x, y, {3.0, 0.4});
        Field solution = system.b.similar();
        const std::int64_t iterations = system.solve(0.02, 2.0, 1e-10, solution);
        const std::string what =
            testing::name_of(x) + " x " + testing::name_of(y) + ", " + std::to_string(n_x) + " x " + std::to_string(n_y);
        EXPECT_LE(system.residual(0.02, 2.0, solution), 1e-7) << what;
        EXPECT_LE(iterations, 20) << what;
        // Values of Dirichlet points are what they were.
        if (x == testing::dirichlet) {
          EXPECT_EQ(solution.at(0, 0, 2), system.b.at(0, 0, 2)) << what;
        }
      }
    }
  }
}

TEST(ImplicitPlaneTest, IterationsDoNotGrowWithTheNumberOfPointsOrTheStep) {
  std::int64_t most = 0, fewest = 100;
  for (int n : {33, 66, 129}) {
    for (double h : {1e-3, 1e-2, 1e-1}) {
      System system(testing::unit_grid(n, n, testing::neumann, testing::periodic), testing::neumann, testing::periodic, {1.0, 1.0});
      Field solution = system.b.similar();
      const std::int64_t iterations = system.solve(h, 1.0, 1e-6, solution);
      most = std::max(most, iterations), fewest = std::min(fewest, iterations);
    }
  }
  EXPECT_LE(most, 12);
  EXPECT_LE(most - fewest, 5);
}

TEST(ImplicitPlaneTest, StretchedCellsAreCoarsenedInTheStrongDirectionOnly) {
  for (const auto& [width, height] : {std::pair{0.05, 1.0}, {1.0, 0.05}}) {
    Grid grid = testing::unit_grid(49, 57, testing::neumann, testing::mixed);
    grid.upper = {width, height};
    System system(grid, testing::neumann, testing::mixed, {1.0, 0.0});
    Field solution = system.b.similar();
    EXPECT_LE(system.solve(0.01, 1.0, 1e-8, solution), 20);
    EXPECT_LE(system.residual(0.01, 1.0, solution), 1e-8 * 4e4);  // the norm of the matrix is above 4e4
  }
}

TEST(ImplicitPlaneTest, NextToSubCellsItIsTheOperatorOfOneDimension) {
  // What does not vary along y is solved as on a line, where the system is assembled from the distances between points.
  const Grid plane = testing::unit_grid_of_order(8, 30, 9, testing::dirichlet, testing::neumann);
  const Grid line = testing::unit_grid_of_order(8, 30, 0, testing::dirichlet);
  const Communicator self(MPI_COMM_SELF);
  const ModelKernelsOf<Coupled> model({});
  const auto solve = [&](const Grid& grid) {
    const Decomposition decomposition(self, grid, {0, 0}, 4);
    const Boundary boundary(testing::boundary_of(testing::dirichlet, testing::neumann, 2, testing::zero));
    const DiffusionOperator diffusion(grid, boundary, {3.0, 0.4}, 8);
    Field at(decomposition, 2, 4);
    Field b = at.similar();
    for (int s = 0; s < 2; ++s) {
      for (int j = 0; j < b.n_y(); ++j) {
        for (int i = 0; i < b.n_x(); ++i) at.at(s, i, j) = scatter(i, 0, s), b.at(s, i, j) = scatter(i, 0, s + 7) - 0.3;
      }
    }
    const auto part = grid.dimension == 2 ? make_multigrid_part(b, diffusion, model, {true, 2.0}, 1e-12)
                                          : make_block_tridiagonal_part(b, diffusion, model, {true, 2.0});
    Work work;
    part->solve(0.0, 0.02, at, b, work);
    return std::vector<double>(b.row(0, 0), b.row(0, 0) + b.n_x());
  };
  const std::vector<double> on_the_line = solve(line);
  const std::vector<double> in_the_plane = solve(plane);
  ASSERT_EQ(on_the_line.size(), in_the_plane.size());
  for (std::size_t i = 0; i < on_the_line.size(); ++i) EXPECT_NEAR(in_the_plane[i], on_the_line[i], 1e-10) << i;
}

TEST(ImplicitPlaneTest, ChangesThatAreRoundOffAreNotIteratedOn) {
  System system(testing::unit_grid(33, 33, testing::neumann), testing::neumann, testing::neumann, {1.0, 1.0});
  Field solution = system.b.similar();
  for (int s = 0; s < 2; ++s) {
    for (int j = 0; j < 33; ++j) {
      for (int i = 0; i < 33; ++i) system.b.at(s, i, j) = 1e-22 * scatter(i, j, s);
    }
  }
  EXPECT_EQ(system.solve(0.01, 1.0, 1e-6, solution), 0);
}

TEST(ImplicitPlaneTest, IsRefusedInOneDimension) {
  System system(testing::unit_grid(33, 0, testing::neumann), testing::neumann, testing::neumann, {1.0, 1.0});
  EXPECT_THROW(make_multigrid_part(system.b, system.diffusion, system.model, {}, 1e-6), Error);
}

}  // namespace
}  // namespace stiffront
