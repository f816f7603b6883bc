// SPDX-License-Identifier: BSD-3-Clause
//
// Runs the models that are hard for a method with error control over six decades of tolerances and prints, in Markdown,
// steps/rejections/passes (sweeps + line iterations, or coupled right-hand sides) and the error at the end.
//
//   stress_table DIRECTORY METHOD [CASE ...]
//
// METHOD: sbdf, auto, cvode-band or cvode-gmres. References (CVODE, banded at a relative tolerance of 1e-11, in two
// dimensions with GMRES at 1e-10) are kept in DIRECTORY. Errors: root mean square over the points, divided by the
// largest modulus, worst species. Seconds are those of the time loop, the least of three runs.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "stiffront/app/case_file.hpp"
#include "stiffront/app/case_source.hpp"
#include "stiffront/app/method_stack.hpp"
#include "stiffront/app/problem.hpp"
#include "stiffront/control/evolve.hpp"
#include "stiffront/core/error.hpp"
#include "stiffront/core/floating_point.hpp"
#include "stiffront/core/timer.hpp"
#include "stiffront/solvers/model_registry.hpp"

namespace {

using namespace stiffront;

struct StressCase {
  std::string name;
  std::string builtin;
  std::vector<std::string> overrides;
};

const std::vector<StressCase> cases = {
    {"bruss1e4", "brusselator-stiff-1d", {}},
    {"bruss1e6", "brusselator-stiff-1d", {"model.parameters.B=1e6"}},
    {"grayscott", "gray-scott-1d", {}},
    {"fhn", "fhn-1d", {}},
    {"flame10", "flame-1d", {}},
    {"flame40",
     "flame-1d",
     {"model.parameters.Ze=40", "model.parameters.Le=0.8", "model.diffusion.fuel=1.25", "grid.upper=[10.0]", "grid.points=[1001]",
      "time.end=0.5", "output.every=0.1"}},
    {"angio", "angiogenesis-1d", {}},
    {"ignite", "ignition-1d", {}},
    {"lamom20", "lambda-omega-1d", {}},
    {"lamom200", "lambda-omega-1d", {"model.parameters.omega=200"}},
    {"slave100", "slaved-oscillator-1d", {"model.parameters.damping=100"}},
    {"slave20", "slaved-oscillator-1d", {}},
    {"slave5", "slaved-oscillator-1d", {"model.parameters.damping=5", "model.parameters.omega=500"}},
    {"pulse", "pulse-1d", {}},
    // The same in two dimensions, on coarser grids so that GMRES can make the reference.
    {"bruss1e4-2d",
     "brusselator-stiff-1d",
     {"grid={points=[101,101],lower=[0.0,0.0],upper=[1.0,1.0]}",
      "initial={u=\"1+0.5*cos(pi*x)*cos(2*pi*y)\",v=\"3+0.5*cos(2*pi*x)*cos(pi*y)\"}"}},
    {"grayscott-2d",
     "gray-scott-1d",
     {"grid={points=[151,151],lower=[0.0,0.0],upper=[100.0,100.0]}", "time.end=200", "output.every=50",
      "initial={u=\"1-0.5*exp(-((x-45)^2+(y-52)^2)/9)\",v=\"0.25*exp(-((x-45)^2+(y-52)^2)/9)\"}"}},
    {"flame10-2d",
     "flame-1d",
     {"grid={points=[201,101],lower=[0.0,0.0],upper=[20.0,10.0]}", "time.end=2", "output.every=1",
      "initial={fuel=\"max(0,1-exp(5+cos(0.6*y)-x))\",theta=\"min(1,exp(5+cos(0.6*y)-x))\"}"}},
    {"angio-2d",
     "angiogenesis-1d",
     {"grid={points=[151,151],lower=[0.0,0.0],upper=[1.0,1.0]}",
      "initial={rho=\"exp(-(x^2+0.3*(y-0.4)^2)/0.01)\",c=\"cos(pi*x/2)*(1+0.2*cos(pi*y))\"}"}},
    {"fhn-2d",
     "fhn-1d",
     {"grid={points=[151,151],lower=[0.0,0.0],upper=[15.0,15.0]}", "time.end=1", "output.every=0.5",
      "initial={u=\"0.5-0.5*tanh((sqrt(x^2+y^2)-3)/0.5)\",v=\"0\"}"}},
};

struct Run {
  std::vector<double> state;  // of one species after the other
  int n_species = 0;
  Progress progress;
  Work work;
  double seconds = 0.0;
  std::string note;
  std::string failure;
};

class Counter final : public Observer {
 public:
  explicit Counter(Work& work) : work_(&work) {}
  void attempted(const StepRecord& r) override { *work_ += r.attempt.work; }

