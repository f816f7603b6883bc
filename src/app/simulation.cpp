// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/app/simulation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <optional>
#include <utility>

#include "stiffront/app/case_file.hpp"
#include "stiffront/app/method_stack.hpp"
#include "stiffront/app/methods.hpp"
#include "stiffront/app/problem.hpp"
#include "stiffront/control/evolve.hpp"
#include "stiffront/core/agree.hpp"
#include "stiffront/core/error.hpp"
#include "stiffront/core/timer.hpp"
#include "stiffront/core/version.hpp"
#include "stiffront/io/checksum.hpp"
#include "stiffront/io/memory.hpp"
#include "stiffront/io/output.hpp"
#include "stiffront/io/output_directory.hpp"
#include "stiffront/io/summary.hpp"

namespace stiffront::app {
namespace {

Schedule make_schedule(const Case& c, const Output& output) {
  Schedule s;
  s.start = c.time.start;
  s.end = c.time.end;
  s.breakpoints = c.time.breakpoints;
  s.restart_period = c.time.restart_step.period;
  s.restart_step = c.time.restart_step.step;
  s.max_steps = c.limits.max_steps;
  s.landing_times = output.landing_times();
  return s;
}

Output::Options make_output_options(const Case& c, const Problem& problem) {
  Output::Options o;
  o.times = {c.time.start, c.time.end, c.output.times, c.output.every, c.output.steps};
  o.land = c.output.mode == OutputMode::land;
  for (const std::vector<double>& p : c.output.probes) o.probes.push_back({p[0], p.size() > 1 ? p[1] : 0.0});
  o.species = problem.model->description().species;
  o.case_text = effective_configuration(c);
  return o;
}

/// Everything that watches a run, and what the summary needs to know of it.
class RunObserver final : public Observer {
 public:
  RunObserver(Output& output, ProgressLine& progress) : output_(&output), progress_(&progress) {}

  std::uint64_t requests() override {
    output_->before_attempt();
    return 0;
  }
  void attempted(const StepRecord& record) override {
    work += record.attempt.work;
    if (!record.attempt.accepted) ++rejected;
    failure = record.attempt.failure;
    output_->attempted(record);
    progress_->attempted(record);
  }
  void stepped(const StepRecord& record, double t_new, Field& u, Field& u_new) override {
    progress_->stepped(record, t_new, output_->stepped(record, t_new, u, u_new) > 0);
  }
  bool carry_on(std::uint64_t flags, std::int64_t, double, double, Field&) override {
    if ((flags & step_flags::negative) != 0) ++negatives;
    return true;
  }

  Work work;
  std::int64_t rejected = 0;
  std::int64_t negatives = 0;
  std::optional<CellFailure> failure;

