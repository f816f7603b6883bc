// SPDX-License-Identifier: BSD-3-Clause
#include <benchmark/benchmark.h>

#include <cmath>
#include <vector>

#include "stiffront/model/builtin/bz.hpp"
#include "stiffront/solvers/radau5_kernel.hpp"

/// Cells per second of the reaction flow on a developed Belousov-Zhabotinsky wave: u' = rates(u) in each of 1001 cells over
/// dt = 1e-3 at relative and absolute tolerance 1e-5, on packs and one cell at a time.
///
/// The wave is that of the profile "bz-front" at t = 0.9 (1001 points on [0, 1]), from Strang splitting with 1800 steps and explicit
/// diffusion, so that every state in it is one a splitting meets. Inner steps begin with the hints of the call before.
namespace stiffront {
namespace {

constexpr int n_points = 1001;
constexpr double dt = 1e-3;

struct Wave {
  std::vector<double> u = std::vector<double>(3 * n_points);
  std::vector<double> hint = std::vector<double>(n_points, 0.0);
  std::vector<float> cost = std::vector<float>(n_points);
};

template <class T>
void react(Radau5Kernel<Bz, T>& kernel, double interval, const std::vector<double>& from, Wave& to) {
  kernel.begin(0.0, interval);
  kernel.row({n_points, from.data(), n_points, to.u.data(), n_points, to.hint.data(), to.cost.data(), 0}, [](int, int) {
    return Place<T>{T(0.0), T(0.0), T(0.0)};
  });
  if (kernel.finish()) std::abort();
}

template <class T>
Radau5Kernel<Bz, T> kernel_of_tolerance(double tolerance) {
  const double absolute[] = {tolerance, tolerance, tolerance};
  return Radau5Kernel<Bz, T>(Bz{}, Radau5Tolerances<3>(tolerance, absolute));
}

void diffuse(double interval, std::vector<double>& u) {
  constexpr int stages = 6;  // D dt/dx^2 = 1.25 / 6 per substep
  std::vector<double> old;
  for (int k = 0; k < stages; ++k) {
    old = u;
    for (int s = 0; s < 3; ++s) {
      const double c = Bz::diffusion[static_cast<std::size_t>(s)] * (n_points - 1.0) * (n_points - 1.0) * interval / stages;
      const double* v = old.data() + s * n_points;
      for (int i = 0; i < n_points; ++i) {
        const double left = v[i == 0 ? 1 : i - 1];
        const double right = v[i == n_points - 1 ? i - 1 : i + 1];
        u[static_cast<std::size_t>(s * n_points + i)] += c * (left - 2.0 * v[i] + right);
      }
    }
  }
}

const Wave& developed_wave() {
  static const Wave wave = [] {
    Wave w;
    Grid grid;
    grid.points = {n_points, 1};
    for (int i = 0; i < n_points; ++i) {
      double cell[3];
      Bz::front(Bz{}, grid, i, 0, cell);
      for (int s = 0; s < 3; ++s) w.u[static_cast<std::size_t>(s * n_points + i)] = cell[s];
    }
    auto kernel = kernel_of_tolerance<Pack>(1e-5);
    constexpr int steps = 1800;
    for (int k = 0; k < steps; ++k) {
      react(kernel, 0.45 / steps, w.u, w);
      diffuse(0.9 / steps, w.u);
      react(kernel, 0.45 / steps, w.u, w);
    }
    return w;
  }();
  return wave;
}

template <class T>
void radau5(benchmark::State& state) {
  const double tolerance = std::pow(10.0, -static_cast<double>(state.range(0)));
  const Wave& wave = developed_wave();
  auto kernel = kernel_of_tolerance<T>(tolerance);
  Wave to;
  react(kernel, dt, wave.u, to);  // leaves the hints
  for (auto _ : state) {
    react(kernel, dt, wave.u, to);
    benchmark::DoNotOptimize(to.u.data());
  }
  state.SetItemsProcessed(state.iterations() * n_points);
  const Radau5Counts c = kernel.counts();
  state.counters["steps/cell"] = static_cast<double>(c.steps) / n_points;
  state.counters["attempts/cell"] = static_cast<double>(c.jacobians) / n_points;
  state.counters["newton/cell"] = static_cast<double>(c.newton_iterations) / n_points;
}
BENCHMARK(radau5<Pack>)->Arg(3)->Arg(5)->Arg(7)->Arg(9);
BENCHMARK(radau5<double>)->Arg(5)->Arg(7);

}  // namespace
}  // namespace stiffront
