// SPDX-License-Identifier: BSD-3-Clause
//
// The problems of Hagstrom & Zhou, Commun. Appl. Math. Comput. Sci. 1(1), 2006, from the built-in cases: what the paper or an independent
// implementation of ours found, as far as it takes seconds. The tables and figures: drivers/reproduce/sdc.py.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <string>
#include <vector>

#include "stiffront/app/case_file.hpp"
#include "stiffront/app/case_source.hpp"
#include "stiffront/app/method_stack.hpp"
#include "stiffront/app/problem.hpp"
#include "stiffront/control/evolve.hpp"
#include "stiffront/core/error.hpp"
#include "stiffront/solvers/model_registry.hpp"

namespace stiffront::app {
namespace {

using State = std::vector<std::vector<double>>;  // by species

State copy(const Field& u) {
  State s;
  for (int k = 0; k < u.n_species(); ++k) s.emplace_back(u.row(k, 0), u.row(k, 0) + u.n_x());
  return s;
}

/// Keeps the states at given times, on which steps land.
class Keeper final : public Observer {
 public:
  explicit Keeper(const std::vector<double>& times) : times_(times) {}
  bool carry_on(std::uint64_t, std::int64_t, double t, double, Field& u) override {
    if (states.size() < times_.size() && t >= times_[states.size()]) states.push_back(copy(u));
    return true;
  }
  std::vector<State> states;