 private:
  Output* output_;
  ProgressLine* progress_;
};

/// Sums the counts that are local to a rank; the others are the same everywhere.
Work over_all_ranks(Work w, const Communicator& comm) {
  for (std::int64_t* count : {&w.reaction_steps, &w.reaction_rejections, &w.reaction_newton_iterations, &w.reaction_rhs, &w.reaction_jacobians}) {
    *count = comm.sum(*count);
  }
  return w;
}

/// Largest over mean work of the ranks in the reaction, by Newton iterations.
double imbalance(const Work& mine, const Work& all, const Communicator& comm) {
  const double largest = comm.max(static_cast<double>(mine.reaction_newton_iterations));
  const double mean = static_cast<double>(all.reaction_newton_iterations) / comm.size();
  return mean > 0.0 ? largest / mean : 1.0;
}

std::vector<std::pair<std::string, double>> slowest(const PhaseSeconds& mine, const Communicator& comm) {
  std::vector<std::pair<std::string, double>> seconds{{"diffusion", mine.diffusion},         {"reaction", mine.reaction},
                                                      {"quadrature", mine.quadrature},       {"communication", mine.communication},
                                                      {"output", mine.output},               {"total", mine.total}};
  for (auto& [phase, value] : seconds) value = comm.max(value);
  return seconds;
}

/// The cell that could not be integrated, in one sentence, on every rank; empty if the run failed for another reason.
std::string describe_failure(const std::optional<CellFailure>& mine, const Problem& problem) {
  const Communicator& comm = problem.comm;
  const int lowest = static_cast<int>(-comm.max(static_cast<std::int64_t>(mine ? -comm.rank() : -comm.size())));
  if (lowest == comm.size()) return {};
  std::string text;
  if (mine) {
    text = fmt::format("cell ({}, {}) at x = {:.10g}, y = {:.10g}, t = {:.10g}: {} (inner step {:.3g} of {:.3g}); state", mine->i, mine->j,
                       mine->x, mine->y, mine->t, mine->reason, mine->dt, mine->interval);
    const std::vector<std::string>& names = problem.model->description().species;
    for (std::size_t s = 0; s < mine->state.size(); ++s) text += fmt::format("{} {} = {:.17g}", s == 0 ? "" : ",", names[s], mine->state[s]);
  }
  return comm.broadcast(text, lowest);
}

void print_opening(const Case& c, const Problem& problem, const MethodStack& stack) {
  const std::array<int, 2> p = problem.decomposition.processes();
  const Grid& g = problem.grid;
  fmt::print("stiffront {} ({}), {} rank{} as {} x {}\n", version::number, version::git_hash, problem.comm.size(),
             problem.comm.size() == 1 ? "" : "s", p[0], p[1]);
  fmt::print("{}: {}{}model {}, method {}\n", c.file, c.title, c.title.empty() ? "" : ", ", c.model.name, method_name(c.method));
  if (g.dimension == 1) {
    fmt::print("grid: {} points, spacing {:.6g}, order {}; ", g.points[0], g.spacing(0), c.space.order);
  } else {
    fmt::print("grid: {} x {} points, spacing {:.6g} x {:.6g}, order {}; ", g.points[0], g.points[1], g.spacing(0), g.spacing(1), c.space.order);
  }
  fmt::print("spectral radius of the diffusion {:.4g}\n", problem.diffusion.spectral_radius());
  if (!stack.choice().empty()) fmt::print("{}\n", stack.choice());
  std::fflush(stdout);
}

void print_closing(const Summary& s, const std::string& directory) {
  fmt::print("{}: t = {:.10g} after {} steps, {} rejected\n", s.status, s.time, s.accepted, s.rejected);
  for (const auto& [phase, seconds] : s.wall_seconds) {
    if (seconds > 0.0) fmt::print("  {:<14} {:>10.4f} s\n", phase, seconds);
  }
  if (s.ranks > 1) fmt::print("  imbalance of the reaction {:.3f}\n", s.imbalance);
  if (s.negatives > 0) fmt::print("  {} states held negative values\n", s.negatives);
  fmt::print("checksum {}; results in {}\n", s.checksum, directory);
  std::fflush(stdout);
}

}  // namespace

void simulate(const Case& c, const ModelRegistry& models, const Communicator& comm, const RunOptions& options) {
  Problem problem(c, models, comm);
  MethodStack stack(c, problem);
  const OutputDirectory directory(comm, c.output.directory, options.force ? ExistingResults::replace : ExistingResults::refuse);
  Output output(directory, problem.decomposition, problem.boundary, problem.rhs, make_output_options(c, problem));
  const bool speaks = comm.is_root() && !options.quiet;
  if (speaks) print_opening(c, problem, stack);

  ProgressLine progress_line(speaks, options.progress, stdout, c.time.start, c.time.end);
  RunObserver observer(output, progress_line);
  Progress progress;
  progress.t = c.time.start;
  output.begin(progress.t, problem.state);
  progress_line.begin(progress.t);

  const double began = wall_seconds();
  const double output_before = output.seconds();
  const double reducing_before = comm.seconds_reducing();
  Summary summary;
  summary.status = "done";
  std::optional<Error> failure;
  try {
    evolve(stack.method(), make_schedule(c, output), problem.state, progress, observer);
  } catch (const Error& e) {
    // Numerical failures are agreed on: every rank is here. Anything else ends the run where it is.
    if (e.kind() != ErrorKind::numerics) throw;
    const std::string cell = describe_failure(observer.failure, problem);
    failure = Error(e.kind(), cell.empty() ? e.what() : fmt::format("{}; {}", e.what(), cell));
    summary.status = "failed";
    summary.reason = failure->what();
  }
  PhaseSeconds phases;
  phases.output = output.seconds() - output_before;
  phases.total = wall_seconds() - began - phases.output;
  phases.communication = comm.seconds_reducing() - reducing_before;
  stack.add_seconds(phases);
  progress_line.interrupt();
  output.flush();

  summary.title = c.title;
  summary.model = c.model.name;
  summary.method = method_name(c.method);
  summary.grid = problem.grid;
  summary.time = progress.t;
  summary.accepted = progress.accepted;
  summary.rejected = progress.rejected;
  summary.work = over_all_ranks(observer.work, comm);
  summary.wall_seconds = slowest(phases, comm);
  summary.ranks = comm.size();
  summary.processes = {problem.decomposition.processes()[0], problem.decomposition.processes()[1]};
  summary.imbalance = imbalance(observer.work, summary.work, comm);
  summary.negatives = observer.negatives;
  summary.peak_memory_mib = comm.max(peak_memory_mib());
  summary.output_files = output.files();
  summary.checksum = checksum(problem.state);
  summary.allreduces = comm.reductions();
  collectively(comm, [&] {
    if (comm.is_root()) write_summary(directory.file("summary.json"), summary);
  });
  if (failure) throw *failure;
  if (speaks) print_closing(summary, directory.path());
}

}  // namespace stiffront::app
