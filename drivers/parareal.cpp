// SPDX-License-Identifier: BSD-3-Clause
//
// The parareal iteration of appendix A of Duarte & Emmett 2016 with a splitting of large steps as coarse and one of small steps as fine
// propagator, parallel in space and in time; docs/dcs.md.
//
//   mpirun -n 4 parareal bz-1d time.start=0 time.end=0.04 --groups 4 --intervals 8 --coarse-step 1e-3 --fine-step 2e-5 --iterations 4
#include "stiffront/control/parareal.hpp"

#include <fmt/format.h>
#include <mpi.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "stiffront/app/case_file.hpp"
#include "stiffront/app/case_source.hpp"
#include "stiffront/app/method_stack.hpp"
#include "stiffront/app/problem.hpp"
#include "stiffront/control/evolve.hpp"
#include "stiffront/core/error.hpp"
#include "stiffront/solvers/model_registry.hpp"

namespace {

using namespace stiffront;

struct Options {
  std::string case_name;
  std::vector<std::string> overrides;
  int groups = 1;
  int intervals = 8;
  int iterations = 3;
  double coarse_step = 0.0;
  double fine_step = 0.0;
};

/// The processes of one group, and those with the same part of space in all groups.
Communicator part(const Communicator& world, int color, int key) {
  MPI_Comm split = MPI_COMM_NULL;
  check_mpi(MPI_Comm_split(world.get(), color, key, &split), "MPI_Comm_split");
  Communicator copy(split);
  MPI_Comm_free(&split);
  return copy;
}

/// Strang splitting of a fixed step over any interval.
class Propagator {
 public:
  Propagator(app::Case c, double step, app::Problem& problem) : stack_(with_step(c, step), problem) {}

  void operator()(double t, double dt, Field& from, Field& to) {
    to.copy_interior(from);
    Schedule schedule;
    schedule.start = t;
    schedule.end = t + dt;
    Progress progress;
    progress.t = t;
    Observer nobody;
    evolve(stack_.method(), schedule, to, progress, nobody);
  }