 private:
  std::vector<double> times_;
};

struct Solution {
  std::vector<State> at_outputs;
  State last;
};

/// From the case's initial state, or from the given one.
/// @throws Error(numerics) if the method fails
Solution solve(const std::string& name, const std::vector<std::string>& overrides, const std::vector<double>& times = {},
               const State* from = nullptr) {
  ModelRegistry models;
  register_builtin_models(models);
  const Communicator self(MPI_COMM_SELF);
  const Case c = parse_case(read_case_source(name, overrides), models.descriptions());
  Problem problem(c, models, self);
  for (std::size_t s = 0; from != nullptr && s < from->size(); ++s)
    std::copy((*from)[s].begin(), (*from)[s].end(), problem.state.row(static_cast<int>(s), 0));
  MethodStack stack(c, problem);
  Schedule schedule;
  schedule.start = c.time.start;
  schedule.end = c.time.end;
  schedule.landing_times = times;
  Progress progress;
  Keeper keeper(times);
  evolve(stack.method(), schedule, problem.state, progress, keeper);
  return {keeper.states, copy(problem.state)};
}

bool survives(const std::string& name, const std::vector<std::string>& overrides) {
  try {
    solve(name, overrides);
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::numerics) << e.what();
    return false;
  }
  return true;
}

/// Largest difference of a species over its largest modulus.
double distance(const State& a, const State& b, std::size_t species) {
  double difference = 0.0, largest = 0.0;
  for (std::size_t i = 0; i < b[species].size(); ++i) {
    difference = std::max(difference, std::abs(a[species][i] - b[species][i]));
    largest = std::max(largest, std::abs(b[species][i]));
  }
  return difference / largest;
}

std::string points(int intervals) { return fmt::format("grid.points=[{}]", intervals + 1); }

std::string seventh(double step, double gamma = 2.0) {
  return fmt::format("method={{name=\"sdc\", node_count=4, starting_order=4, corrections=3, gamma_diffusion={}, step={}}}", gamma, step);
}

TEST(SdcPaperTest, TheCaseOfDahlquistsEquationHasOrderTwelveAndTheKnownError) {
  const auto error = [](int steps) {
    const State u = solve("dahlquist", {fmt::format("method.step={}", 20.0 / steps)}).last;
    return std::abs(std::complex<double>(u[0][1], u[1][1]) - std::exp(-1.0));
  };
  EXPECT_NEAR(error(80), 2.42e-8, 0.1e-8);
  EXPECT_NEAR(std::log(error(120) / error(160)) / std::log(160.0 / 120.0), 12.0, 0.9);
}

TEST(SdcPaperTest, TheCaseOfVanDerPolsOscillatorHasTheKnownError) {
  const auto error = [](double step) {
    const State u = solve("van-der-pol", {fmt::format("method.step={}", step)}).last;
    return std::max(std::abs(u[0][1] + 1.91423981220481877556), std::abs(u[1][1] - 0.448031279557519709566));
  };
  EXPECT_NEAR(error(0.5), 1.9e-8, 0.2e-8);
  EXPECT_NEAR(error(0.25), 1.6e-11, 0.3e-11);
}

TEST(SdcPaperTest, TheBrusselatorsLargestStepsAreThoseOfThePaper) {
  const auto largest = [](int intervals, double gamma, int from, int to) {
    int stable = to + 1;
    for (int q = to; q >= from && survives("brusselator-sdc-1d", {points(intervals), seventh(1.0 / q, gamma)}); --q) stable = q;
    return stable;
  };
  EXPECT_EQ(largest(50, 2.0, 1, 4), 2);
  EXPECT_EQ(largest(100, 2.0, 2, 5), 3);
  EXPECT_EQ(largest(150, 2.0, 6, 10), 8);
  EXPECT_EQ(largest(150, 1.0, 100, 102), 101);
}

TEST(SdcPaperTest, TheBrusselatorsErrorsAndThoseOfStrangAreTheKnownOnes) {
  // An independent implementation's; the errors are those of the grid's differences.
  const std::vector<double> times{1.0, 7.0};
  const auto run = [&](int intervals, const std::vector<std::string>& method) {
    std::vector<std::string> overrides = method;
    overrides.push_back(points(intervals));
    overrides.push_back("time.end=7");
    return solve("brusselator-sdc-1d", overrides, times).at_outputs;
  };
  // Only the points of the regular grid: sub-cells are second and last but one.
  const auto regular = [](const State& s, std::size_t stride) {
    State r;
    for (const std::vector<double>& row : s) {
      r.emplace_back();
      const std::size_t n = row.size() - 3;
      for (std::size_t k = 0; k <= n; k += stride) r.back().push_back(k == 0 ? row[0] : (k == n ? row.back() : row[k + 1]));
    }
    return r;
  };
  const auto reference = run(200, {seventh(0.02)});
  const auto worst = [&](const std::vector<State>& states, std::size_t stride, std::size_t species) {
    double e = 0.0;
    for (std::size_t k = 0; k < times.size(); ++k) e = std::max(e, distance(regular(states[k], 1), regular(reference[k], stride), species));
    return e;
  };
  const auto strang = [](double step) {
    return std::vector<std::string>{fmt::format("method={{name=\"strang\", step={}}}", step), "diffusion_solver.name=crank-nicolson",
                                    "diffusion_solver.tolerance=1e-10", "reaction_solver.name=trapezoidal",
                                    "reaction_solver.tolerance=1e-10"};
  };
  const auto coarse = run(50, {seventh(0.2)});
  EXPECT_NEAR(worst(coarse, 4, 0), 4.8e-4, 0.1e-4);
  EXPECT_NEAR(worst(coarse, 4, 1), 3.1e-4, 0.1e-4);
  const auto fine = run(100, {seventh(0.1)});
  EXPECT_NEAR(worst(fine, 2, 0), 2.7e-6, 0.15e-6);
  EXPECT_NEAR(worst(fine, 2, 1), 1.8e-6, 0.1e-6);
  const auto strang_coarse = run(50, strang(0.0125));
  EXPECT_NEAR(worst(strang_coarse, 4, 0), 1.73e-3, 0.05 * 1.73e-3);
  EXPECT_NEAR(worst(strang_coarse, 4, 1), 9.88e-4, 0.05 * 9.88e-4);
  const auto strang_fine = run(100, strang(0.00625));
  EXPECT_NEAR(worst(strang_fine, 2, 0), 3.59e-4, 0.02 * 3.59e-4);
  EXPECT_NEAR(worst(strang_fine, 2, 1), 2.20e-4, 0.02 * 2.20e-4);
}

TEST(SdcPaperTest, TheBrusselatorsOrderInTimeIsSevenForSmoothData) {
  const std::vector<double> times{1, 2, 3, 4, 5, 6, 7, 8, 9, 10};
  const auto run = [&](const std::string& method) {
    return solve("brusselator-sdc-1d", {points(50), "initial={profile=\"brusselator-sine\"}", method}, times).at_outputs;
  };
  const auto exact = run("method={name=\"sdc\", node_count=7, starting_order=4, corrections=9, gamma_diffusion=2, step=0.025}");
  const auto error_from = [&](std::size_t first, const std::vector<State>& u, std::size_t species) {
    double e = 0.0;
    for (std::size_t k = first; k < times.size(); ++k) e = std::max(e, distance(u[k], exact[k], species));
    return e;
  };
  const auto expect_order = [&](const std::string& corrections, const std::vector<double>& steps, std::size_t first) {
    std::vector<std::vector<State>> solutions;
    for (double step : steps) {
      solutions.push_back(run(fmt::format(
          "method={{name=\"sdc\", node_count=4, starting_order=4, corrections={}, gamma_diffusion=2, step={}}}", corrections, step)));
    }
    for (std::size_t k = 0; k + 1 < steps.size(); ++k) {
      for (std::size_t s : {0UL, 1UL}) {
        EXPECT_GE(std::log2(error_from(first, solutions[k], s) / error_from(first, solutions[k + 1], s)), 6.8)
            << corrections << " " << steps[k] << " " << s;
      }
    }
  };
  expect_order("3", {0.2, 0.1, 0.05}, times.size() - 1);
  // At all times the layers that the data leave at the sides must have been corrected, which takes more sweeps.
  expect_order("8", {0.1, 0.05}, 0);
  expect_order("6, acceleration=true", {0.1, 0.05}, 0);
}

TEST(SdcPaperTest, TheFlameHasOrderFourWhileItIgnitesAndMoreWithAcceleratedCorrections) {
  const auto run = [](double step, double end, const std::string& more, const State* from) {
    const std::string keys = "name=\"sdc\", node_count=4, starting_order=2, gamma_diffusion=2, gamma_advection=2";
    return solve("pulsating-flame-1d",
                 {"grid.points=[801]", "grid.upper=[15]", fmt::format("time.end={}", end),
                  fmt::format("method={{{}, step={}{}}}", keys, step, more)},
                 {}, from)
        .last;
  };
  // The profile's flame is too far out: from 0.1 to 0.3 it overshoots the temperature of the burnt gas by 15 per cent.
  const State before = run(2e-3, 0.1, ", corrections=5", nullptr);
  const auto solution = [&](double step, const std::string& more) { return run(step, 0.16, more, &before); };
  const State exact = solution(4e-4, ", corrections=10");
  const auto expect_orders = [&](const std::string& more, double least) {
    const State coarse = solution(1.6e-3, more), fine = solution(8e-4, more);
    for (std::size_t species : {0UL, 2UL}) {  // Y and Theta
      EXPECT_GE(std::log2(distance(coarse, exact, species) / distance(fine, exact, species)), least) << species << more;
    }
  };
  expect_orders(", corrections=5", 3.7);
  expect_orders(", corrections=8, acceleration=true", 4.0);
}

class TransportCase : public ::testing::TestWithParam<std::pair<const char*, std::vector<std::string>>> {};

TEST_P(TransportCase, IsSolvedAlikeByEveryMethodThatTakesIt) {
  const auto run = [](const std::string& method, std::vector<std::string> more = {}) {
    const auto& [name, settings] = GetParam();
    more.insert(more.end(), settings.begin(), settings.end());
    more.push_back("method=" + method);
    return solve(name, more).last;
  };
  const std::string cvode = "{{name=\"cvode\", relative_tolerance=1e-9, absolute_tolerance=1e-12, linear_solver=\"{}\"}}";
  const State reference = run(fmt::format(fmt::runtime(cvode), "band"));
  const auto error = [&](const State& u) {
    double e = 0.0;
    for (std::size_t s = 0; s < u.size(); ++s) e = std::max(e, distance(u, reference, s));
    return e;
  };
  EXPECT_LT(error(run(fmt::format(fmt::runtime(cvode), "gmres"))), 1e-6);
  EXPECT_LT(error(run("{name=\"auto\"}")), 1e-3);
  EXPECT_LT(error(run("{name=\"sdc\", tolerance=1e-9, gamma_advection=2}")), 1e-6);
  EXPECT_LT(error(run("{name=\"sdc\", step=5e-4, starting_order=2, gamma_advection=2}")), 1e-4);
  const std::vector<std::string> textbook{"diffusion_solver.name=crank-nicolson", "diffusion_solver.tolerance=1e-10",
                                          "reaction_solver.tolerance=1e-10"};
  const double coarse = error(run("{name=\"strang\", step=2e-4}", textbook));
  const double fine = error(run("{name=\"strang\", step=1e-4}", textbook));
  EXPECT_GT(std::log2(coarse / fine), 1.7) << coarse << " " << fine;
}

INSTANTIATE_TEST_SUITE_P(
    Models, TransportCase,
    ::testing::Values(std::pair{"angiogenesis-chemotaxis-1d", std::vector<std::string>{"grid.points=[81]", "time.end=0.01"}},
                      std::pair{"pulsating-flame-1d", std::vector<std::string>{"grid.points=[401]", "grid.upper=[15]", "time.end=0.01"}},
                      std::pair{"reduced-pulsating-flame-1d",
                                std::vector<std::string>{"grid.points=[401]", "grid.upper=[15]", "time.end=0.01"}}),
    [](const auto& info) {
      std::string name = info.param.first;
      std::replace(name.begin(), name.end(), '-', '_');
      return name;
    });

}  // namespace
}  // namespace stiffront::app
