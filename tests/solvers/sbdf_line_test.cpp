// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/solvers/sbdf_line.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "stiffront/mesh/halo_exchange.hpp"
#include "stiffront/solvers/model_kernels.hpp"
#include "stiffront/space/coupled_rhs.hpp"
#include "support/diffusion_problem.hpp"

namespace stiffront {
namespace {

using testing::both_sides;
using testing::DiffusionProblem;
using testing::scatter;
using testing::unit_grid;

/// Two species coupled linearly: one Newton iteration solves the equation.
struct Linear {
  static constexpr int n_species = 2;
  static constexpr const char* name = "linear";
  static constexpr const char* source = "test";
  static constexpr std::array<const char*, 2> species{"u", "v"};
  static constexpr std::array<double, 2> diffusion{1.0, 1.0};
  static constexpr std::array<Parameter<Linear>, 0> parameters{};
  static constexpr std::array<Profile<Linear>, 0> profiles{};

  template <class T, class P>
  void rates(const T* u, T* du, const P&) const {
    du[0] = u[0] * -300.0 + u[1] * 200.0;
    du[1] = u[0] * 50.0 - u[1] * 80.0;
  }
};

struct Equation {
  Equation(int points, BoundaryKind kind, int order)
      : comm(MPI_COMM_SELF),
        problem(comm, unit_grid(points, 1, kind == BoundaryKind::periodic),
                {both_sides(kind, 2, [](double, double x, double) { return 1.0 + x; }), {}}, {3.0, 0.0}, order),
        model({}),
        rhs(problem.decomposition, problem.diffusion, model),
        halo(problem.decomposition, problem.boundary, 2, 1, problem.diffusion.halo_width(), problem.diffusion.diffusing_species()),
        line(model.make_sbdf_line(problem.decomposition)),
        v(problem.field([](int s, double x, double) { return scatter(std::lround(1e6 * x), s); })),
        r(problem.field([](int s, double x, double) { return scatter(std::lround(1e6 * x), s, 1); })),
        box(rhs.free_box()) {
    problem.boundary.impose(v, 0.0);
  }

  void iterate(double c) {
    Field out = v.similar();
    problem.boundary.impose(out, 0.0);
    halo.exchange(v);
    SbdfSweep sweep;
    sweep.gamma = gamma;
    sweep.decomposition = &v.decomposition();
    sweep.v = rows_of(v);
    sweep.r = rows_of(r);
    sweep.out = rows_of(out);
    line->iterate(problem.diffusion, sweep, c, box);
    swap(v, out);
  }
  /// Largest r - v + gamma F(v) over the points that evolve.
  double residual() {
    Field f = v.similar();
    rhs.evaluate(0.0, v, f);
    double largest = 0.0;
    for (int s = 0; s < 2; ++s) {
      for (int i = box.i_begin; i < box.i_end; ++i) {
        largest = std::max(largest, std::abs(r.at(s, i) - v.at(s, i) + gamma * f.at(s, i)));
      }
    }
    return largest;
  }

  const double gamma = 0.1;
  Communicator comm;
  DiffusionProblem problem;
  ModelKernelsOf<Linear> model;
  CoupledRhs rhs;
  HaloExchange halo;
  std::unique_ptr<SbdfLine> line;
  Field v;
  Field r;
  FreeBox box;
};

constexpr std::array kinds{BoundaryKind::neumann, BoundaryKind::dirichlet, BoundaryKind::periodic};

TEST(SbdfLine, SolvesALinearEquationOnceForAllWithSecondOrderDifferences) {
  for (BoundaryKind kind : kinds) {
    for (int points : {7, 8, 33, 100, 257}) {
      Equation e(points, kind, 2);
      const double before = e.residual();
      e.iterate(1.0);
      EXPECT_LT(e.residual(), 1e-12 * before) << points;
    }
  }
}

TEST(SbdfLine, TwoIterationsLeaveAFortyFifthWithFourthOrderDifferences) {
  for (BoundaryKind kind : kinds) {
    for (int points : {9, 33, 100}) {
      Equation e(points, kind, 4);
      Equation solved(points, kind, 4);
      for (int n = 0; n < 20; ++n) solved.iterate(1.0), solved.iterate(1.25);
      const auto distance = [&] {
        double squares = 0.0;
        for (int s = 0; s < 2; ++s) {
          for (int i = e.box.i_begin; i < e.box.i_end; ++i) squares += std::pow(e.v.at(s, i) - solved.v.at(s, i), 2);
        }
        return std::sqrt(squares);
      };
      const double before = distance();
      e.iterate(1.0);
      e.iterate(1.25);
      // The species are coupled and the matrix is not normal: a little more than for one mode.
      EXPECT_LT(distance(), before / 30.0) << points;
    }
  }
}

}  // namespace
}  // namespace stiffront
