// SPDX-License-Identifier: BSD-3-Clause
//
// Random models from random states: whatever they are, sbdf must end near the solution or say that it failed.
// STIFFRONT_CAMPAIGN=10000 in the environment makes a campaign of the sample.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "stiffront/control/cvode.hpp"
#include "stiffront/control/evolve.hpp"
#include "stiffront/control/sbdf.hpp"
#include "stiffront/core/error.hpp"
#include "stiffront/solvers/model_kernels.hpp"
#include "support/diffusion_problem.hpp"

namespace stiffront {
namespace {

using testing::both_sides;
using testing::DiffusionProblem;
using testing::unit_grid;

/// Linear, quadratic and source terms at random; the cubic keeps the solution bounded.
struct RandomModel {
  static constexpr int n_species = 3;
  static constexpr const char* name = "random";
  static constexpr const char* source = "test";
  static constexpr std::array<const char*, 3> species{"u", "v", "w"};
  static constexpr std::array<double, 3> diffusion{1.0, 1.0, 1.0};
  static constexpr std::array<Parameter<RandomModel>, 0> parameters{};
  static constexpr std::array<Profile<RandomModel>, 0> profiles{};

  double linear[3][3]{};
  double quadratic[3][3]{};
  double cubic[3]{};
  double constant[3]{};

  template <class T, class P>
  void rates(const T* u, T* du, const P&) const {
    for (int i = 0; i < 3; ++i) {
      du[i] = u[i] * (-cubic[i]) * u[i] * u[i] + constant[i];
      for (int j = 0; j < 3; ++j) du[i] += u[j] * linear[i][j] + u[i] * (u[j] * quadratic[i][j]);
    }
  }
};

struct Problem {
  explicit Problem(unsigned seed) {
    std::mt19937 generator(seed);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    const auto log_uniform = [&](double lo, double hi) {
      return std::exp(std::log(lo) + 0.5 * (1.0 + uniform(generator)) * std::log(hi / lo));
    };
    const bool oscillates = uniform(generator) > 0.3;
    for (int i = 0; i < 3; ++i) {
      const double rate = log_uniform(0.1, 1e5);
      for (int j = 0; j < 3; ++j) {
        model.linear[i][j] = rate * uniform(generator);
        model.quadratic[i][j] = rate * uniform(generator);
      }
      if (uniform(generator) > -0.5) model.linear[i][i] = -rate * std::abs(uniform(generator));
      model.cubic[i] = rate;
      model.constant[i] = rate * uniform(generator);
    }
    if (oscillates) {  // a fast pair near the imaginary axis
      const double omega = log_uniform(10.0, 1e4);
      model.linear[0][1] += omega;
      model.linear[1][0] -= omega;
    }
    for (double& d : diffusion) d = uniform(generator) > -0.6 ? log_uniform(1e-6, 10.0) : 0.0;
    const bool plane = uniform(generator) > 0.4;
    points = static_cast<int>(12.0 + 8.0 * uniform(generator));
    grid = unit_grid(plane ? points : 2 * points, plane ? points + 1 : 1);
    dirichlet = uniform(generator) > 0.5;
    space_order = uniform(generator) > 0.5 ? 4 : 2;
    end = log_uniform(1e-3, 1.0);
    tolerance = std::pow(10.0, std::round(-4.5 + 1.9 * uniform(generator)));
    amplitude = {uniform(generator), uniform(generator), uniform(generator)};
    noise = uniform(generator) > 0.5 ? 0.1 : 0.0;
  }

