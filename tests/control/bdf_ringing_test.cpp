// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/bdf_ringing.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>

#include "stiffront/model/builtin/slaved_oscillator.hpp"
#include "stiffront/solvers/model_kernels.hpp"
#include "support/diffusion_problem.hpp"

namespace stiffront {
namespace {

using testing::both_sides;
using testing::DiffusionProblem;
using testing::unit_grid;

/// Whether any step rings for a mode at this angle from the negative real axis.
bool rings_somewhere(int order, double degrees) {
  const double angle = std::acos(-1.0) * (1.0 - degrees / 180.0);
  for (double size = 0.05; size < 100.0; size *= 1.05) {
    if (bdf_rings(order, std::polar(size, angle))) return true;
  }
  return false;
}

TEST(BdfRinging, BeginsAtTheKnownAnglesOfTheOrders) {
  EXPECT_FALSE(rings_somewhere(2, 89.9));
  EXPECT_FALSE(rings_somewhere(3, 86.0));
  EXPECT_TRUE(rings_somewhere(3, 87.5));
  EXPECT_FALSE(rings_somewhere(4, 73.0));
  EXPECT_TRUE(rings_somewhere(4, 75.0));
  EXPECT_FALSE(rings_somewhere(5, 51.0));
  EXPECT_TRUE(rings_somewhere(5, 53.0));
}

TEST(BdfRinging, IsNoneOfGrowingModesAndOfAccurateSteps) {
  EXPECT_FALSE(bdf_rings(5, {0.1, 2.0}));
  EXPECT_FALSE(bdf_rings(5, {-1e-3, 0.1}));
}

TEST(BdfRinging, TheHighestQuietOrderFollowsTheModelsEigenvalues) {
  const Communicator self(MPI_COMM_SELF);
  const DiffusionProblem p(self, unit_grid(9, 1), {both_sides(BoundaryKind::neumann, 3), both_sides(BoundaryKind::neumann, 3)},
                           {0.1, 0.0, 0.0}, 2);
  const Field u = p.field([](int s, double x, double) { return s == 2 ? 0.0 : x; });
  const FreeBox box{0, 9, 0, 1};
  const auto quiet = [&](double damping, double omega, double dt) {
    const ModelKernelsOf<SlavedOscillator> model({{"damping", damping}, {"omega", omega}});
    return highest_quiet_order(5, 0.0, dt, u, model, box);
  };
  EXPECT_EQ(quiet(5.0, 500.0, 2e-3), 2);    // 89.4 degrees, one radian a step
  EXPECT_EQ(quiet(20.0, 200.0, 8e-3), 3);   // 84.3 degrees
  EXPECT_EQ(quiet(100.0, 200.0, 8e-3), 4);  // 63.4 degrees
  EXPECT_EQ(quiet(200.0, 200.0, 8e-3), 5);  // 45 degrees
  EXPECT_EQ(quiet(5.0, 500.0, 1e-4), 5);    // accurate
  EXPECT_EQ(quiet(5.0, 500.0, 0.1), 5);     // beyond: damped
}

}  // namespace
}  // namespace stiffront
