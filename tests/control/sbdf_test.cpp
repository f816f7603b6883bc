// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/sbdf.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "stiffront/control/cvode.hpp"
#include "stiffront/control/evolve.hpp"
#include "stiffront/control/sbdf_tables.hpp"
#include "stiffront/core/error.hpp"
#include "stiffront/model/builtin/brusselator.hpp"
#include "stiffront/model/builtin/bz.hpp"
#include "stiffront/model/builtin/discharge.hpp"
#include "stiffront/model/builtin/kpp.hpp"
#include "stiffront/model/builtin/pulse.hpp"
#include "stiffront/model/builtin/slaved_oscillator.hpp"
#include "support/diffusion_problem.hpp"
#include "support/order_fit.hpp"
#include "support/stored_state.hpp"

namespace stiffront {
namespace {

using testing::both_sides;
using testing::DiffusionProblem;
using testing::StoredState;
using testing::unit_grid;

/// A stiff nonlinear system with the solution (1/(1+t), cos t) at every point.
struct Known {
  static constexpr int n_species = 2;
  static constexpr const char* name = "known";
  static constexpr const char* source = "test";
  static constexpr std::array<const char*, 2> species{"u", "v"};
  static constexpr std::array<double, 2> diffusion{0.0, 0.0};
  static constexpr std::array<Parameter<Known>, 0> parameters{};
  static constexpr std::array<Profile<Known>, 0> profiles{};

  template <class T, class P>
  void rates(const T* u, T* du, const P& place) const {
    const auto c = cos(place.t);
    du[0] = -(u[0] * u[0]);
    du[1] = (T(c) - u[1]) * 50.0 - T(sin(place.t)) + u[0] * (u[1] - T(c));
  }
};

/// Pure diffusion of one species.
struct Inert {
  static constexpr int n_species = 1;
  static constexpr const char* name = "inert";
  static constexpr const char* source = "test";
  static constexpr std::array<const char*, 1> species{"u"};
  static constexpr std::array<double, 1> diffusion{1.0};
  static constexpr std::array<Parameter<Inert>, 0> parameters{};
  static constexpr std::array<Profile<Inert>, 0> profiles{};

  template <class T, class P>
  void rates(const T* u, T* du, const P&) const {
    du[0] = u[0] * 0.0;
  }
};

/// The same of more species than corrections on coarser grids are made for.
struct ManyInert {
  static constexpr int n_species = plane_correction_species + 1;
  static constexpr const char* name = "many-inert";
  static constexpr const char* source = "test";
  static constexpr std::array<const char*, n_species> species{"a", "b", "c", "d", "e", "f", "g", "h", "i"};
  static constexpr std::array<double, n_species> diffusion{1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0};
  static constexpr std::array<Parameter<ManyInert>, 0> parameters{};
  static constexpr std::array<Profile<ManyInert>, 0> profiles{};

  template <class T, class P>
  void rates(const T* u, T* du, const P&) const {
    for (int s = 0; s < n_species; ++s) du[s] = u[s] * 0.0;
  }
};

/// u = sin t + x^2 with D = 1: exact in space for any centred difference.
struct Driven {
  static constexpr int n_species = 1;
  static constexpr const char* name = "driven";
  static constexpr const char* source = "test";
  static constexpr std::array<const char*, 1> species{"u"};
  static constexpr std::array<double, 1> diffusion{1.0};
  static constexpr std::array<Parameter<Driven>, 0> parameters{};
  static constexpr std::array<Profile<Driven>, 0> profiles{};

  template <class T, class P>
  void rates(const T*, T* du, const P& place) const {
    du[0] = T(cos(place.t) - 2.0);
  }
};

/// Explodes at t = 1.
struct Explosion {
  static constexpr int n_species = 1;
  static constexpr const char* name = "explosion";
  static constexpr const char* source = "test";
  static constexpr std::array<const char*, 1> species{"u"};
  static constexpr std::array<double, 1> diffusion{0.0};
  static constexpr std::array<Parameter<Explosion>, 0> parameters{};
  static constexpr std::array<Profile<Explosion>, 0> profiles{};

  template <class T, class P>
  void rates(const T* u, T* du, const P&) const {
    du[0] = u[0] * u[0];
  }
};

/// A problem with everything a run needs, on one rank.
template <class M>
struct Case {
  Case(const Grid& grid, std::vector<double> diffusion, int order = 2, std::array<std::array<BoundarySide, 2>, 2> sides = {},
       const std::map<std::string, double>& parameters = {})
      : comm(MPI_COMM_SELF),
        problem(comm, grid, std::move(sides), std::move(diffusion), order),
        model(parameters),
        rhs(problem.decomposition, problem.diffusion, model),
        u(problem.field()) {}

