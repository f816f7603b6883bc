// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/app/convergence.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <type_traits>

#include "stiffront/app/method_stack.hpp"
#include "stiffront/app/methods.hpp"
#include "stiffront/app/problem.hpp"
#include "stiffront/control/evolve.hpp"
#include "stiffront/control/state_norm.hpp"
#include "stiffront/core/agree.hpp"
#include "stiffront/core/error.hpp"
#include "stiffront/io/result_file.hpp"

namespace stiffront::app {
namespace {

/// A state with the grid it lives on.
struct Solution {
  std::unique_ptr<Problem> problem;
  Field& state() const { return problem->state; }
};

Solution solve(const Case& c, const ModelRegistry& models, const Communicator& comm, double end,
               MethodStack::Purpose purpose = MethodStack::Purpose::run) {
  Solution s{std::make_unique<Problem>(c, models, comm)};
  MethodStack stack(c, *s.problem, purpose);
  Schedule schedule;
  schedule.start = c.time.start;
  schedule.end = end;
  for (double t : c.time.breakpoints) {
    if (t < end) schedule.breakpoints.push_back(t);
  }
  schedule.restart_period = c.time.restart_step.period;
  schedule.restart_step = c.time.restart_step.step;
  Progress progress;
  progress.t = schedule.start;
  Observer nobody;
  evolve(stack.method(), schedule, s.state(), progress, nobody);
  return s;
}

/// The case with a fixed step, and with that many iterations for dcs.
Case with_step(Case c, double step, std::optional<int> iterations) {
  std::visit(
      [&](auto& m) {
        using M = std::decay_t<decltype(m)>;
        if constexpr (std::is_same_v<M, DcsOptions>) {
          m.tolerance.reset();
          m.step = step;
          if (iterations) m.iterations = *iterations;
          if (!m.iterations) m.iterations = m.max_iterations;
        } else if constexpr (std::is_same_v<M, SdcOptions>) {
          m.tolerance.reset();
          m.step = step;
          if (iterations) m.corrections = *iterations;
        } else if constexpr (requires { m.step; }) {
          m.step = step;
        } else {
          throw Error(ErrorKind::input,
                      fmt::format("{}: converge: the method \"{}\" chooses its own steps; an order study needs a method with "
                                  "a fixed step: lie, strang, dcs or sdc",
                                  c.file, method_name(c.method)));
        }
      },
      c.method);
  return c;
}

Case reference_case(const Case& c) {
  Case r = c;
  r.space.order = r.space.quadrature_order.value_or(r.space.order);  // what a hybrid converges to
  const ReferenceOptions& o = c.converge->reference;
  if (o.method == "sdc") {
    SdcOptions sdc;
    if (const auto* own = std::get_if<SdcOptions>(&c.method)) sdc = *own;
    sdc.tolerance.reset();
    sdc.step = o.step.value_or(0.0);
    r.method = sdc;
  } else {
    CvodeOptions cvode;
    cvode.relative_tolerance = o.tolerance.value_or(1e-12);
    cvode.absolute_tolerance = Tolerance{0.01 * cvode.relative_tolerance};
    const bool banded = c.grid.dimension() == 1 && c.boundary.sides[0][0].kind != BoundaryKind::periodic;
    cvode.linear_solver = banded ? LinearSolver::band : LinearSolver::gmres;
    r.method = cvode;
  }
  return r;
}

std::string describe(const ReferenceOptions& o) {
  if (!o.file.empty()) return "file " + o.file;
  if (o.method == "sdc") return fmt::format("sdc, step {:g}", o.step.value_or(0.0));
  return fmt::format("cvode, relative tolerance {:g}", o.tolerance.value_or(1e-12));
}

/// The reference state at a time, in a field of the shape of the problem's.
Solution reference_at(const Case& c, const ModelRegistry& models, const Communicator& comm, double end) {
  const ReferenceOptions& o = c.converge->reference;
  if (!o.file.empty()) {
    Solution s{std::make_unique<Problem>(c, models, comm)};
    const StateSource source = read_state(o.file, s.problem->model->description().species, s.state());
    if (std::abs(source.time - end) > 1e-12 * std::abs(end)) {
      throw Error(ErrorKind::input, fmt::format("{}: converge.reference.file: {} holds the time {:.17g}, but the study ends at {:.17g}",
                                                c.file, o.file, source.time, end));
    }
    return s;
  }
  Case r = reference_case(c);
  // The band solver works on one rank.
  if (auto* cvode = std::get_if<CvodeOptions>(&r.method); cvode != nullptr && comm.size() > 1) cvode->linear_solver = LinearSolver::gmres;
  return solve(r, models, comm, end);
}

void measure(const Field& u, const Solution& reference, ConvergenceRow& row) {
  const Problem& p = *reference.problem;
  const std::vector<std::string>& names = p.model->description().species;
  row.error = 0.0;
  for (int s = 0; s < p.model->n_species(); ++s) {
    const StateNorm norm(p.decomposition, p.boundary, p.model->n_species(), {s});
    Agreement a = norm.agreement(1);
    norm.add_difference(u, reference.state(), 0, a);
    norm.add_scale(reference.state(), a);
    p.comm.agree(a);
    const double e = norm.value(0, a);
    row.per_species.emplace_back(names[static_cast<std::size_t>(s)], e);
    row.error = std::isnan(e) ? e : std::max(row.error, e);
  }
}

/// What dcs itself would say of a step from the initial state: one entry for each number of corrections up to the largest asked for.
std::vector<DeferredCorrection::Estimate> own_estimates(const Case& c, const ModelRegistry& models, const Communicator& comm, double step) {
  if (!std::holds_alternative<DcsOptions>(c.method)) return {};
  const int most = *std::max_element(c.converge->iterations.begin(), c.converge->iterations.end());
  const Case with_most = with_step(c, step, most);
  Problem problem(with_most, models, comm);
  MethodStack stack(with_most, problem, MethodStack::Purpose::single_step);
  DeferredCorrection& method = *stack.deferred_correction();
  method.first_step(c.time.start, c.time.start + step, problem.state);
  return method.estimates(c.time.start, step, problem.state, most);
}

nlohmann::ordered_json number(double x) { return std::isfinite(x) ? nlohmann::ordered_json(x) : nlohmann::ordered_json("nan"); }

std::string to_json(const ConvergenceStudy& study) {
  nlohmann::ordered_json j;
  j["kind"] = study.kind;
  j["reference"] = study.reference;
  j["rows"] = nlohmann::ordered_json::array();
  for (const ConvergenceRow& row : study.rows) {
    nlohmann::ordered_json r;
    r["step"] = row.step;
    r["variant"] = row.variant;
    r["error"] = number(row.error);
    r["order"] = row.order ? number(*row.order) : nlohmann::ordered_json(nullptr);
    r["per_species"] = nlohmann::ordered_json::object();
    for (const auto& [name, error] : row.per_species) r["per_species"][name] = number(error);
    if (row.estimate) r["estimate"] = number(*row.estimate);
    if (row.step_limit) r["step_limit"] = number(*row.step_limit);
    if (!row.failure.empty()) r["failure"] = row.failure;
    j["rows"].push_back(std::move(r));
  }
  return j.dump(2) + "\n";
}

using Cells = std::map<std::pair<double, std::string>, const ConvergenceRow*>;

/// The method's own view, where it has one.
void print_estimates(const ConvergenceStudy& study, const std::vector<std::string>& variants, const std::vector<double>& steps,
                     const Cells& cells) {
  if (study.rows.empty() || !study.rows.front().estimate) return;
  fmt::print("\nestimates by the method, and the step from which on a correction improves nothing\n{:>12}", "step");
  for (const std::string& v : variants) fmt::print(" {:>12} {:>9}", v, "limit");
  fmt::print("\n");
  const auto text = [](double x, const char* format) { return std::isfinite(x) ? fmt::format(fmt::runtime(format), x) : std::string("-"); };
  for (double step : steps) {
    fmt::print("{:>12.4e}", step);
    for (const std::string& v : variants) {
      const ConvergenceRow& row = *cells.at({step, v});
      fmt::print(" {:>12} {:>9}", text(*row.estimate, "{:.4e}"), text(*row.step_limit, "{:.2e}"));
    }
    fmt::print("\n");
  }
}

void print_table(const ConvergenceStudy& study) {
  std::vector<std::string> variants;
  Cells cells;
  std::vector<double> steps;
  for (const ConvergenceRow& row : study.rows) {
    if (std::find(variants.begin(), variants.end(), row.variant) == variants.end()) variants.push_back(row.variant);
    if (std::find(steps.begin(), steps.end(), row.step) == steps.end()) steps.push_back(row.step);
    cells[{row.step, row.variant}] = &row;
  }
  fmt::print("{} errors; reference: {}\n{:>12}", study.kind, study.reference, "step");
  for (const std::string& v : variants) fmt::print(" {:>12} {:>6}", v, "order");
  fmt::print("\n");
  for (double step : steps) {
    fmt::print("{:>12.4e}", step);
    for (const std::string& v : variants) {
      const ConvergenceRow& row = *cells.at({step, v});
      fmt::print(" {:>12} {:>6}", std::isfinite(row.error) ? fmt::format("{:.4e}", row.error) : "failed",
                 row.order ? fmt::format("{:.2f}", *row.order) : "");
    }
    fmt::print("\n");
  }
  print_estimates(study, variants, steps, cells);
  std::fflush(stdout);
}

}  // namespace

ConvergenceStudy converge(const Case& c, const ModelRegistry& models, const Communicator& comm) {
  if (!c.converge) throw Error(ErrorKind::input, fmt::format("{}: [converge] is missing; give at least converge.steps", c.file));
  const bool local = c.converge->kind == ConvergenceKind::local;
  ConvergenceStudy study;
  study.kind = local ? "local" : "global";
  study.reference = describe(c.converge->reference);

  std::vector<std::optional<int>> variants;
  for (int k : c.converge->iterations) variants.emplace_back(k);
  if (variants.empty()) variants.emplace_back(std::nullopt);

  std::optional<Solution> reference;
  if (!local) reference = reference_at(c, models, comm, c.time.end);
  std::map<std::string, std::pair<double, double>> before;  // by variant: step and error of the row before
  for (double step : c.converge->steps) {
    const double end = local ? c.time.start + step : c.time.end;
    std::vector<DeferredCorrection::Estimate> estimates;
    if (local) {
      reference = reference_at(c, models, comm, end);
      estimates = own_estimates(c, models, comm, step);
    }
    for (const std::optional<int>& k : variants) {
      ConvergenceRow row;
      row.step = step;
      row.variant = k ? fmt::format("k={}", *k) : method_name(c.method);
      const Case variant = with_step(c, step, k);
      try {
        const Solution s = solve(variant, models, comm, end, local ? MethodStack::Purpose::single_step : MethodStack::Purpose::run);
        measure(s.state(), *reference, row);
      } catch (const Error& e) {
        if (e.kind() != ErrorKind::numerics) throw;
        row.error = std::numeric_limits<double>::quiet_NaN();
        row.failure = e.what();
      }
      if (!estimates.empty() && k) {
        row.estimate = estimates[static_cast<std::size_t>(*k)].error;
        row.step_limit = estimates[static_cast<std::size_t>(*k)].step_limit;
      }
      if (const auto it = before.find(row.variant); it != before.end() && it->second.second > 0.0 && row.error > 0.0) {
        row.order = std::log(row.error / it->second.second) / std::log(row.step / it->second.first);
      }
      before[row.variant] = {row.step, row.error};
      study.rows.push_back(std::move(row));
    }
  }
  return study;
}

void run_convergence(const Case& c, const ModelRegistry& models, const Communicator& comm, const RunOptions& options) {
  const ConvergenceStudy study = converge(c, models, comm);
  collectively(comm, [&] {
    if (!comm.is_root()) return;
    std::error_code status;
    std::filesystem::create_directories(c.output.directory, status);
    const std::filesystem::path path = std::filesystem::path(c.output.directory) / "converge.json";
    std::ofstream file(path);
    file << to_json(study);
    file.close();
    if (!file) throw Error(ErrorKind::io, fmt::format("{}: cannot be written", path.string()));
    if (!options.quiet) print_table(study);
  });
}

}  // namespace stiffront::app