 private:
  Work* work_;
};

Run run(const StressCase& stress, std::vector<std::string> method, const Communicator& comm) {
  ModelRegistry models;
  register_builtin_models(models);
  std::vector<std::string> overrides = stress.overrides;
  overrides.insert(overrides.end(), method.begin(), method.end());
  const app::Case c = app::parse_case(app::read_case_source(stress.builtin, overrides), models.descriptions());
  app::Problem problem(c, models, comm);
  app::MethodStack stack(c, problem);
  Schedule schedule;
  schedule.start = c.time.start;
  schedule.end = c.time.end;
  schedule.breakpoints = c.time.breakpoints;
  schedule.max_steps = 2000000;
  Run r;
  r.progress.t = schedule.start;
  Counter counter(r.work);
  const double began = wall_seconds();
  try {
    evolve(stack.method(), schedule, problem.state, r.progress, counter);
  } catch (const Error& e) {
    r.failure = e.what();
  }
  r.seconds = wall_seconds() - began;
  r.note = stack.method().closing_note();
  r.n_species = problem.state.n_species();
  for (int s = 0; s < r.n_species; ++s) {
    for (int j = 0; j < problem.state.n_y(); ++j) {
      const double* row = problem.state.row(s, j);
      r.state.insert(r.state.end(), row, row + problem.state.n_x());
    }
  }
  return r;
}

std::vector<std::string> method_overrides(const std::string& name, double tolerance) {
  std::vector<std::string> result;
  const std::string method = name.substr(0, name.find('-'));
  result.push_back(fmt::format("method={{name=\"{}\"}}", method));
  if (method == "auto") {
    result.push_back(fmt::format("method.tolerance={:e}", tolerance));
    return result;
  }
  result.push_back(fmt::format("method.relative_tolerance={:e}", tolerance));
  result.push_back(fmt::format("method.absolute_tolerance={:e}", 0.01 * tolerance));
  if (method == "cvode") result.push_back(fmt::format("method.linear_solver=\"{}\"", name.substr(method.size() + 1)));
  return result;
}

std::vector<double> reference(const StressCase& stress, const std::string& directory, const Communicator& comm) {
  const std::filesystem::path file = std::filesystem::path(directory) / (stress.name + ".reference");
  std::vector<double> state;
  if (std::filesystem::exists(file)) {
    state.resize(std::filesystem::file_size(file) / sizeof(double));
    std::ifstream(file, std::ios::binary)
        .read(reinterpret_cast<char*>(state.data()), static_cast<std::streamsize>(state.size() * sizeof(double)));
    return state;
  }
  const bool plane = stress.name.find("-2d") != std::string::npos;
  const Run r = run(stress, plane ? method_overrides("cvode-gmres", 1e-10) : method_overrides("cvode-band", 1e-11), comm);
  if (!r.failure.empty()) throw Error(ErrorKind::numerics, r.failure);
  std::filesystem::create_directories(directory);
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(r.state.data()), static_cast<std::streamsize>(r.state.size() * sizeof(double)));
  return r.state;
}

double error(const Run& run, const std::vector<double>& exact) {
  const std::size_t points = exact.size() / static_cast<std::size_t>(run.n_species);
  double worst = 0.0;
  for (std::size_t s = 0; s < static_cast<std::size_t>(run.n_species); ++s) {
    double squares = 0.0;
    double largest = 0.0;
    for (std::size_t i = s * points; i < (s + 1) * points; ++i) {
      squares += (run.state[i] - exact[i]) * (run.state[i] - exact[i]);
      largest = std::max(largest, std::abs(exact[i]));
    }
    worst = std::max(worst, std::sqrt(squares / static_cast<double>(points)) / largest);
  }
  return worst;
}

int table(const std::vector<std::string>& arguments) {
  const Communicator comm(MPI_COMM_SELF);
  fmt::print("| model | 1e-3 | 1e-4 | 1e-5 | 1e-6 | 1e-7 | 1e-8 | seconds |\n|---|---|---|---|---|---|---|---|\n");
  for (const StressCase& stress : cases) {
    if (arguments.size() > 2 && std::find(arguments.begin() + 2, arguments.end(), stress.name) == arguments.end()) continue;
    const std::vector<double> exact = reference(stress, arguments[0], comm);
    fmt::print("| {}", stress.name);
    std::string seconds;
    std::vector<std::string> notes;
    for (double tolerance : {1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8}) {
      Run r = run(stress, method_overrides(arguments[1], tolerance), comm);
      for (int repeat = 1; repeat < 3; ++repeat) {
        r.seconds = std::min(r.seconds, run(stress, method_overrides(arguments[1], tolerance), comm).seconds);
      }
      const auto passes = r.work.sweeps + r.work.line_solves + r.work.rhs_evaluations;
      fmt::print(" | {}/{}/{} {}", r.progress.accepted, r.progress.rejected, passes,
                 r.failure.empty() ? fmt::format("{:.1e}", error(r, exact)) : "failed: " + r.failure);
      if (!r.note.empty()) notes.push_back(fmt::format("{} at {:.0e}: {}", stress.name, tolerance, r.note));
      seconds += fmt::format("{}{:.3g}", seconds.empty() ? "" : ", ", r.seconds);
      std::fflush(stdout);
    }
    fmt::print(" | {} |\n", seconds);
    for (const std::string& note : notes) fmt::print(stderr, "{}\n", note);
  }
  return EXIT_SUCCESS;
}

}  // namespace

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  stiffront::flush_denormals_to_zero();  // as the program does
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  int status = EXIT_FAILURE;
  if (arguments.size() < 2) {
    fmt::print(stderr, "usage: stress_table DIRECTORY METHOD [CASE ...]\n");
  } else {
    try {
      status = table(arguments);
    } catch (const std::exception& e) {
      fmt::print(stderr, "stress_table: {}\n", e.what());
    }
  }
  MPI_Finalize();
  return status;
}