  Progress run(const SbdfOptions& options, Schedule schedule) {
    Sbdf method(u, rhs, model, options);
    Progress progress;
    progress.t = schedule.start;
    Observer nobody;
    evolve(method, schedule, u, progress, nobody);
    return progress;
  }
  Progress run(double tolerance, double end) {
    SbdfOptions options;
    options.relative_tolerance = tolerance;
    Schedule schedule;
    schedule.end = end;
    return run(options, schedule);
  }

  Communicator comm;
  DiffusionProblem problem;
  ModelKernelsOf<M> model;
  CoupledRhs rhs;
  Field u;
};

/// Makes n equal steps of one order from an exact history; exact(s, i, t). Returns the largest error at the end.
template <class M, class F>
double fixed_step_error(Case<M>& c, int order, double start, double dt, int n, F exact, int max_sweeps = sbdf_max_sweeps) {
  SbdfOptions options;
  options.max_sweeps = max_sweeps;
  options.absolute_tolerance = {1e9};  // accepts whatever comes
  Sbdf method(c.u, c.rhs, c.model, options);
  const auto set = [&](Field& f, double t) {
    for (int s = 0; s < f.n_species(); ++s) {
      for (int j = 0; j < f.n_y(); ++j) {
        for (int i = 0; i < f.n_x(); ++i) f.at(s, i, j) = exact(s, i, t);
      }
    }
  };
  StoredState state;
  for (int back = 5; back >= 1; --back) {
    Field f = c.u.similar();
    set(f, start - back * dt);
    std::vector<double> flat;
    for (int s = 0; s < f.n_species(); ++s) {
      for (int j = 0; j < f.n_y(); ++j) flat.insert(flat.end(), f.row(s, j), f.row(s, j) + f.n_x());
    }
    state.stored["history-" + std::to_string(back)] = flat;
  }
  set(c.u, start);
  state.stored["states"] = {6.0};
  state.stored["steps"] = std::vector<double>(bdf_max_points, dt);
  state.stored["extremes"] = std::vector<double>(2 * M::n_species, 1.0);
  state.stored["absolute"] = std::vector<double>(M::n_species, 1.0);
  Field u_new = c.u.similar();
  for (int k = 0; k < n; ++k) {
    // The order is set anew before every step: what the control makes of the errors does not matter.
    if (k > 0) state.save(method);
    std::vector<double> control = BdfControl(5).state();
    control[0] = order;
    state.stored["control"] = control;
    state.load(method);
    std::uint64_t flags = 0;
    const Attempt a = method.attempt(start + k * dt, dt, c.u, u_new, flags);
    EXPECT_TRUE(a.accepted);
    EXPECT_EQ(a.iterations, order);
    method.accept(c.u, u_new);
  }
  double error = 0.0;
  for (int s = 0; s < M::n_species; ++s) {
    for (int j = 0; j < c.u.n_y(); ++j) {
      for (int i = 0; i < c.u.n_x(); ++i) error = std::max(error, std::abs(c.u.at(s, i, j) - exact(s, i, start + n * dt)));
    }
  }
  return error;
}

TEST(Sbdf, HasTheOrderItSaysForAStiffNonlinearReaction) {
  for (int order = 1; order <= 5; ++order) {
    std::vector<double> h;
    std::vector<double> e;
    for (int n : {16, 32, 64, 128}) {
      Case<Known> c(unit_grid(9, 1), {0.0, 0.0});
      h.push_back(1.0 / n);
      e.push_back(fixed_step_error(c, order, 1.0, 1.0 / n, n, [](int s, int, double t) { return s == 0 ? 1.0 / (1.0 + t) : std::cos(t); }));
    }
    EXPECT_NEAR(testing::observed_order(h, e), order, order < 3 ? 0.15 : 0.3) << "order " << order << ", error " << e.back();
  }
}

TEST(Sbdf, HasTheOrderItSaysForDiffusionWithSeveralSweepsAndWithCoupledCells) {
  const int points = 41;
  const double dx = 1.0 / (points - 1);
  const double mode = std::numbers::pi * dx;
  for (int space : {2, 4}) {
    // The discrete operator's eigenvalue at cos(pi x).
    const double symbol = space == 2 ? 2.0 - 2.0 * std::cos(mode) : 2.5 - 8.0 / 3.0 * std::cos(mode) + std::cos(2.0 * mode) / 6.0;
    const double lambda = symbol / (dx * dx);
    for (const auto& [max_sweeps, rows] : {std::pair(sbdf_max_sweeps, 1), std::pair(1, 1), std::pair(1, 31)}) {
      for (int order = 1; order <= 5; ++order) {
        std::vector<double> h;
        std::vector<double> e;
        for (int n : {10, 20, 40}) {
          Case<Inert> c(unit_grid(points, rows), {1.0}, space);
          const double dt = 0.1 / n;
          ASSERT_GT(dt * c.problem.diffusion.spectral_radius(), sbdf_z_limit(order, 2)) << "more than two sweeps are needed";
          h.push_back(dt);
          e.push_back(fixed_step_error(
              c, order, 0.0, dt, n, [&](int, int i, double t) { return std::cos(mode * i) * std::exp(-lambda * t); }, max_sweeps));
        }
        EXPECT_NEAR(testing::observed_order(h, e), order, order < 3 ? 0.15 : 0.35)
            << "space " << space << " order " << order << " sweeps " << max_sweeps << " rows " << rows;
      }
    }
  }
}

TEST(Sbdf, FollowsTimeDependentDirichletValuesToTheTolerance) {
  for (int dimension : {1, 2}) {
    for (int space : {2, 4}) {
      const BoundaryValue exact = [](double t, double x, double) { return std::sin(t) + x * x; };
      std::array<std::array<BoundarySide, 2>, 2> sides{both_sides(BoundaryKind::dirichlet, 1, exact, true),
                                                       both_sides(BoundaryKind::neumann, 1)};
      for (double tolerance : {1e-3, 1e-5, 1e-7}) {
        Case<Driven> c(unit_grid(21, dimension == 2 ? 9 : 1), {1.0}, space, sides);
        c.u = c.problem.field([](int, double x, double) { return x * x; });
        const Progress p = c.run(tolerance, 2.0);
        double error = 0.0;
        for (int j = 0; j < c.u.n_y(); ++j) {
          for (int i = 0; i < c.u.n_x(); ++i) {
            const double x = c.problem.grid.position(0, i);
            error = std::max(error, std::abs(c.u.at(0, i, j) - (std::sin(2.0) + x * x)));
          }
        }
        EXPECT_LT(error, 10.0 * tolerance);
        EXPECT_LT(p.rejected, 3);
        EXPECT_LT(p.accepted, 400) << "diffusion sets the step: " << dimension << ' ' << space << ' ' << tolerance;
      }
    }
  }
}

/// RMS difference over the largest value, worst species.
double relative_difference(const Field& a, const Field& b) {
  double worst = 0.0;
  for (int s = 0; s < a.n_species(); ++s) {
    double sum = 0.0;
    double top = 0.0;
    for (int j = 0; j < a.n_y(); ++j) {
      for (int i = 0; i < a.n_x(); ++i) {
        sum += (a.at(s, i, j) - b.at(s, i, j)) * (a.at(s, i, j) - b.at(s, i, j));
        top = std::max(top, std::abs(b.at(s, i, j)));
      }
    }
    worst = std::max(worst, std::sqrt(sum / (a.n_x() * a.n_y())) / top);
  }
  return worst;
}

TEST(Sbdf, StiffDiffusionInThePlaneIsCoupledOnCoarserGridsAndAgreesWithCvode) {
  struct Counter final : Observer {
    Work work;
    void attempted(const StepRecord& r) override { work += r.attempt.work; }
  };
  const auto begin = [](Case<Brusselator>& c) {
    for (int j = 0; j < c.u.n_y(); ++j) {
      for (int i = 0; i < c.u.n_x(); ++i) {
        const double wave = std::cos(std::numbers::pi * i / 29.0) * std::cos(2.0 * std::numbers::pi * j / 24.0);
        c.u.at(0, i, j) = 1.0 + 0.5 * wave;
        c.u.at(1, i, j) = 3.0 - wave;
      }
    }
  };
  const auto run = [](Case<Brusselator>& c, Method& method) {
    Schedule schedule;
    schedule.end = 1.0;
    Progress progress;
    Counter counter;
    evolve(method, schedule, c.u, progress, counter);
    return std::pair(progress, counter.work);
  };
  Case<Brusselator> exact(unit_grid(30, 25), {20.0, 0.1}, 4);
  begin(exact);
  CvodeOptions tight;
  tight.relative_tolerance = 1e-8;
  tight.absolute_tolerance = {1e-10, 1e-10};
  tight.linear_solver = CvodeOptions::LinearSolver::gmres;
  Cvode cvode(exact.u, exact.rhs, tight);
  run(exact, cvode);
  for (double tolerance : {1e-3, 1e-5}) {
    Case<Brusselator> c(unit_grid(30, 25), {20.0, 0.1}, 4);
    begin(c);
    SbdfOptions options;
    options.relative_tolerance = tolerance;
    options.absolute_tolerance = {0.01 * tolerance};
    Sbdf method(c.u, c.rhs, c.model, options);
    const auto [progress, work] = run(c, method);
    EXPECT_LT(relative_difference(c.u, exact.u), 10.0 * tolerance) << tolerance;
    EXPECT_GT(work.linear_iterations, progress.accepted / 2) << "many steps couple the cells";
    EXPECT_LT(static_cast<double>(progress.rejected), 0.05 * static_cast<double>(progress.accepted)) << tolerance;
    EXPECT_LT(work.sweeps, 24 * progress.accepted) << "no step takes more sweeps than corrections cost";
    EXPECT_EQ(method.closing_note(), "");
  }
}

TEST(Sbdf, ErrorsOfABzWaveFollowTheToleranceWithoutRejections) {
  Case<Bz> reference(unit_grid(1001, 1), {2.5e-3, 2.5e-3, 1.5e-3});
  reference.model.initialise("bz-ignition", reference.u);
  reference.run(1e-10, 0.3);
  for (double tolerance : {1e-3, 1e-4, 1e-5, 1e-6, 1e-7}) {
    Case<Bz> c(unit_grid(1001, 1), {2.5e-3, 2.5e-3, 1.5e-3});
    c.model.initialise("bz-ignition", c.u);
    const Progress p = c.run(tolerance, 0.3);
    const double error = relative_difference(c.u, reference.u);
    EXPECT_LT(error, 10.0 * tolerance) << tolerance;
    EXPECT_GT(error, 1e-3 * tolerance) << "work is wasted at " << tolerance;
    EXPECT_LT(static_cast<double>(p.rejected), 0.05 * static_cast<double>(p.accepted)) << tolerance;
  }
}

TEST(Sbdf, FollowsAGrowingMode) {
  // Ahead of its front u of the KPP wave grows exponentially: the front's speed shows whether its rate is right.
  Case<Kpp> c(Grid{1, {401, 1}, {-20.0, 0.0}, {20.0, 1.0}}, {1.0}, 4);
  c.model.initialise("kpp-front", c.u);
  const auto area = [&] {
    double sum = 0.0;
    for (int i = 0; i < c.u.n_x(); ++i) sum += c.u.at(0, i) * c.problem.grid.spacing(0);
    return sum;
  };
  const double before = area();
  c.run(1e-6, 8.0);
  EXPECT_NEAR((area() - before) / 8.0, std::sqrt(0.5), 1e-4);
}

TEST(Sbdf, RestartsAtABreakPointInsteadOfRunningIntoTheJump) {
  const auto run = [](std::vector<double> breakpoints) {
    Case<Pulse> c(unit_grid(201, 1), {0.01, 1e-3});
    c.model.initialise("pulse-uniform", c.u);
    SbdfOptions options;
    options.relative_tolerance = 1e-5;
    Schedule schedule;
    schedule.breakpoints = std::move(breakpoints);
    return c.run(options, schedule);
  };
  EXPECT_LE(run({0.3, 0.6}).rejected, 4);
  EXPECT_GT(run({}).rejected, 8);
}

TEST(Sbdf, GivesUpHighOrdersOnADampedOscillatorNearTheImaginaryAxis) {
  for (double tolerance : {1e-3, 1e-4}) {
    Case<SlavedOscillator> c(Grid{1, {101, 1}, {0.0, 0.0}, {20.0, 1.0}}, {0.1, 0.0, 0.0}, 2, {}, {{"damping", 5.0}, {"omega", 500.0}});
    c.model.initialise("slaved-oscillator-front", c.u);
    SbdfOptions options;
    options.relative_tolerance = tolerance;
    options.absolute_tolerance = {0.01 * tolerance};
    Sbdf method(c.u, c.rhs, c.model, options);
    Schedule schedule;
    schedule.end = 3.0;
    Progress progress;
    Observer nobody;
    evolve(method, schedule, c.u, progress, nobody);
    // The high orders alone need 2300 steps, CVODE 3100.
    EXPECT_LT(3 * progress.accepted, 2300);
    EXPECT_LT(progress.rejected, 0.05 * static_cast<double>(progress.accepted));
    EXPECT_NE(method.closing_note().find("oscillation"), std::string::npos) << method.closing_note();
    // The oscillator is slaved: v = u^2 to within the front's time scale over the damping.
    for (int i = 0; i < c.u.n_x(); ++i) {
      EXPECT_NEAR(c.u.at(1, i), c.u.at(0, i) * c.u.at(0, i), 0.02);
      EXPECT_NEAR(c.u.at(2, i), 0.0, 0.02);
    }
  }
}

TEST(Sbdf, GoesOnBitwiseFromAStoredState) {
  const auto make = [] { return std::make_unique<Case<Bz>>(unit_grid(101, 1), std::vector<double>{2.5e-3, 2.5e-3, 1.5e-3}); };
  const auto steps = [](Method& m, Field& u, Progress& p, int n) {
    struct StopAfter final : Observer {
      explicit StopAfter(std::int64_t n) : last(n) {}
      bool carry_on(std::uint64_t, std::int64_t step, double, double, Field&) override { return step < last; }
      std::int64_t last;
    } stop(n);
    Schedule schedule;
    evolve(m, schedule, u, p, stop);
  };
  auto whole = make();
  whole->model.initialise("bz-front", whole->u);
  Sbdf uninterrupted(whole->u, whole->rhs, whole->model, {});
  Progress p;
  StoredState state;
  auto other = make();
  for (int interrupted_at : {1, 2, 5, 37}) {
    steps(uninterrupted, whole->u, p, interrupted_at);
    state.save(uninterrupted);
    other->u.copy_interior(whole->u);
    Progress q = p;
    Sbdf resumed(other->u, other->rhs, other->model, {});
    state.load(resumed);
    steps(resumed, other->u, q, interrupted_at + 30);
    steps(uninterrupted, whole->u, p, interrupted_at + 30);
    EXPECT_EQ(q.t, p.t);
    EXPECT_EQ(q.dt, p.dt);
    for (int s = 0; s < 3; ++s) {
      for (int i = 0; i < whole->u.n_x(); ++i) EXPECT_EQ(other->u.at(s, i), whole->u.at(s, i));
    }
  }
}

TEST(Sbdf, ExplodingSolutionsEndInAnErrorNotInNumbers) {
  Case<Explosion> c(unit_grid(9, 1), {0.0});
  c.u = c.problem.field([](int, double, double) { return 1.0; });
  EXPECT_THROW(c.run(1e-6, 2.0), Error);
}

TEST(Sbdf, AStepTooLongForAllSweepsIsRejectedWithAReason) {
  Case<Inert> c(unit_grid(401, 1), {1.0});
  c.u = c.problem.field([](int, double x, double) { return x; });
  Sbdf method(c.u, c.rhs, c.model, {});
  Field u_new = c.u.similar();
  std::uint64_t flags = 0;
  const Attempt a = method.attempt(0.0, 1e9, c.u, u_new, flags);
  EXPECT_FALSE(a.accepted);
  EXPECT_LT(a.dt_next, 1e9);
  EXPECT_FALSE(a.reason.empty());
}

TEST(Sbdf, SaysAtTheEndHowManyStepsDiffusionKeptShort) {
  const auto note = []<class M>(const M&, int dimension, int max_sweeps, double diffusion = 1.0, double end = 0.1) {
    Case<M> c(unit_grid(101, dimension == 2 ? 5 : 1), std::vector<double>(M::n_species, diffusion));
    c.u = c.problem.field([](int, double x, double) { return std::cos(std::numbers::pi * x); });
    SbdfOptions options;
    options.max_sweeps = max_sweeps;
    Sbdf method(c.u, c.rhs, c.model, options);
    Schedule schedule;
    schedule.end = end;
    Progress progress;
    Observer nobody;
    evolve(method, schedule, c.u, progress, nobody);
    return method.closing_note();
  };
  EXPECT_NE(note(ManyInert{}, 2, 2).find("diffusion limited"), std::string::npos);
  EXPECT_NE(note(ManyInert{}, 2, 2).find("max_sweeps = 2"), std::string::npos);
  EXPECT_EQ(note(Inert{}, 2, sbdf_max_sweeps), "");
  EXPECT_EQ(note(Inert{}, 1, 2), "") << "in one dimension all cells are coupled instead";
  EXPECT_EQ(note(Inert{}, 2, sbdf_max_sweeps, 1e4, 0.01), "") << "corrections on coarser grids bear any stiffness";
  EXPECT_NE(note(ManyInert{}, 2, sbdf_max_sweeps, 1e4, 0.01).find("diffusion limited"), std::string::npos)
      << "there are none for so many species";
}

TEST(Sbdf, ASpeciesThatBeginsAtZeroDoesNotStopTheRun) {
  Case<SlavedOscillator> c(Grid{1, {51, 1}, {0.0, 0.0}, {20.0, 1.0}}, {0.1, 0.0, 0.0});
  c.u = c.problem.field([](int s, double x, double) { return s == 0 ? (x < 5.0 ? 1.0 : 0.0) : 0.0; });
  EXPECT_LT(c.run(1e-4, 0.5).accepted, 3000);
}

/// Rates with a square root, defined on one side of zero only.
struct Draining {
  static constexpr int n_species = 1;
  static constexpr const char* name = "draining";
  static constexpr const char* source = "test";
  static constexpr std::array<const char*, 1> species{"u"};
  static constexpr std::array<double, 1> diffusion{0.0};
  static constexpr std::array<Parameter<Draining>, 0> parameters{};
  static constexpr std::array<Profile<Draining>, 0> profiles{};

