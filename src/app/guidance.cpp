// SPDX-License-Identifier: BSD-3-Clause
#include "guidance.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <map>
#include <span>

#include "stiffront/app/method_stack.hpp"
#include "stiffront/app/methods.hpp"
#include "stiffront/app/problem.hpp"
#include "stiffront/control/deferred_correction_control.hpp"
#include "stiffront/core/error.hpp"
#include "stiffront/core/timer.hpp"
#include "stiffront/model/expression.hpp"
#include "stiffront/model/reaction_modes.hpp"

namespace stiffront::app {
namespace {

constexpr double most_points_measured = 5e4;  // beyond, a part of the grid stands for all of it
constexpr std::int64_t most_cells_looked_at = 20000;
constexpr double seconds_to_measure = 1.0;

double total_points(const Case& c) {
  double n = 1.0;
  for (const std::int64_t p : c.grid.points) n *= static_cast<double>(p);
  return n;
}

std::string seconds_text(double s) {
  if (s < 1e-3) return fmt::format("{:.3g} us", 1e6 * s);
  if (s < 1.0) return fmt::format("{:.3g} ms", 1e3 * s);
  if (s < 120.0) return fmt::format("{:.3g} s", s);
  if (s < 7200.0) return fmt::format("{:.3g} min", s / 60.0);
  return fmt::format("{:.3g} h", s / 3600.0);
}

std::string memory_text(double mib) { return mib < 2000.0 ? fmt::format("{:.0f} MiB", mib) : fmt::format("{:.1f} GiB", mib / 1024.0); }

/// The case on one process, on fewer points of the same spacing if there are many.
Case sample_of(const Case& c) {
  Case sample = c;
  std::fill(sample.grid.processes.begin(), sample.grid.processes.end(), 0);
  const double factor = std::pow(std::min(1.0, most_points_measured / total_points(c)), 1.0 / c.grid.dimension());
  if (factor == 1.0 || !c.initial.file.empty()) return sample;
  for (std::size_t d = 0; d < sample.grid.points.size(); ++d) {
    const bool periodic = c.boundary.sides[d][0].kind == BoundaryKind::periodic;
    const auto intervals = [&](std::int64_t points) { return static_cast<double>(periodic ? points : points - 1); };
    const double spacing = (c.grid.upper[d] - c.grid.lower[d]) / intervals(c.grid.points[d]);
    sample.grid.points[d] = std::max(std::int64_t{16}, static_cast<std::int64_t>(factor * static_cast<double>(c.grid.points[d])));
    sample.grid.points[d] = std::min(sample.grid.points[d], c.grid.points[d]);
    sample.grid.upper[d] = sample.grid.lower[d] + spacing * intervals(sample.grid.points[d]);
  }
  return sample;
}

Stiffness stiffness_of(const Case& c, const Problem& problem) {
  Stiffness result;
  result.diffusion = problem.diffusion.spectral_radius();
  const Field& u = problem.state;
  const auto m = static_cast<std::size_t>(u.n_species());
  std::vector<double> cell(m);
  std::vector<double> rates(m);
  look_at_reaction_modes(*problem.model, c.time.start, u, {0, u.n_x(), 0, u.n_y()}, most_cells_looked_at,
                         [&](int i, int j, std::span<const std::complex<double>> modes) {
                           const double x = problem.grid.position(0, i);
                           const double y = problem.grid.dimension == 2 ? problem.grid.position(1, j) : 0.0;
                           for (std::size_t s = 0; s < m; ++s) cell[s] = u.at(static_cast<int>(s), i, j);
                           problem.model->rates_at(c.time.start, x, y, cell.data(), rates.data());
                           if (modes.empty() || !std::all_of(rates.begin(), rates.end(), [](double v) { return std::isfinite(v); })) {
                             result.finite = false;
                             result.at_x = x;
                             result.at_y = y;
                             return false;
                           }
                           for (const std::complex<double>& lambda : modes) {
                             if (std::abs(lambda) > result.reaction) {
                               result.reaction = std::abs(lambda);
                               result.at_x = x;
                               result.at_y = y;
                             }
                             result.growth = std::max(result.growth, lambda.real());
                             if (lambda.real() < 0.0) result.oscillation = std::max(result.oscillation, lambda.imag());
                           }
                           return true;
                         });
  return result;
}

/// A few attempts from the initial state.
struct Trial {
  double first_step = 0.0;
  double last_step = 0.0;  ///< accepted
  int accepted = 0;
  int rejected = 0;
  double seconds = std::numeric_limits<double>::infinity();  ///< of the fastest accepted attempt
  std::string failure;
};

Trial try_steps(const Case& c, Problem& problem, MethodStack& stack) {
  Trial trial;
  try {
    Method& method = stack.method();
    Field u_new = problem.state.similar();
    double t = c.time.start;
    double dt = method.first_step(t, c.time.end, problem.state);
    trial.first_step = dt;
    const double began = wall_seconds();
    while (trial.accepted + trial.rejected < 50 && wall_seconds() - began < seconds_to_measure && t < c.time.end && dt > 0.0) {
      const double step = std::min(dt, c.time.end - t);
      std::uint64_t flags = 0;
      const double before = wall_seconds();
      const Attempt a = method.attempt(t, step, problem.state, u_new, flags);
      if (a.accepted) {
        trial.seconds = std::min(trial.seconds, wall_seconds() - before);
        trial.last_step = a.dt_taken > 0.0 ? a.dt_taken : step;
        ++trial.accepted;
        method.accept(problem.state, u_new);
        t += trial.last_step;
      } else {
        ++trial.rejected;
        if (!a.reason.empty()) trial.failure = a.reason;
      }
      dt = a.dt_next;
    }
  } catch (const Error& e) {
    trial.failure = e.what();
  }
  return trial;
}

void describe_stiffness(const Case& c, const Problem& problem, const Stiffness& s, std::vector<std::string>& lines) {
  const double span = c.time.end - c.time.start;
  const std::string place =
      problem.grid.dimension == 1 ? fmt::format("x = {:.4g}", s.at_x) : fmt::format("x = {:.4g}, y = {:.4g}", s.at_x, s.at_y);
  if (!s.finite) {
    lines.push_back(fmt::format("warning: the rates or their derivatives are not finite in the initial state at {}", place));
    return;
  }
  if (s.diffusion > 0.0) {
    lines.push_back(fmt::format("diffusion: spectral radius {:.3g}; an explicit method would need {:.3g} steps or more", s.diffusion,
                                std::ceil(0.5 * span * s.diffusion)));
  }
  if (s.reaction > 0.0) {
    std::string text = fmt::format("reaction: largest eigenvalue {:.3g} in the initial state (at {}), time scale {:.3g}", s.reaction, place,
                                   1.0 / s.reaction);
    text += s.reaction * span > 1e4 ? "; stiff" : "; not stiff";
    lines.push_back(text);
  }
  if (s.growth > 0.0) {
    double widest = 0.0;
    for (int k = 0; k < problem.diffusion.n_species(); ++k) widest = std::max(widest, problem.diffusion.coefficient(k));
    const double front = std::sqrt(widest / s.growth);
    double h = problem.grid.spacing(0);
    if (problem.grid.dimension == 2) h = std::max(h, problem.grid.spacing(1));
    std::string text = fmt::format("fastest growth {:.3g} in the initial state", s.growth);
    if (widest > 0.0) text += fmt::format(": fronts are about {:.3g} wide or wider, {:.3g} grid spacings", front, front / h);
    lines.push_back(text);
    if (widest > 0.0 && front < h) {
      lines.push_back("warning: the grid may be too coarse for the fronts of this model; compare a run on twice the points");
    }
  }
}

template <class T>
const T* options_of(const Case& c) {
  return std::get_if<T>(&c.method);
}

void propose(const Case& c, const Stiffness& s, const Trial& trial, std::vector<std::string>& lines) {
  const double span = c.time.end - c.time.start;
  const double fastest = std::max(s.reaction, s.diffusion);
  if (options_of<AutoOptions>(c) == nullptr && options_of<SbdfOptions>(c) == nullptr) {
    lines.push_back("suggestion: method.name=auto with a tolerance is the fastest choice for all but studies of splitting");
  }
  const double* step = nullptr;
  if (const auto* o = options_of<LieOptions>(c)) step = &o->step;
  if (const auto* o = options_of<StrangOptions>(c)) step = &o->step;
  if (step != nullptr && s.growth > 0.0 && *step * s.growth > 0.1) {
    lines.push_back(
        fmt::format("suggestion: a fixed step of {:.2g} or less, a twentieth of the fastest growth time; {:.2g} is {:.2g} of it",
                    0.05 / s.growth, *step, *step * s.growth));
  }
  if (trial.first_step > 0.0 && trial.accepted > 2 && trial.rejected > trial.accepted) {
    lines.push_back(fmt::format("suggestion: method.initial_step={:.2g}; the one chosen now is rejected at first", trial.last_step));
  } else if (fastest * span > 0.0 && trial.first_step > 0.0 && step == nullptr) {
    lines.push_back(fmt::format("first step: {:.3g} chosen by the method{}", trial.first_step,
                                trial.accepted > 0 ? fmt::format("; {:.3g} after {} steps", trial.last_step, trial.accepted) : ""));
  }
}

/// A comparison in a rate whose sides vary with time.
bool jumps_in_time(const Case& c, const std::string& text) {
  std::vector<std::string> variables = c.model.species;
  variables.insert(variables.end(), {"t", "x", "y"});
  ExpressionGraph graph(variables);
  const ExpressionGraph::Node root = graph.parse(text, {c.model.parameters.begin(), c.model.parameters.end()});
  const int t = static_cast<int>(c.model.species.size());
  for (const ExpressionGraph::Node n : graph.reachable({root})) {
    const ExpressionGraph::NodeData& d = graph.data(n);
    const bool compares = d.operation >= Operation::less && d.operation <= Operation::not_equal;
    if (compares && (graph.depends_on(d.a, t) || graph.depends_on(d.b, t))) return true;
  }
  return false;
}

/// Whether the name stands in the text as a word.
bool mentions(const std::string& text, const std::string& name) {
  const auto is_part = [](char ch) { return std::isalnum(static_cast<unsigned char>(ch)) != 0 || ch == '_'; };
  for (std::size_t at = text.find(name); at != std::string::npos; at = text.find(name, at + 1)) {
    const std::size_t end = at + name.size();
    if ((at == 0 || !is_part(text[at - 1])) && (end == text.size() || !is_part(text[end]))) return true;
  }
  return false;
}

std::vector<std::string> expressions_of(const Case& c) {
  std::vector<std::string> texts;
  const auto add = [&texts](const Value& value) {
    if (const auto* text = std::get_if<std::string>(&value)) texts.push_back(*text);
  };
  for (const auto& [species, rate] : c.model.reaction) texts.push_back(rate);
  for (const ReactionOptions& r : c.model.reactions) {
    add(r.rate);
    if (r.reverse_rate) add(*r.reverse_rate);
  }
  return texts;
}

void question_custom_model(const Case& c, std::vector<std::string>& lines) {
  std::vector<std::string> texts = expressions_of(c);
  if (c.time.breakpoints.empty() && !(c.time.restart_step.period > 0.0) &&
      std::any_of(texts.begin(), texts.end(), [&c](const std::string& text) { return jumps_in_time(c, text); })) {
    lines.emplace_back("warning: a rate jumps in time; list the times of the jumps in time.breakpoints, or no step ends there");
  }
  const auto add = [&texts](const NamedList<Value>& values) {
    for (const auto& [name, value] : values) {
      if (const auto* text = std::get_if<std::string>(&value)) texts.push_back(*text);
    }
  };
  add(c.model.diffusion);
  add(c.initial.expressions);
  for (const auto& sides : c.boundary.sides) {
    for (const SideOptions& side : sides) add(side.values);
  }
  for (const auto& [name, value] : c.model.parameters) {
    const bool used = std::any_of(texts.begin(), texts.end(), [&, &n = name](const std::string& text) { return mentions(text, n); });
    if (!used) lines.push_back(fmt::format("warning: model.parameters.{}: no expression uses it", name));
  }
}

void question_absolute_tolerance(const Case& c, const Problem& problem, double relative, const std::optional<Tolerance>& absolute,
                                 std::vector<std::string>& lines) {
  for (std::size_t s = 0; s < c.model.species.size(); ++s) {
    double a = 0.01 * relative;
    if (absolute) {
      a = std::holds_alternative<double>(*absolute) ? std::get<double>(*absolute) : std::get<NamedList<double>>(*absolute)[s].second;
    }
    if (a < problem.scales()[s]) continue;
    lines.push_back(
        fmt::format("warning: method.absolute_tolerance: {} = {:.2g} is not below the largest {} of the initial state, {:.2g}: its error "
                    "is not controlled unless it grows",
                    c.model.species[s], a, c.model.species[s], problem.scales()[s]));
  }
}

}  // namespace

double estimated_memory_mib(const Case& c) {
  // Fields of the state's size a method holds at its peak, measured on one rank, the writing of results included.
  struct {
    double operator()(const LieOptions&) const { return 10.0; }
    double operator()(const StrangOptions&) const { return 10.0; }
    double operator()(const AdaptiveStrangOptions&) const { return 17.5; }
    double operator()(const DcsOptions& o) const { return 8.0 + 4.0 * o.stages; }
    double operator()(const SdcOptions& o) const {
      if (o.splitting == SdcSplitting::diagonal) return 10.0 + 2.0 * o.node_count;
      const bool multigrid = in_plane && o.implicit_solver != SdcSolver::cell_local;
      return 11.0 + 4.0 * o.node_count + (multigrid ? 16.0 + 2.7 * species : 0.0);
    }
    double operator()(const SbdfOptions&) const { return sbdf(); }
    double operator()(const AutoOptions&) const { return sbdf(); }
    /// The coarser grids are made when diffusion is much stiffer than the rest only, which is not known before.
    double sbdf() const { return 17.0 + (in_plane ? 2.0 + 0.67 * species : 0.0); }
    double operator()(const CvodeOptions& o) const {
      if (o.linear_solver != LinearSolver::band) return 44.0;
      return 23.0 + 6.0 * species * width;  // two matrices, one of them with room for fill-in
    }
    double species = 0.0;
    double width = 0.0;
    bool in_plane = false;
  } fields;
  fields.in_plane = c.grid.dimension() == 2;
  fields.species = static_cast<double>(c.model.species.size());
  fields.width = c.space.order / 2.0;
  const double count = std::visit(fields, c.method);
  constexpr double program = 28.0;
  return program + count * total_points(c) * static_cast<double>(c.model.species.size()) * sizeof(double) / 1048576.0;
}

std::vector<std::string> questionable(const Case& c) {
  std::vector<std::string> lines;
  if (c.model.is_custom()) question_custom_model(c, lines);
  const bool splits =
      options_of<LieOptions>(c) != nullptr || options_of<StrangOptions>(c) != nullptr || options_of<AdaptiveStrangOptions>(c) != nullptr;
  if (options_of<LieOptions>(c) != nullptr || options_of<StrangOptions>(c) != nullptr) {
    lines.push_back(fmt::format("warning: {} with a fixed step controls no error; measure it with stiffront converge, or half the step",
                                method_name(c.method)));
  }
  if (const auto* o = options_of<DcsOptions>(c); o != nullptr && o->step) {
    lines.emplace_back("warning: dcs with a fixed step controls no error; give method.tolerance, or measure it with stiffront converge");
  }
  if (const auto* o = options_of<DcsOptions>(c); o != nullptr && o->tolerance) {
    if (*o->tolerance > 0.05)
      lines.emplace_back("warning: method.tolerance: above 0.05 the estimate is outside the range it is derived for");
    if (*o->tolerance < DeferredCorrectionControl::least_tolerance) {
      lines.push_back(
          fmt::format("warning: method.tolerance: below {:.0e} the differences it is compared with are rounding errors; that much is met",
                      DeferredCorrectionControl::least_tolerance));
    }
  }
  if (splits && c.boundary.has_dirichlet()) {
    lines.emplace_back("warning: a splitting loses an order next to a side of given values; sbdf, dcs and cvode do not");
  }
  if (const auto* o = options_of<AdaptiveStrangOptions>(c)) {
    if (!o->critical_step) {
      lines.emplace_back(
          "warning: method.critical_step=false: in stiff problems the error estimate means nothing above the critical step, and "
          "nothing keeps the steps below it");
    }
    if (o->species.size() < c.model.species.size()) {
      std::vector<std::string> others;
      for (const std::string& s : c.model.species) {
        if (std::find(o->species.begin(), o->species.end(), s) == o->species.end()) others.push_back(s);
      }
      lines.push_back(fmt::format("warning: method.species: the error of {} is not controlled", fmt::join(others, ", ")));
    }
    if (o->tolerance > 0.05)
      lines.emplace_back("warning: method.tolerance: above 0.05 the estimate is outside the range it is derived for");
  }
  if (const auto* o = options_of<CvodeOptions>(c); o != nullptr && o->linear_solver == LinearSolver::band && c.grid.dimension() == 2) {
    lines.emplace_back("warning: method.linear_solver=band: in two dimensions gmres is faster");
  }
  return lines;
}

std::vector<std::string> guidance(const Case& c, const ModelRegistry& models, const Communicator& self) {
  std::vector<std::string> lines;
  std::string points = fmt::format("{}", c.grid.points[0]);
  if (c.grid.dimension() == 2) points += fmt::format(" x {}", c.grid.points[1]);
  const double unknowns = total_points(c) * static_cast<double>(c.model.species.size());
  lines.push_back(fmt::format("{} points x {} species = {:.4g} unknowns; about {} of memory", points, c.model.species.size(), unknowns,
                              memory_text(estimated_memory_mib(c))));

  const Case sample = sample_of(c);
  const double share = total_points(c) / total_points(sample);
  if (total_points(sample) > 4.0 * most_points_measured) {
    lines.emplace_back("the initial state is a large file: nothing was measured");
  } else {
    Problem problem(sample, models, self);
    const Stiffness stiffness = stiffness_of(sample, problem);
    describe_stiffness(sample, problem, stiffness, lines);
    MethodStack stack(sample, problem);
    if (!stack.choice().empty()) lines.push_back(stack.choice());
    if (stiffness.finite) {
      if (const auto* o = options_of<SbdfOptions>(c))
        question_absolute_tolerance(c, problem, o->relative_tolerance, o->absolute_tolerance, lines);
      if (const auto* o = options_of<CvodeOptions>(c))
        question_absolute_tolerance(c, problem, o->relative_tolerance, o->absolute_tolerance, lines);
      const Trial trial = try_steps(sample, problem, stack);
      if (trial.accepted > 0) {
        lines.push_back(fmt::format("a step takes about {} on one process{}", seconds_text(share * trial.seconds),
                                    share > 1.0 ? ", scaled up from a part of the grid" : ""));
      }
      if (trial.accepted == 0) {
        lines.push_back(
            fmt::format("warning: no step from the initial state was accepted{}{}", trial.failure.empty() ? "" : ": ", trial.failure));
      }
      propose(sample, stiffness, trial, lines);
    }
  }
  const std::vector<std::string> questions = questionable(c);
  lines.insert(lines.end(), questions.begin(), questions.end());
  return lines;
}

}  // namespace stiffront::app
