// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/app/simulation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <optional>
#include <utility>

#include "advice.hpp"
#include "failed_cell.hpp"
#include "stiffront/app/case_file.hpp"
#include "stiffront/app/method_stack.hpp"
#include "stiffront/app/methods.hpp"
#include "stiffront/app/problem.hpp"
#include "stiffront/app/signals.hpp"
#include "stiffront/app/watchdog.hpp"
#include "stiffront/control/evolve.hpp"
#include "stiffront/core/agree.hpp"
#include "stiffront/core/error.hpp"
#include "stiffront/core/timer.hpp"
#include "stiffront/core/version.hpp"
#include "stiffront/io/checkpoint.hpp"
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
  s.refuses_negative = c.reaction_solver.positivity == Positivity::reject_step;
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

/// Writes and reads checkpoints of a run: everything that decides its further course.
class RunMemory {
 public:
  RunMemory(const Case& c, Problem& problem, Method& method, Progress& progress, const OutputDirectory& directory)
      : case_(&c), problem_(&problem), method_(&method), progress_(&progress), directory_(&directory) {}

  /// A failure to write ends the run or is only reported, as output.checkpoint.on_failure says.
  void write() {
    const double began = wall_seconds();
    CheckpointHeader header;
    header.step = progress_->accepted;
    header.time = progress_->t;
    header.model = case_->model.name;
    header.species = problem_->model->description().species;
    header.grid = problem_->grid;
    header.case_text = effective_configuration(*case_);
    try {
      write_checkpoint(directory_->checkpoints(), header, problem_->decomposition, case_->output.checkpoint.keep,
                       [this](StateVisitor& v) { visit(v); });
      ++written;
    } catch (const Error& e) {
      if (e.kind() != ErrorKind::io || case_->output.checkpoint.on_failure == OnFailure::stop) throw;
      if (problem_->comm.is_root()) fmt::print(stderr, "warning: {}\n", e.what());
    }
    last_write = wall_seconds();
    seconds = last_write - began;
  }

  /// Takes the run up where a checkpoint left it.
  void read(const std::string& which, bool speaks) {
    const Checkpoint checkpoint(problem_->comm, which == "latest" ? directory_->path() : which);
    checkpoint.require(case_->model.name, problem_->model->description().species, problem_->grid);
    checkpoint.load(problem_->decomposition, [this](StateVisitor& v) { visit(v); });
    // Warnings are for everybody, quiet or not.
    for (const std::string& warning : checkpoint.warnings()) {
      if (problem_->comm.is_root()) fmt::print(stderr, "warning: {}\n", warning);
    }
    if (!speaks) return;
    fmt::print("restarted from {} at t = {:.10g} after {} steps\n", checkpoint.path(), progress_->t, progress_->accepted);
  }

  void visit(StateVisitor& v) {
    v.field("state", problem_->state);
    visit_progress(v, *progress_);
    v.integer("negatives", negatives);
    std::vector<double> counts{static_cast<double>(work.diffusion_steps),   static_cast<double>(work.diffusion_rejections),
                               static_cast<double>(work.diffusion_stages),  static_cast<double>(work.sweeps),
                               static_cast<double>(work.line_solves),       static_cast<double>(work.rhs_evaluations),
                               static_cast<double>(work.linear_iterations), static_cast<double>(work.halo_exchanges)};
    v.numbers("work", counts);
    std::int64_t* const targets[] = {&work.diffusion_steps, &work.diffusion_rejections, &work.diffusion_stages,  &work.sweeps,
                                     &work.line_solves,     &work.rhs_evaluations,      &work.linear_iterations, &work.halo_exchanges};
    for (std::size_t i = 0; i < std::size(targets); ++i) *targets[i] = static_cast<std::int64_t>(counts.at(i));
    method_->visit_state(v);
  }

  Work work;
  std::int64_t negatives = 0;
  std::int64_t written = 0;
  double last_write = wall_seconds();
  double seconds = 0.0;  ///< the last one took

 private:
  const Case* case_;
  Problem* problem_;
  Method* method_;
  Progress* progress_;
  const OutputDirectory* directory_;
};

/// Everything that watches a run. Root's clock and files, and every rank's signals, become requests that all ranks obey together.
class RunObserver final : public Observer {
 public:
  RunObserver(const Case& c, const MethodOptions& method, const Problem& problem, Output& output, ProgressLine& progress, RunMemory& memory,
              Watchdog& watchdog)
      : errors(method),
        case_(&c),
        comm_(&problem.comm),
        output_(&output),
        progress_(&progress),
        memory_(&memory),
        watchdog_(&watchdog),
        files_(c.output.directory) {}