  template <class T, class P>
  void rates(const T* u, T* du, const P&) const {
    du[0] = sqrt(u[0] - 1.0) - 1e-3;
  }
};

TEST(Sbdf, BeginsAtTheEdgeOfWhereRatesAreDefined) {
  Case<Draining> c(unit_grid(5, 1), {0.0});
  c.u = c.problem.field([](int, double, double) { return 1.0; });
  Sbdf method(c.u, c.rhs, c.model, SbdfOptions{});
  const double h = method.first_step(0.0, 1.0, c.u);
  EXPECT_GT(h, 0.0);
  EXPECT_LT(h, 1.0);
}

TEST(Sbdf, BeginsWhereTheFieldIsSwitchedOnAndSomeIonsAreNotThereYet) {
  Case<Discharge> c(Grid{1, {101, 1}, {0.0, 0.0}, {0.05, 1.0}}, {50.0, 50.0, 50.0});
  c.model.initialise("discharge-seed", c.u);
  SbdfOptions options;
  options.relative_tolerance = 1e-3;
  options.absolute_tolerance = {1e-5};
  Schedule schedule;
  schedule.end = 1.2e-6;
  schedule.breakpoints = {1e-8, 1.01e-6};
  schedule.restart_period = 1e-6;
  schedule.restart_step = 1e-10;
  const Progress p = c.run(options, schedule);
  EXPECT_LT(p.accepted, 1000);
  EXPECT_LT(20 * p.rejected, p.accepted);
  EXPECT_GT(c.u.at(2, 0), 1e10) << "negative ions";
}

TEST(Sbdf, AskedForAlmostNoAccuracyStaysWhereTheMediumIsStable) {
  Case<Bz> c(unit_grid(97, 97), {2.5e-3, 2.5e-3, 1.5e-3});
  c.model.initialise("bz-spiral", c.u);
  SbdfOptions options;
  options.relative_tolerance = 0.1;
  options.absolute_tolerance = {1e-3};
  Schedule schedule;
  schedule.end = 0.4;
  EXPECT_LT(c.run(options, schedule).accepted, 1000);
}

TEST(Sbdf, OptionsOutOfRangeAreRefused) {
  Case<Bz> c(unit_grid(9, 1), {1.0, 1.0, 1.0});
  const auto refuses = [&](auto change) {
    SbdfOptions o;
    change(o);
    EXPECT_THROW(Sbdf(c.u, c.rhs, c.model, o), Error);
  };
  refuses([](SbdfOptions& o) { o.relative_tolerance = 0.0; });
  refuses([](SbdfOptions& o) { o.absolute_tolerance = {1e-6, 1e-6}; });
  refuses([](SbdfOptions& o) { o.absolute_tolerance = {0.0}; });
  refuses([](SbdfOptions& o) { o.max_order = 6; });
  refuses([](SbdfOptions& o) { o.max_sweeps = 0; });
  refuses([](SbdfOptions& o) { o.initial_step = -1.0; });
}

}  // namespace
}  // namespace stiffront
