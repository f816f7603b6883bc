// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "stiffront/control/evolve.hpp"
#include "stiffront/control/spectral_deferred_correction.hpp"
#include "stiffront/solvers/model_kernels.hpp"
#include "stiffront/space/coupled_rhs.hpp"
#include "support/diffusion_problem.hpp"
#include "support/grids.hpp"

namespace stiffront {
namespace {

using Options = SpectralDeferredCorrectionOptions;

/// Van der Pol's equation with a slow manifold.
struct StiffOscillator {
  static constexpr int n_species = 2;
  static constexpr const char* name = "stiff oscillator";
  static constexpr const char* source = "test";
  static constexpr std::array<const char*, 2> species{"u", "v"};
  static constexpr std::array<double, 2> diffusion{0.0, 0.0};
  static constexpr std::array<Parameter<StiffOscillator>, 0> parameters{};
  static constexpr std::array<Profile<StiffOscillator>, 0> profiles{};

  template <class T, class P>
  void rates(const T* u, T* du, const P&) const {
    du[0] = u[1];
    du[1] = ((1.0 - u[0] * u[0]) * u[1] - u[0]) * 1e3;
  }
};

class StiffProblem {
 public:
  StiffProblem()
      : comm_(MPI_COMM_SELF),
        grid_(testing::unit_grid(5, 0, testing::neumann)),
        boundary_(testing::boundary_of(testing::neumann, testing::neumann, 2, testing::zero)),
        decomposition_(comm_, grid_, {1, 1}, 1),
        diffusion_(grid_, boundary_, {0.0, 0.0}, 2),
        model_({}),
        rhs_(decomposition_, diffusion_, model_),
        part_(make_cell_local_part(Field(decomposition_, 2, 1), diffusion_, model_, {})) {}

  /// v at t = 1/2 from the slow manifold.
  double solve(int steps, Options o) {
    o.fixed_step = 0.5 / steps;
    Field u(decomposition_, 2, 1);
    for (int i = 0; i < u.n_x(); ++i) u.at(0, i) = 2.0, u.at(1, i) = -0.66666654321;
    SpectralDeferredCorrection method(u, rhs_, *part_, &model_, o);
    Schedule schedule;
    schedule.end = 0.5;
    Progress progress;
    Observer nobody;
    evolve(method, schedule, u, progress, nobody);
    return u.at(1, 2);
  }

 private:
  Communicator comm_;
  Grid grid_;
  Boundary boundary_;
  Decomposition decomposition_;
  DiffusionOperator diffusion_;
  ModelKernelsOf<StiffOscillator> model_;
  CoupledRhs rhs_;
  std::unique_ptr<ImplicitPart> part_;
};

TEST(AcceleratedCorrectionsTest, GiveBackTheOrderThatStiffnessTakesAndNeedFewerSweeps) {
  StiffProblem problem;
  Options o;
  o.node_count = 4;
  o.starting_order = 2;
  o.corrections = 8;
  o.accelerate = true;
  const double exact = problem.solve(320, o);
  const auto error = [&](int steps, int corrections, bool accelerate) {
    o.corrections = corrections;
    o.accelerate = accelerate;
    return std::abs(problem.solve(steps, o) - exact);
  };
  const auto order = [&](int corrections, bool accelerate) {
    return std::log2(error(10, corrections, accelerate) / error(20, corrections, accelerate));
  };
  EXPECT_LT(order(5, false), 2.6);
  EXPECT_GT(order(5, true), 3.8);
  EXPECT_LT(error(10, 5, true), 1e-3 * error(10, 5, false));
  // Five accelerated sweeps are worth more than twelve plain ones.
  EXPECT_LT(error(10, 5, true), 0.1 * error(10, 12, false));
}

/// u' = -u + v, v' = -u: the rotation and the decay do not commute.
class Turning final : public RightHandSide {
 public:
  explicit Turning(const Grid& grid) : boundary_(Boundary::natural(grid)) {}
  void evaluate(double, Field& u, Field& du) override {
    for (int i = 0; i < u.n_x(); ++i) {
      du.at(0, i) = u.at(1, i) - u.at(0, i);
      du.at(1, i) = -u.at(0, i);
    }
  }
  const Boundary& boundary() const override { return boundary_; }

 private:
  Boundary boundary_;
};

/// Strang's splitting of it with exact flows.
class ExactStrang final : public StepPropagator {
 public:
  void advance(double, double h, Field& from, Field& to, Attempt&) override {
    const double decay = std::exp(-0.5 * h), c = std::cos(h), s = std::sin(h);
    for (int i = 0; i < from.n_x(); ++i) {
      const double u = decay * from.at(0, i), v = from.at(1, i);
      to.at(0, i) = decay * (c * u + s * v);
      to.at(1, i) = c * v - s * u;
    }
  }
  void visit_state(StateVisitor&) override {}
};

TEST(PropagatedCorrectionsTest, StrangGainsAnOrderWithEverySweepOnEveryNodeFamily) {
  const Communicator comm(MPI_COMM_SELF);
  const Decomposition decomposition(comm, Grid{1, {2, 1}}, {1, 1}, 1);
  Turning equation(decomposition.grid());
  ExactStrang strang;
  // The matrix [[-1, 1], [-1, 0]] has the eigenvalues (-1 +- i sqrt 3)/2.
  const double w = std::sqrt(3.0) / 2.0, end = 2.0, decay = std::exp(-0.5 * end);
  const double exact_u = decay * (std::cos(w * end) + (-0.5 * 1.0 + 0.5) / w * std::sin(w * end));
  const auto error = [&](NodeFamily nodes, int m, int corrections, Options::FinalUpdate final_update, int steps) {
    Options o;
    o.nodes = nodes;
    o.node_count = m;
    o.starting_order = 2;
    o.corrections = corrections;
    o.final_update = final_update;
    o.fixed_step = end / steps;
    Field u(decomposition, 2, 0);
    for (int i = 0; i < 2; ++i) u.at(0, i) = 1.0, u.at(1, i) = 0.5;
    SpectralDeferredCorrection method(u, equation, strang, nullptr, o);
    Schedule schedule;
    schedule.end = end;
    Progress progress;
    Observer nobody;
    evolve(method, schedule, u, progress, nobody);
    return std::abs(u.at(0, 0) - exact_u);
  };
  const auto order = [&](NodeFamily nodes, int m, int corrections, Options::FinalUpdate final_update, int steps) {
    return std::log2(error(nodes, m, corrections, final_update, steps) / error(nodes, m, corrections, final_update, 2 * steps));
  };
  using enum Options::FinalUpdate;
  for (int corrections = 0; corrections <= 6; ++corrections) {
    const int steps = corrections < 3 ? 32 : 8;
    EXPECT_NEAR(order(NodeFamily::gauss_radau, 4, corrections, last_node, steps), std::min(2 + corrections, 7), 0.5) << corrections;
    EXPECT_NEAR(order(NodeFamily::gauss_legendre, 3, corrections, quadrature, steps), std::min(3 + corrections, 6), 0.5) << corrections;
    EXPECT_NEAR(order(NodeFamily::gauss_lobatto, 4, corrections, last_node, steps), std::min(2 + corrections, 6), 0.5) << corrections;
  }
}

}  // namespace
}  // namespace stiffront
