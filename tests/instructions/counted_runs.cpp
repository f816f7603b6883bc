// SPDX-License-Identifier: BSD-3-Clause
// Small fixed runs of the kernels, each inside counted_region(), for callgrind to count (instructions_test.py). Prints the
// names of the runs in order. Everything that varies from machine to machine (MPI's start, files) is outside the regions.
#include <mpi.h>

#include <cmath>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include "stiffront/control/evolve.hpp"
#include "stiffront/control/sbdf.hpp"
#include "stiffront/core/floating_point.hpp"
#include "stiffront/model/builtin/brusselator.hpp"
#include "stiffront/model/builtin/bz.hpp"
#include "stiffront/solvers/model_kernels.hpp"
#include "stiffront/solvers/radau5_kernel.hpp"
#include "stiffront/solvers/rock4.hpp"

extern "C" [[gnu::noinline]] void counted_region(const std::function<void()>& run) {
  run();
  asm volatile("" ::: "memory");
}

namespace {

using namespace stiffront;

void counted(const char* name, const std::function<void()>& run) {
  std::puts(name);
  counted_region(run);
}

Grid square(int dimension, std::int64_t points) {
  Grid grid;
  grid.dimension = dimension;
  grid.points = {points, dimension == 2 ? points : 1};
  return grid;
}

class Passes final : public Observer {
 public:
  void attempted(const StepRecord& record) override {
    sweeps += record.attempt.work.sweeps;
    lines += record.attempt.work.line_solves;
  }
  std::int64_t sweeps = 0, lines = 0;
};

template <class M>
Passes sbdf_run(const char* name, const Grid& grid, const std::vector<double>& diffusion, const M& parameters, const char* profile,
                double end) {
  const Communicator comm(MPI_COMM_SELF);
  const Decomposition decomposition(comm, grid, {0, 0}, 1);
  const Boundary boundary = Boundary::natural(grid);
  const DiffusionOperator diffusion_operator(grid, boundary, diffusion, 2);
  const ModelKernelsOf<M> model(parameters, describe<M>());
  CoupledRhs rhs(decomposition, diffusion_operator, model);
  SbdfOptions options;
  options.relative_tolerance = 1e-4;
  Schedule schedule;
  schedule.end = end;
  Field u(decomposition, M::n_species, 1);
  model.initialise(profile, u);
  Sbdf method(u, rhs, model, options);
  Progress progress;
  Passes passes;
  counted(name, [&] { evolve(method, schedule, u, progress, passes); });
  return passes;
}

void rock4_step(const char* name, int order) {
  const Communicator comm(MPI_COMM_SELF);
  const Grid grid = square(2, 64);
  const Decomposition decomposition(comm, grid, {0, 0}, 4);
  const Boundary boundary = Boundary::natural(grid);
  const DiffusionOperator diffusion(grid, boundary, {1.0, 0.5}, order);
  Field u(decomposition, 2, diffusion.halo_width());
  for (int s = 0; s < 2; ++s) {
    for (int j = 0; j < u.n_y(); ++j) {
      for (int i = 0; i < u.n_x(); ++i) u.at(s, i, j) = 2.0 + std::sin(0.1 * i + s) * std::cos(0.07 * j);
    }
  }
  Rock4 flow(decomposition, diffusion, {1.0, {1e9, 1e9}});  // every step accepted
  const double dt = rock4_interval(20) * (1.0 - 1e-12) / diffusion.spectral_radius();
  const double first[] = {dt};
  Work work;
  counted(name, [&] {
    for (int k = 0; k < 5; ++k) {
      flow.set_state(first);
      flow.advance(0.0, dt, u, u, work);
    }
  });
}

/// Cells along a slow manifold and off it: one step each for most, several for some.
void radau5_cells() {
  constexpr int n = 1001;
  std::vector<double> u(3 * n), to(3 * n), hint(n, 0.0);
  std::vector<float> cost(n);
  for (int i = 0; i < n; ++i) {
    const double b = 0.8 * i / n;
    u[static_cast<std::size_t>(n + i)] = b;
    u[static_cast<std::size_t>(2 * n + i)] = 0.05;
    u[static_cast<std::size_t>(i)] = (i % 16 == 0 ? 1.5 : 1.0) * 1.6 * 0.05 / (2e-3 + b);
  }
  const double absolute[] = {1e-5, 1e-5, 1e-5};
  Radau5Kernel<Bz, Pack> kernel(Bz{}, Radau5Tolerances<3>(1e-5, absolute));
  counted("radau5", [&] {
    for (int k = 0; k < 4; ++k) {
      kernel.begin(0.0, 1e-3);
      kernel.row({n, u.data(), n, to.data(), n, hint.data(), cost.data(), 0}, [](int, int) {
        return Place<Pack>{Pack(0.0), Pack(0.0), Pack(0.0)};
      });
      if (kernel.finish()) std::abort();
    }
  });
}

}  // namespace

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  flush_denormals_to_zero();
  sbdf_run("sbdf-1d", square(1, 401), {2.5e-3, 2.5e-3, 1.5e-3}, Bz{}, "bz-front", 0.02);
  sbdf_run("sbdf-2d", square(2, 64), {2.5e-3, 2.5e-3, 1.5e-3}, Bz{}, "bz-spiral", 0.02);
  const Passes coupled = sbdf_run("sbdf-line", square(1, 401), {0.1, 0.1}, Brusselator{}, "brusselator-cosine", 1.0);
  if (coupled.lines == 0) return 1;  // no longer a run of the line solver
  rock4_step("rock4-order-2", 2);
  rock4_step("rock4-order-4", 4);
  radau5_cells();
  MPI_Finalize();
  return 0;
}