 private:
  static const app::Case& with_step(app::Case& c, double step) {
    app::StrangOptions strang;
    strang.step = step;
    c.method = strang;
    return c;
  }
  app::MethodStack stack_;
};

/// Largest difference over the largest modulus, species by species. @mpi collective in space
double distance(Field& a, Field& b, const Communicator& space) {
  double worst = 0.0;
  for (int s = 0; s < a.n_species(); ++s) {
    double difference = 0.0, largest = 0.0;
    for (int j = 0; j < a.n_y(); ++j) {
      for (int i = 0; i < a.n_x(); ++i) {
        difference = std::max(difference, std::abs(a.at(s, i, j) - b.at(s, i, j)));
        largest = std::max(largest, std::abs(b.at(s, i, j)));
      }
    }
    difference = space.max(difference);
    largest = space.max(largest);
    if (largest > 0.0) worst = std::max(worst, difference / largest);
  }
  return worst;
}

int run(const Options& o, const Communicator& world) {
  if (o.groups < 1 || world.size() % o.groups != 0) {
    throw Error(ErrorKind::usage, fmt::format("--groups: {} processes do not make {} groups of the same size", world.size(), o.groups));
  }
  const int ranks_in_space = world.size() / o.groups;
  const Communicator space = part(world, world.rank() / ranks_in_space, world.rank());
  const Communicator time = part(world, world.rank() % ranks_in_space, world.rank());
  ModelRegistry models;
  register_builtin_models(models);
  const app::Case c = app::parse_case(app::read_case_source(o.case_name, o.overrides, world), models.descriptions());
  app::Problem problem(c, models, space);
  Propagator coarse(c, o.coarse_step, problem);
  Propagator fine(c, o.fine_step, problem);
  const double dt = (c.time.end - c.time.start) / o.intervals;
  const auto begin_of = [&](int i) { return c.time.start + i * dt; };

  Field expected = problem.state.similar();
  expected.copy_interior(problem.state);
  Field next = problem.state.similar();
  double coarse_seconds = -MPI_Wtime();
  for (int i = 0; i < o.intervals; ++i) {
    coarse(begin_of(i), dt, expected, next);
    swap(expected, next);
  }
  coarse_seconds += MPI_Wtime();
  expected.copy_interior(problem.state);
  world.barrier();
  double fine_seconds = -MPI_Wtime();
  for (int i = 0; i < o.intervals; ++i) {
    fine(begin_of(i), dt, expected, next);
    swap(expected, next);
  }
  fine_seconds += MPI_Wtime();
  fine_seconds = world.max(fine_seconds);
  coarse_seconds = world.max(coarse_seconds);
  if (world.is_root()) {
    fmt::print("{} groups of {} processes, {} intervals of {:g}; one after the other: coarse {:.3g} s, fine {:.3g} s\n", o.groups,
               ranks_in_space, o.intervals, dt, coarse_seconds, fine_seconds);
    fmt::print("{:>10} {:>12} {:>12} {:>9} {:>9} {:>9}\n", "iteration", "change", "error", "seconds", "speed-up", "model");
  }

  Parareal parareal(problem.state, o.intervals, time, [&](int i, Field& from, Field& to) { coarse(begin_of(i), dt, from, to); });
  const bool at_end = time.rank() + 1 == time.size();
  const auto report = [&](int k, double change, double seconds) {
    const double error = world.max(at_end ? distance(parareal.state(parareal.last() - parareal.first()), expected, space) : 0.0);
    change = world.max(change);
    seconds = world.max(seconds);
    if (world.is_root()) {
      fmt::print("{:>10} {:>12.4e} {:>12.4e} {:>9.3f} {:>9.2f} {:>9.2f}\n", k, change, error, seconds, fine_seconds / seconds,
                 parareal_speed_up(o.groups, k, coarse_seconds / fine_seconds));
    }
  };
  world.barrier();
  double seconds = -MPI_Wtime();
  parareal.predict(problem.state);
  seconds += MPI_Wtime();
  report(0, 0.0, seconds);
  for (int k = 1; k <= o.iterations; ++k) {
    seconds -= MPI_Wtime();
    const double change = parareal.iterate([&](std::vector<Field>& states, std::vector<Field>& results) {
      for (int i = parareal.first(); i < parareal.last(); ++i) {
        const auto j = static_cast<std::size_t>(i - parareal.first());
        fine(begin_of(i), dt, states[j], results[j]);
      }
    });
    seconds += MPI_Wtime();
    report(k, change, seconds);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  Options o;
  CLI::App application("Parareal: parallel in time, with a splitting of large steps as coarse and one of small steps as fine propagator.");
  application.add_option("case", o.case_name, "case file, or the name of a built-in case")->required();
  application.add_option("overrides", o.overrides, "KEY=VALUE, as for stiffront run");
  application.add_option("--groups", o.groups, "groups of processes in time; the rest of the processes shares the space");
  application.add_option("--intervals", o.intervals, "intervals of time")->check(CLI::PositiveNumber);
  application.add_option("--iterations", o.iterations, "corrections");
  application.add_option("--coarse-step", o.coarse_step, "step of the coarse Strang splitting")->required()->check(CLI::PositiveNumber);
  application.add_option("--fine-step", o.fine_step, "step of the fine one")->required()->check(CLI::PositiveNumber);
  CLI11_PARSE(application, argc, argv);
  MPI_Init(&argc, &argv);
  int status = 0;
  try {
    const Communicator world(MPI_COMM_WORLD);
    status = run(o, world);
  } catch (const Error& e) {
    fmt::print(stderr, "parareal: {}\n", e.what());
    MPI_Abort(MPI_COMM_WORLD, 1);
  }
  MPI_Finalize();
  return status;
}
