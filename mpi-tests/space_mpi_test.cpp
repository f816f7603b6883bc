// SPDX-License-Identifier: BSD-3-Clause
// Diffusion, reaction and their sum have the bits of one process on any layout of the ranks.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "stiffront/solvers/model_registry.hpp"
#include "stiffront/space/coupled_rhs.hpp"
#include "support/diffusion_problem.hpp"
#include "support/grids.hpp"

namespace stiffront {
namespace {

using testing::Sides;

double wall(double t, double x, double y) { return 0.25 + 0.125 * t + 0.1 * x + 0.05 * y; }

/// One right-hand side on one decomposition.
struct Evaluated {
  Evaluated(const Communicator& comm, const Grid& grid, const Sides& x, const Sides& y, std::array<int, 2> processes, int order,
            const ModelKernels& model, const std::vector<double>& coefficients)
      : decomposition(comm, grid, processes, grid.has_sub_cells(0) || grid.has_sub_cells(1) ? 10 : order / 2),
        boundary(testing::boundary_of(x, y, model.n_species(), wall)),
        diffusion(grid, boundary, coefficients, order),
        u(decomposition, model.n_species(), order / 2),
        du(u.similar()) {
    const Decomposition& d = decomposition;
    for (int s = 0; s < u.n_species(); ++s) {
      for (int j = 0; j < u.n_y(); ++j) {
        for (int i = 0; i < u.n_x(); ++i) u.at(s, i, j) = testing::scatter(d.offset_x() + i, d.offset_y() + j, s);
      }
    }
    boundary.impose(u, 0.45);
    CoupledRhs rhs(decomposition, diffusion, model);
    rhs.evaluate(0.45, u, du);
    bound = comm.max(model.jacobian_bound(0.45, u, rhs.free_box()));
  }

  Decomposition decomposition;
  Boundary boundary;
  DiffusionOperator diffusion;
  Field u;
  Field du;
  double bound;
};

class SpaceMpiTest : public ::testing::Test {
 protected:
  SpaceMpiTest() { register_builtin_models(registry); }

  void check(const std::string& model_name, const Grid& grid, const Sides& x, const Sides& y, int order) const {
    const auto model = registry.make(model_name, {});
    const std::vector<double> coefficients = model->description().diffusion;
    const Evaluated serial(self, grid, x, y, {0, 0}, order, *model, coefficients);
    for (int p = 1; p <= world.size(); ++p) {
      if (world.size() % p != 0 || (grid.dimension == 1 && p != world.size())) continue;
      const Evaluated here(world, grid, x, y, {p, world.size() / p}, order, *model, coefficients);
      const Decomposition& d = here.decomposition;
      for (int s = 0; s < model->n_species(); ++s) {
        for (int j = 0; j < d.n_y(); ++j) {
          const double* expected = serial.du.row(s, static_cast<int>(d.offset_y()) + j) + d.offset_x();
          ASSERT_EQ(std::memcmp(here.du.row(s, j), expected, static_cast<std::size_t>(d.n_x()) * sizeof(double)), 0)
              << model_name << ", " << testing::name_of(x) << "/" << testing::name_of(y) << ", order " << order << ", " << p << " x "
              << world.size() / p << " ranks, species " << s << ", row " << j;
        }
      }
      ASSERT_EQ(here.bound, serial.bound) << model_name;
    }
  }

  const Communicator world{MPI_COMM_WORLD};
  const Communicator self{MPI_COMM_SELF};
  ModelRegistry registry;
};

TEST_F(SpaceMpiTest, RightHandSidesHaveTheSerialBitsInTwoDimensions) {
  for (const Sides& x : testing::all_sides) {
    for (const Sides& y : testing::all_sides) {
      for (const int order : {2, 4}) {
        check("bz", testing::unit_grid(67, 61, x, y), x, y, order);
        check("fitzhugh-nagumo", testing::unit_grid(23, 19, x, y), x, y, order);
        // Boxes down to the width of the halo.
        check("brusselator", testing::unit_grid(9, 8, x, y), x, y, order);
      }
      check("brusselator", testing::unit_grid_of_order(8, 47, 41, x, y), x, y, 8);
    }
  }
}

TEST_F(SpaceMpiTest, RightHandSidesHaveTheSerialBitsInOneDimension) {
  for (const Sides& x : testing::all_sides) {
    for (const int order : {2, 4}) {
      for (int n = 8; n < 60; n += 3) check("bz", testing::unit_grid(n, 0, x), x, testing::neumann, order);
    }
    for (int n = 41; n < 60; ++n) check("bz", testing::unit_grid_of_order(8, n, 0, x), x, testing::neumann, 8);
  }
}

TEST_F(SpaceMpiTest, EveryBuiltInModelHasTheSerialBits) {
  for (const ModelDescription& model : registry.descriptions()) {
    check(model.name, testing::unit_grid(37, 0, testing::neumann), testing::neumann, testing::neumann, 2);
    check(model.name, testing::unit_grid(19, 17, testing::periodic), testing::periodic, testing::neumann, 4);
  }
}

TEST_F(SpaceMpiTest, ProfilesHaveTheSerialBits) {
  for (const ModelDescription& description : registry.descriptions()) {
    const auto model = registry.make(description.name, {});
    const Grid grid = testing::unit_grid(33, 21, testing::neumann);
    const Decomposition whole(self, grid, {0, 0}, 1);
    const Decomposition part(world, grid, {0, 0}, 1);
    for (const auto& profile : description.profiles) {
      Field u(whole, model->n_species(), 1);
      Field v(part, model->n_species(), 1);
      model->initialise(profile.name, u);
      model->initialise(profile.name, v);
      for (int s = 0; s < model->n_species(); ++s) {
        for (int j = 0; j < part.n_y(); ++j) {
          ASSERT_EQ(std::memcmp(v.row(s, j), u.row(s, static_cast<int>(part.offset_y()) + j) + part.offset_x(),
                                static_cast<std::size_t>(part.n_x()) * sizeof(double)),
                    0)
              << profile.name << ", row " << j;
        }
      }
    }
  }
}

}  // namespace
}  // namespace stiffront
