// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "stiffront/control/parareal.hpp"
#include "stiffront/mesh/field_algebra.hpp"
#include "support/diffusion_problem.hpp"

namespace stiffront {
namespace {

using testing::both_sides;
using testing::DiffusionProblem;
using testing::unit_grid;

/// u' = -u + sin(3 u) x, by one or many steps of Euler's method: no accuracy is needed, only two propagators that differ.
void propagate(Field& from, Field& to, double dt, int steps) {
  to.copy_interior(from);
  for (int n = 0; n < steps; ++n) {
    for (int i = 0; i < to.n_x(); ++i) {
      double& u = to.at(0, i);
      u += dt / steps * (std::sin(3.0 * u) * (i + 1.0) / to.n_x() - u);
    }
  }
}

std::vector<std::vector<double>> iterated(const Communicator& time, const Field& u, int intervals, int iterations) {
  Parareal parareal(u, intervals, time, [](int, Field& from, Field& to) { propagate(from, to, 0.3, 1); });
  parareal.predict(u);
  for (int k = 0; k < iterations; ++k) {
    parareal.iterate([](std::vector<Field>& states, std::vector<Field>& results) {
      for (std::size_t j = 0; j < results.size(); ++j) propagate(states[j], results[j], 0.3, 50);
    });
  }
  std::vector<std::vector<double>> states(static_cast<std::size_t>(intervals));
  for (int i = parareal.first(); i < parareal.last(); ++i) {
    const Field& right = parareal.state(i - parareal.first() + 1);
    states[static_cast<std::size_t>(i)].assign(right.row(0, 0), right.row(0, 0) + right.n_x());
  }
  return states;
}

TEST(PararealMpi, GroupsInTimeLeaveTheBitsOfOneProcess) {
  const Communicator self(MPI_COMM_SELF);
  const Communicator world(MPI_COMM_WORLD);
  const DiffusionProblem p(self, unit_grid(33, 1), {both_sides(BoundaryKind::neumann, 1), both_sides(BoundaryKind::neumann, 1)}, {1.0}, 2);
  const Field u = p.field([](int, double x, double) { return 0.5 + std::cos(3.0 * x); });
  for (const int intervals : {4, 7}) {
    for (const int iterations : {0, 1, 3}) {
      const auto alone = iterated(self, u, intervals, iterations);
      const auto shared = iterated(world, u, intervals, iterations);
      int mine = 0;
      for (std::size_t i = 0; i < alone.size(); ++i) {
        if (shared[i].empty()) continue;
        ++mine;
        EXPECT_EQ(shared[i], alone[i]) << "interval " << i << " after " << iterations;
      }
      EXPECT_EQ(world.sum(static_cast<std::int64_t>(mine)), intervals);
    }
  }
}

}  // namespace
}  // namespace stiffront
