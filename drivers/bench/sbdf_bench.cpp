// SPDX-License-Identifier: BSD-3-Clause
// Runs of sbdf on a Belousov-Zhabotinsky wave or spiral, microseconds per step on one rank, with the sweeps of a step in one
// pass over memory or each in its own. The bits are the same.
#include <benchmark/benchmark.h>

#include "stiffront/control/evolve.hpp"
#include "stiffront/control/sbdf.hpp"
#include "stiffront/model/builtin/bz.hpp"
#include "stiffront/solvers/model_kernels.hpp"

namespace {

using namespace stiffront;

class Count final : public Observer {
 public:
  void attempted(const StepRecord& record) override { sweeps += record.attempt.work.sweeps; }
  std::int64_t sweeps = 0;
};

/// Arguments: dimension, points per side, sweeps per pass (0: as many as the cache holds), microseconds of model time.
void sbdf_run(benchmark::State& state) {
  const Communicator comm(MPI_COMM_WORLD);
  Grid grid;
  grid.dimension = static_cast<int>(state.range(0));
  grid.points = {state.range(1), grid.dimension == 2 ? state.range(1) : 1};
  const Decomposition decomposition(comm, grid, {0, 0}, 1);
  const Boundary boundary = Boundary::natural(grid);
  const DiffusionOperator diffusion(grid, boundary, {2.5e-3, 2.5e-3, 1.5e-3}, 2);
  const ModelKernelsOf<Bz> model({});
  CoupledRhs rhs(decomposition, diffusion, model);
  SbdfOptions options;
  options.relative_tolerance = 1e-3;
  options.wavefront_depth = static_cast<int>(state.range(2));
  Schedule schedule;
  schedule.end = 1e-6 * static_cast<double>(state.range(3));
  std::int64_t steps = 0;
  Count count;
  for (auto _ : state) {
    state.PauseTiming();
    Field u(decomposition, 3, 1);
    model.initialise(grid.dimension == 2 ? "bz-spiral" : "bz-front", u);
    Sbdf method(u, rhs, model, options);
    Progress progress;
    state.ResumeTiming();
    evolve(method, schedule, u, progress, count);
    steps += progress.accepted;
  }
  state.counters["sweeps/step"] = static_cast<double>(count.sweeps) / static_cast<double>(steps);
  state.counters["us/step"] =
      benchmark::Counter(1e-6 * static_cast<double>(steps), benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

BENCHMARK(sbdf_run)
    ->ArgNames({"dimension", "points", "depth", "time"})
    ->Args({2, 256, 1, 100000})
    ->Args({2, 256, 0, 100000})
    ->Args({2, 1001, 1, 1000})
    ->Args({2, 1001, 0, 1000})
    ->Args({1, 1001, 0, 100000})
    ->Args({1, 160001, 0, 10})
    ->Unit(benchmark::kMillisecond)
    ->Iterations(2)
    ->Repetitions(3)
    ->UseRealTime();

}  // namespace