  std::uint64_t requests() override {
    watchdog_->reset("in a step");
    attempt_began_ = wall_seconds();
    std::uint64_t flags = signals_.take();
    if (comm_->is_root()) {
      flags |= files_.take();
      const double every = case_->output.checkpoint.every_seconds;
      if (every > 0.0 && attempt_began_ - memory_->last_write >= every) flags |= requests::checkpoint;
      // Room for the last checkpoint: twice what one took, and the slowest attempt so far.
      const double limit = case_->limits.wall_time;
      if (limit > 0.0 && attempt_began_ - began_ + 2.0 * memory_->seconds + slowest_attempt_ >= limit) flags |= requests::stop;
    }
    return flags;
  }
  void attempted(const StepRecord& record) override {
    watchdog_->reset("after a step");
    const double took = wall_seconds() - attempt_began_;
    slowest_attempt_ = std::max(slowest_attempt_, took);
    memory_->work += record.attempt.work;
    if (record.attempt.accepted || !record.attempt.failure) failures.clear();
    if (record.attempt.failure) failures.push_back(*record.attempt.failure);
    errors.add(record);
    if (!record.attempt.reason.empty() && record.attempt.accepted) note = record.attempt.reason;
    output_->attempted(record, took);
    progress_->attempted(record);
  }
  void stepped(const StepRecord& record, double t_new, Field& u, Field& u_new) override {
    watchdog_->reset("writing output");
    progress_->stepped(record, t_new, output_->stepped(record, t_new, u, u_new) > 0);
  }
  bool carry_on(std::uint64_t flags, std::int64_t step, double, double, Field&) override {
    if ((flags & step_flags::negative) != 0) ++memory_->negatives;
    const std::int64_t every = case_->output.checkpoint.every_steps;
    stopped = (flags & requests::stop) != 0;
    if (stopped || (flags & requests::checkpoint) != 0 || (every > 0 && step % every == 0)) {
      watchdog_->reset("writing a checkpoint");
      output_->flush();
      memory_->write();
    }
    return !stopped;
  }

  bool stopped = false;
  std::vector<CellFailure> failures;  ///< cells of this rank, one per attempt, if the last attempts all failed by one
  ErrorRecord errors;
  std::string note;  ///< the last remark of the method on an accepted step

 private:
  const Case* case_;
  const Communicator* comm_;
  Output* output_;
  ProgressLine* progress_;
  RunMemory* memory_;
  Watchdog* watchdog_;
  SignalRequests signals_;
  FileRequests files_;
  double began_ = wall_seconds();
  double attempt_began_ = 0.0;
  double slowest_attempt_ = 0.0;
};

