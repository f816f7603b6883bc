// SPDX-License-Identifier: BSD-3-Clause
// One ROCK4 step of a given number of stages, in nanoseconds per variable and stage on one rank.
#include <benchmark/benchmark.h>

#include <cmath>

#include "stiffront/solvers/rock4.hpp"

namespace {

using namespace stiffront;

/// Arguments: points along x and y, species, order of the differences, stages, stages per pass over memory (0: chosen).
void rock4_step(benchmark::State& state) {
  const Communicator comm(MPI_COMM_WORLD);
  Grid grid;
  grid.dimension = state.range(1) > 1 ? 2 : 1;
  grid.points = {state.range(0), state.range(1)};
  const int n_species = static_cast<int>(state.range(2));
  const int stages = static_cast<int>(state.range(4));
  const Decomposition decomposition(comm, grid, {0, 0}, 4);
  const Boundary boundary = Boundary::natural(grid);
  const DiffusionOperator diffusion(grid, boundary, std::vector<double>(static_cast<std::size_t>(n_species), 1.0),
                                    static_cast<int>(state.range(3)));
  Field u(decomposition, n_species, diffusion.halo_width());
  for (int s = 0; s < n_species; ++s) {
    for (int j = 0; j < u.n_y(); ++j) {
      for (int i = 0; i < u.n_x(); ++i) u.at(s, i, j) = 2.0 + std::sin(0.1 * i + s) * std::cos(0.07 * j);
    }
  }
  // A tolerance that accepts every step, so that each call is one step of the number of stages asked for.
  Rock4 flow(decomposition, diffusion, {1.0, std::vector<double>(static_cast<std::size_t>(n_species), 1e9)},
             static_cast<int>(state.range(5)));
  const double dt = rock4_interval(stages) * (1.0 - 1e-12) / diffusion.spectral_radius();
  const double first[] = {dt};
  Work work;
  for (auto _ : state) {
    flow.set_state(first);
    flow.advance(0.0, dt, u, u, work);
  }
  const double variables = static_cast<double>(u.n_x()) * u.n_y() * n_species;
  state.counters["stages"] = static_cast<double>(work.diffusion_stages) / static_cast<double>(work.diffusion_steps);
  state.counters["ns/variable/stage"] = benchmark::Counter(variables * 1e-9 * static_cast<double>(work.diffusion_stages),
                                                           benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

// In cache, and out of cache.
BENCHMARK(rock4_step)
    ->ArgNames({"x", "y", "species", "order", "stages", "depth"})
    ->ArgsProduct({{256}, {256}, {1}, {2, 4}, {20}, {1, 0}})
    ->ArgsProduct({{1024}, {1024}, {3}, {2, 4}, {20}, {1, 2, 5, 10, 0}})
    ->ArgsProduct({{1024}, {1024}, {3}, {2}, {40}, {0}})
    ->ArgsProduct({{4096}, {4096}, {1}, {2, 4}, {20}, {1, 0}})
    ->ArgsProduct({{1 << 20}, {1}, {3}, {2, 4}, {20}, {1, 0}})
    ->Unit(benchmark::kMillisecond)
    ->Iterations(20)
    ->UseRealTime();

/// What memory gives at best: a = b + s c over arrays of the same size, in nanoseconds per element (24 bytes, as one
/// stage).
void three_streams(benchmark::State& state) {
  const auto n = static_cast<std::size_t>(state.range(0));
  std::vector<double> a(n, 1.0), b(n, 2.0);
  for (auto _ : state) {
    for (std::size_t i = 0; i < n; ++i) a[i] = b[i] + 0.5 * a[i];
    benchmark::ClobberMemory();
  }
  state.counters["ns/element"] = benchmark::Counter(static_cast<double>(n) * 1e-9 * static_cast<double>(state.iterations()),
                                                    benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}
BENCHMARK(three_streams)->Arg(256 * 256)->Arg(3 * 1024 * 1024)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