  RandomModel model;
  std::vector<double> diffusion{0.0, 0.0, 0.0};
  int points = 0;
  Grid grid;
  bool dirichlet = false;
  int space_order = 2;
  double end = 1.0;
  double tolerance = 1e-4;
  std::array<double, 3> amplitude{};
  double noise = 0.0;
};

struct Outcome {
  std::vector<double> state;
  std::string failure;
  Progress progress;
};

template <class Make>
Outcome solve(const Problem& p, const Communicator& comm, Make make) {
  const auto value = [&p](int s, double x, double y) {
    return p.amplitude[static_cast<std::size_t>(s)] * (std::cos(3.0 * x) + (x < 0.5 ? 0.5 : 0.0) + 0.2 * y);
  };
  auto sides = both_sides(BoundaryKind::neumann, 3);
  if (p.dirichlet) {
    sides[0].kind = BoundaryKind::dirichlet;
    for (int s = 0; s < 3; ++s) {
      sides[0].values.push_back([=](double, double x, double y) { return value(s, x, y); });
    }
  }
  const DiffusionProblem d(comm, p.grid, {sides, both_sides(BoundaryKind::neumann, 3)}, p.diffusion, p.space_order);
  const ModelKernelsOf<RandomModel> model(p.model, describe<RandomModel>());
  CoupledRhs rhs(d.decomposition, d.diffusion, model);
  Field u = d.field([&](int s, double x, double y) {
    return value(s, x, y) + p.noise * testing::scatter(std::lround(1e6 * x), std::lround(1e6 * y), s);
  });
  d.boundary.impose(u, 0.0);
  Outcome r;
  Schedule schedule;
  schedule.end = p.end;
  schedule.max_steps = 200000;
  Observer nobody;
  try {
    const auto method = make(u, rhs, model);
    evolve(*method, schedule, u, r.progress, nobody);
  } catch (const Error& e) {
    r.failure = e.what();
  }
  for (int s = 0; s < 3; ++s) {
    for (int j = 0; j < u.n_y(); ++j) r.state.insert(r.state.end(), u.row(s, j), u.row(s, j) + u.n_x());
  }
  return r;
}

Outcome by_cvode(const Problem& p, const Communicator& comm, double tolerance) {
  return solve(p, comm, [&](Field& u, CoupledRhs& rhs, const ModelKernels&) {
    CvodeOptions o;
    o.relative_tolerance = tolerance;
    o.absolute_tolerance = std::vector<double>(3, 0.01 * tolerance);
    o.linear_solver = p.grid.dimension == 1 ? CvodeOptions::LinearSolver::band : CvodeOptions::LinearSolver::gmres;
    return std::make_unique<Cvode>(u, rhs, o);
  });
}

double difference(const Outcome& a, const Outcome& b) {
  const std::size_t n = a.state.size() / 3;
  double worst = 0.0;
  for (std::size_t s = 0; s < 3; ++s) {
    double squares = 0.0;
    double top = 0.0;
    for (std::size_t i = s * n; i < (s + 1) * n; ++i) {
      squares += (a.state[i] - b.state[i]) * (a.state[i] - b.state[i]);
      top = std::max(top, std::abs(b.state[i]));
    }
    worst = std::max(worst, std::sqrt(squares / static_cast<double>(n)) / std::max(top, 0.01));
  }
  return worst;
}

TEST(SbdfCampaign, RandomModelsEndNearTheSolution) {
  const Communicator comm(MPI_COMM_SELF);
  const char* asked = std::getenv("STIFFRONT_CAMPAIGN");
  const unsigned n = asked != nullptr ? static_cast<unsigned>(std::atoi(asked)) : 150U;
  std::int64_t accepted = 0;
  std::int64_t rejected = 0;
  unsigned failed = 0;
  unsigned poor = 0;
  for (unsigned seed = 0; seed < n; ++seed) {
    const Problem p(seed);
    const Outcome r = solve(p, comm, [&](Field& u, CoupledRhs& rhs, const ModelKernels& model) {
      SbdfOptions o;
      o.relative_tolerance = p.tolerance;
      o.absolute_tolerance = {0.01 * p.tolerance};
      return std::make_unique<Sbdf>(u, rhs, model, o);
    });
    accepted += r.progress.accepted;
    rejected += r.progress.rejected;
    if (!r.failure.empty()) {
      // Limit cycles with some 10^5 turns do not end within max_steps.
      EXPECT_NE(r.failure.find("max_steps"), std::string::npos) << "seed " << seed << ": " << r.failure;
      ++failed;
      continue;
    }
    const Outcome exact = by_cvode(p, comm, 1e-9);
    if (!exact.failure.empty()) continue;
    const double error = difference(r, exact);
    if (error <= 100.0 * p.tolerance) continue;
    // Where errors grow on their way to the end (phases of limit cycles) they do so in every method.
    const double other = difference(by_cvode(p, comm, p.tolerance), exact);
    if (error <= 10.0 * other) continue;
    ++poor;
    EXPECT_LT(error, 1000.0 * p.tolerance) << "seed " << seed << ", tolerance " << p.tolerance;
    if (asked != nullptr) {
      fmt::print("seed {}, tolerance {}: error {:.2g}, that of CVODE {:.2g}\n", seed, p.tolerance, error, other);
    }
  }
  EXPECT_LE(failed, 1 + n / 1000);
  EXPECT_LE(poor, 1 + n / 1000);
  EXPECT_LT(static_cast<double>(rejected), 0.05 * static_cast<double>(accepted));
  if (asked != nullptr) {
    fmt::print("{} models: {} steps, {} rejected; {} runs too long\n", n, accepted, rejected, failed);
  }
}

}  // namespace
}  // namespace stiffront
