// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "stiffront/control/evolve.hpp"
#include "stiffront/control/spectral_deferred_correction.hpp"
#include "stiffront/model/builtin/brusselator.hpp"
#include "stiffront/solvers/model_kernels.hpp"
#include "stiffront/space/coupled_rhs.hpp"
#include "support/diffusion_problem.hpp"
#include "support/grids.hpp"

namespace stiffront {
namespace {

/// The Brusselator on 21 x 18 points, periodic in x, from smooth data.
class PlaneProblem {
 public:
  PlaneProblem()
      : comm_(MPI_COMM_SELF),
        grid_(testing::unit_grid(21, 18, testing::periodic)),
        boundary_(testing::boundary_of(testing::periodic, testing::neumann, 2, testing::zero)),
        decomposition_(comm_, grid_, {1, 1}, 1),
        diffusion_(grid_, boundary_, {0.02, 0.01}, 2),
        model_({{"A", 1.0}, {"B", 3.0}}),
        rhs_(decomposition_, diffusion_, model_),
        part_(make_multigrid_part(Field(decomposition_, 2, 1), diffusion_, model_, {}, 1e-6)) {}

  Field solve(int steps, SpectralDeferredCorrectionOptions o) {
    o.fixed_step = 1.0 / steps;
    Field u(decomposition_, 2, 1);
    for (int j = 0; j < u.n_y(); ++j) {
      for (int i = 0; i < u.n_x(); ++i) {
        const double x = 2.0 * M_PI * grid_.position(0, i), y = M_PI * grid_.position(1, j);
        u.at(0, i, j) = 1.0 + 0.3 * std::sin(x) * std::cos(y);
        u.at(1, i, j) = 3.0 + 0.4 * std::cos(x) * std::cos(y);
      }
    }
    SpectralDeferredCorrection method(u, rhs_, *part_, &model_, o);
    Schedule schedule;
    schedule.end = 1.0;
    Progress progress;
    Observer nobody;
    evolve(method, schedule, u, progress, nobody);
    return u;
  }

  static double distance(const Field& a, const Field& b) {
    double largest = 0.0;
    for (int s = 0; s < 2; ++s) {
      for (int j = 0; j < a.n_y(); ++j) {
        for (int i = 0; i < a.n_x(); ++i) largest = std::max(largest, std::abs(a.at(s, i, j) - b.at(s, i, j)));
      }
    }
    return largest;
  }

 private:
  Communicator comm_;
  Grid grid_;
  Boundary boundary_;
  Decomposition decomposition_;
  DiffusionOperator diffusion_;
  ModelKernelsOf<Brusselator> model_;
  CoupledRhs rhs_;
  std::unique_ptr<ImplicitPart> part_;
};

TEST(SpectralDeferredCorrectionInTwoDimensionsTest, HasTheOrdersOfOneDimension) {
  PlaneProblem problem;
  const auto options = [](NodeFamily nodes, int m, int k, int corrections) {
    SpectralDeferredCorrectionOptions o;
    o.nodes = nodes;
    o.node_count = m;
    o.starting_order = k;
    o.corrections = corrections;
    return o;
  };
  const Field exact = problem.solve(80, options(NodeFamily::gauss_radau, 5, 2, 7));
  const auto order = [&](SpectralDeferredCorrectionOptions o, int steps) {
    return std::log2(PlaneProblem::distance(problem.solve(steps, o), exact) / PlaneProblem::distance(problem.solve(2 * steps, o), exact));
  };
  EXPECT_NEAR(order(options(NodeFamily::gauss_radau, 4, 1, 1), 40), 2.0, 0.3);
  EXPECT_NEAR(order(options(NodeFamily::gauss_radau, 2, 1, 2), 40), 3.0, 0.3);
  EXPECT_NEAR(order(options(NodeFamily::gauss_radau, 3, 2, 3), 40), 5.0, 0.4);
  EXPECT_NEAR(order(options(NodeFamily::gauss_legendre, 2, 1, 3), 40), 4.0, 0.4);
  EXPECT_NEAR(order(options(NodeFamily::gauss_lobatto, 3, 2, 2), 40), 4.0, 0.4);
  EXPECT_GE(order(options(NodeFamily::gauss_radau, 4, 2, 5), 10), 6.0);
}

}  // namespace
}  // namespace stiffront