/// Sums the counts that are local to a rank; the others are the same everywhere.
Work over_all_ranks(Work w, const Communicator& comm) {
  for (std::int64_t* count :
       {&w.reaction_steps, &w.reaction_rejections, &w.reaction_newton_iterations, &w.reaction_rhs, &w.reaction_jacobians}) {
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

/// What balancing has done on all ranks, if there was any.
std::optional<Summary::Balance> balance_of(MethodStack& stack, const Communicator& comm) {
  const std::optional<BalanceCounts> mine = stack.balance();
  if (!mine) return std::nullopt;
  Summary::Balance b;
  // Groups sample the whole domain, so that one stands for all; of several the worst.
  const double mean = comm.max(mine->mean);
  if (mean > 0.0) {
    b.before = comm.max(mine->mean > 0.0 ? mine->largest_owned / mine->mean : 1.0);
    b.after = comm.max(mine->mean > 0.0 ? mine->largest_done / mine->mean : 1.0);
  }
  b.messages = comm.sum(mine->messages_sent);
  b.bytes = comm.sum(mine->bytes_sent);
  b.cells = comm.sum(mine->cells_sent);
  return b;
}

std::vector<std::pair<std::string, double>> slowest(const PhaseSeconds& mine, const Communicator& comm) {
  std::vector<std::pair<std::string, double>> seconds{{"diffusion", mine.diffusion},   {"reaction", mine.reaction},
                                                      {"quadrature", mine.quadrature}, {"communication", mine.communication},
                                                      {"output", mine.output},         {"total", mine.total}};
  for (auto& [phase, value] : seconds) value = comm.max(value);
  return seconds;
}

/// What every rank did; on every rank.
std::vector<Summary::RankWork> work_of_each(const Work& mine, const PhaseSeconds& seconds, const Communicator& comm) {
  const std::size_t ranks = static_cast<std::size_t>(comm.size());
  Agreement all(0, static_cast<int>(4 * ranks));
  const std::size_t at = 4 * static_cast<std::size_t>(comm.rank());
  all.maxima[at] = static_cast<double>(mine.reaction_newton_iterations);
  all.maxima[at + 1] = seconds.diffusion;
  all.maxima[at + 2] = seconds.reaction;
  all.maxima[at + 3] = seconds.communication;
  comm.agree(all);
  std::vector<Summary::RankWork> result;
  for (std::size_t r = 0; r < ranks; ++r) {
    const double* w = &all.maxima[4 * r];
    result.push_back({static_cast<std::int64_t>(w[0]), w[1], w[2], w[3]});
  }
  return result;
}

/// What is left behind of a run that failed: the last good state, and the cell that is to blame, if there is one, as a case of its own.
/// @return the cell in one sentence, on every rank; empty if there is none
std::string record_failure(const std::vector<CellFailure>& mine, const Case& c, const Problem& problem, const MethodStack& stack,
                           const Output& output, const OutputDirectory& directory, const Progress& progress) {
  const Communicator& comm = problem.comm;
  const int lowest = static_cast<int>(-comm.max(static_cast<std::int64_t>(mine.empty() ? -comm.size() : -comm.rank())));
  std::string text;
  std::string replay;
  if (lowest != comm.size()) {
    if (comm.rank() == lowest) {
      const CellFailure& cell = most_telling(mine);
      const double tolerance = stack.reaction_tolerance() > 0.0 ? stack.reaction_tolerance() : c.reaction_solver.tolerance;
      text = describe(cell, problem.model->description().species);
      replay = failed_cell_case(c, cell, tolerance);
    }
    text = comm.broadcast(text, lowest);
    replay = comm.broadcast(replay, lowest);
  }
  try {
    output.record_failure(progress.accepted, progress.t, problem.state, replay);
    if (!replay.empty()) text += fmt::format("; stiffront run {} runs this cell alone", directory.file(OutputDirectory::failed_cell));
  } catch (const Error& e) {
    // What stopped the run matters more.
    if (e.kind() != ErrorKind::io) throw;
    if (comm.is_root()) fmt::print(stderr, "warning: {}\n", e.what());
  }
  return text;
}

void print_opening(const Case& c, const Problem& problem, const MethodStack& stack) {
  const std::array<int, 2> p = problem.decomposition.processes();
  const Grid& g = problem.grid;
  fmt::print("stiffront {} ({}), {} rank{} as {} x {}\n", version::number, version::git_hash, problem.comm.size(),
             problem.comm.size() == 1 ? "" : "s", p[0], p[1]);
  fmt::print("{}: {}{}model {}, method {}\n", c.file, c.title, c.title.empty() ? "" : ", ", c.model.name, method_name(c.method));
  if (g.dimension == 1) {
    fmt::print("grid: {} points, spacing {:.6g}, order {}; ", g.uniform_points(0), g.spacing(0), c.space.order);
  } else {
    fmt::print("grid: {} x {} points, spacing {:.6g} x {:.6g}, order {}; ", g.uniform_points(0), g.uniform_points(1), g.spacing(0),
               g.spacing(1), c.space.order);
  }
  fmt::print("spectral radius of the diffusion {:.4g}\n", problem.diffusion.spectral_radius());
  if (!problem.note().empty()) fmt::print("initial state: {}\n", problem.note());
  if (!stack.choice().empty()) fmt::print("{}\n", stack.choice());
  std::fflush(stdout);
}

void print_closing(const Summary& s, const std::string& directory) {
  fmt::print("{}: t = {:.10g} after {} steps, {} rejected\n", s.status, s.time, s.accepted, s.rejected);
  for (const auto& [phase, seconds] : s.wall_seconds) {
    if (seconds > 0.0) fmt::print("  {:<14} {:>10.4f} s\n", phase, seconds);
  }
  if (s.ranks > 1 && s.balance) {
    fmt::print("  imbalance of the reaction {:.3f} before balancing, {:.3f} after\n", s.balance->before, s.balance->after);
  } else if (s.ranks > 1) {
    fmt::print("  imbalance of the reaction {:.3f}\n", s.imbalance);
  }
  for (const std::string& line : s.advice) fmt::print("  - {}\n", line);
  fmt::print("checksum {}; results in {}\n", s.checksum, directory);
  std::fflush(stdout);
}

}  // namespace

void simulate(const Case& c, const ModelRegistry& models, const Communicator& comm, const RunOptions& options) {
  Watchdog watchdog(comm.rank(), c.limits.stall_limit_s);
  Problem problem(c, models, comm);
  MethodStack stack(c, problem);
  const bool restarts = !options.restart.empty();
  const OutputDirectory directory(comm, c.output.directory,
                                  restarts        ? ExistingResults::keep
                                  : options.force ? ExistingResults::replace
                                                  : ExistingResults::refuse);
  Output output(directory, problem.decomposition, problem.boundary, problem.rhs, make_output_options(c, problem));
  const bool speaks = comm.is_root() && !options.quiet;
  if (speaks) print_opening(c, problem, stack);

  Progress progress;
  progress.t = c.time.start;
  RunMemory memory(c, problem, stack.method(), progress, directory);
  if (restarts) {
    memory.read(options.restart, speaks);
    output.resume(progress.accepted);
  } else {
    output.begin(progress.t, problem.state);
  }
  ProgressLine progress_line(speaks, options.progress, stdout, c.time.start, c.time.end);
  progress_line.begin(progress.t);
  RunObserver observer(c, stack.chosen(), problem, output, progress_line, memory, watchdog);

  const double began = wall_seconds();
  const double output_before = output.seconds();
  const Traffic traffic_before = comm.traffic();
  Summary summary;
  summary.status = "done";
  std::optional<Error> failure;
  try {
    if (!evolve(stack.method(), make_schedule(c, output), problem.state, progress, observer)) {
      summary.status = "stopped";
      summary.reason =
          fmt::format("stopped on request at t = {:.10g}; a checkpoint was written: run again with --restart latest", progress.t);
      failure = Error(ErrorKind::stopped, summary.reason);
    } else if (c.output.checkpoint.at_end) {
      memory.write();
    }
  } catch (const Error& e) {
    // Numerical failures are agreed on: every rank is here. Anything else ends the run where it is.
    if (e.kind() != ErrorKind::numerics) throw;
    const std::string cell = record_failure(observer.failures, c, problem, stack, output, directory, progress);
    failure = Error(e.kind(), cell.empty() ? e.what() : fmt::format("{}; {}", e.what(), cell));
    summary.status = "failed";
    summary.reason = failure->what();
  }
  if (!failure) summary.final_error = stack.method().final_error(progress.t, problem.state, memory.work);
  PhaseSeconds phases;
  phases.output = output.seconds() - output_before;
  phases.total = wall_seconds() - began - phases.output;
  const Traffic traffic = comm.traffic();
  phases.communication = traffic.seconds_waiting - traffic_before.seconds_waiting;
  stack.add_seconds(phases);
  progress_line.interrupt();
  output.flush();

  summary.note = stack.method().closing_note();
  summary.title = c.title;
  summary.model = c.model.name;
  summary.method = method_name(c.method);
  summary.choice = stack.choice();
  summary.grid = problem.grid;
  summary.time = progress.t;
  summary.accepted = progress.accepted;
  summary.rejected = progress.rejected;
  summary.work = over_all_ranks(memory.work, comm);
  summary.wall_seconds = slowest(phases, comm);
  summary.ranks = comm.size();
  summary.processes = {problem.decomposition.processes()[0], problem.decomposition.processes()[1]};
  summary.imbalance = imbalance(memory.work, summary.work, comm);
  summary.negatives = memory.negatives;
  summary.peak_memory_mib = comm.max(peak_memory_mib());
  summary.output_files = output.files();
  summary.checkpoints = memory.written;
  summary.restarted = restarts;
  summary.checksum = checksum(problem.state);
  summary.allreduces = traffic.reductions - traffic_before.reductions;
  summary.halo_messages = comm.sum(traffic.halo_messages - traffic_before.halo_messages);
  summary.halo_bytes = comm.sum(traffic.halo_bytes - traffic_before.halo_bytes);
  summary.balance = balance_of(stack, comm);
  summary.rank_work = work_of_each(memory.work, phases, comm);
  if (summary.status == "done") summary.advice = advice(c, summary, observer.errors, spatial_error(problem));
  collectively(comm, [&] {
    if (comm.is_root()) write_summary(directory.file("summary.json"), summary);
  });
  if (failure) throw *failure;
  if (!speaks) return;
  for (const std::string& note : {observer.note, summary.note}) {
    if (!note.empty()) fmt::print("note: {}\n", note);
  }
  print_closing(summary, directory.path());
}

}  // namespace stiffront::app
