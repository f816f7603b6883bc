// SPDX-License-Identifier: BSD-3-Clause
#include "case_rules.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <optional>

#include "custom_model_of.hpp"
#include "schema.hpp"
#include "sdc_defaults.hpp"
#include "stiffront/app/methods.hpp"
#include "stiffront/control/adaptive_strang.hpp"
#include "stiffront/core/entry_error.hpp"
#include "stiffront/core/spelling.hpp"
#include "stiffront/model/expression.hpp"
#include "stiffront/solvers/node_sweep.hpp"
#include "toml_text.hpp"

namespace stiffront::app {
namespace {

bool contains(const std::vector<std::string>& list, const std::string& word) {
  return std::find(list.begin(), list.end(), word) != list.end();
}

template <typename T>
const T* find_entry(const NamedList<T>& list, const std::string& name) {
  const auto entry = std::find_if(list.begin(), list.end(), [&name](const auto& e) { return e.first == name; });
  return entry == list.end() ? nullptr : &entry->second;
}

/// Names an expression gives a meaning of its own, and words the tables of species have for themselves.
bool is_reserved(const std::string& name) {
  static const std::vector<std::string> reserved = {"t",    "x",    "y",    "z",     "pi",        "e",    "if",      "min",  "max",  "abs",
                                                    "sqrt", "exp",  "log",  "log10", "sin",       "cos",  "tan",     "asin", "acos", "atan",
                                                    "sinh", "cosh", "tanh", "pow",   "arrhenius", "type", "profile", "file"};
  return contains(reserved, name);
}

bool is_identifier(const std::string& name) {
  const auto is_letter = [](char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '_'; };
  const auto is_part = [&](char c) { return is_letter(c) || std::isdigit(static_cast<unsigned char>(c)) != 0; };
  return !name.empty() && is_letter(name[0]) && std::all_of(name.begin(), name.end(), is_part);
}

constexpr double most_cells = 1e13;
constexpr double most_intervals = 1e9;  // in a time span, of outputs or periods

class Completion {
 public:
  Completion(Case& c, const CaseTree& tree, const std::vector<ModelDescription>& models) : c_(c), tree_(tree), models_(models) {}

  void run() {
    required_keys();
    space_and_grid();
    model();
    boundary();
    initial();
    time();
    transport();  // before the method's own rules: what they ask for would not help
    std::visit([this](auto& options) { method(options); }, c_.method);
    textbook_solvers();
    output();
    if (c_.converge) converge(*c_.converge);
  }

 private:
  [[noreturn]] void fail(const std::string& path, const std::string& message) const { tree_.fail(path, message); }
  [[noreturn]] void expected(const std::string& path, const std::string& what) const {
    fail(path, fmt::format("expected {}, got {}", what, tree_.text(path)));
  }

  double span() const { return c_.time.end - c_.time.start; }

  void required_keys() const {
    for (const Key& key : schema()) {
      if (!key.required || !applies(key, method_name(c_.method)) || tree_.has(key.path)) continue;
      if (c_.converge ? key.path == "method.step" : key.section() == "converge") continue;
      fail(key.path, fmt::format("missing: {} ({})", key.expected, key.doc));
    }
  }

  // [space] and [grid]

  template <typename T>
  void one_for_each_direction(const std::string& path, std::vector<T>& list, T value) const {
    if (list.empty()) list.assign(c_.grid.points.size(), value);
    if (list.size() != c_.grid.points.size()) {
      expected(path, fmt::format("as many entries as grid.points has, {}", c_.grid.points.size()));
    }
  }

  void space_and_grid() {
    SpaceOptions& space = c_.space;
    if (!space.quadrature_order) space.quadrature_order = space.order;
    GridOptions& grid = c_.grid;
    if (grid.points.size() > 2) expected("grid.points", "one or two integers, the points in each direction");
    one_for_each_direction("grid.lower", grid.lower, 0.0);
    one_for_each_direction("grid.upper", grid.upper, 1.0);
    one_for_each_direction("grid.processes", grid.processes, std::int64_t{0});
    const int order = std::max(space.order, *space.quadrature_order);
    if (order == 8 && space.order != *space.quadrature_order && c_.boundary.has_dirichlet()) {
      fail("space.quadrature_order", "order 8 next to a side of given values has a grid of its own; use the same order for both");
    }
    double cells = 1.0;
    for (std::size_t d = 0; d < grid.points.size(); ++d) {
      cells *= static_cast<double>(grid.points[d]);
      if (grid.points[d] < fewest_points(order, c_.boundary.has_dirichlet())) {
        fail(fmt::format("grid.points[{}]", d), fmt::format("expected at least {} points for differences of order {}, got {}",
                                                            fewest_points(order, c_.boundary.has_dirichlet()), order, grid.points[d]));
      }
      if (!(grid.upper[d] > grid.lower[d]) || !std::isfinite(grid.upper[d] - grid.lower[d])) {
        fail(tree_.has("grid.upper") ? fmt::format("grid.upper[{}]", d) : fmt::format("grid.lower[{}]", d),
             fmt::format("expected grid.lower below grid.upper, got {} and {}", toml_text(grid.lower[d]), toml_text(grid.upper[d])));
      }
      if (grid.processes[d] > grid.points[d]) {
        fail(fmt::format("grid.processes[{}]", d),
             fmt::format("expected at most one process for each of {} points, got {}", grid.points[d], grid.processes[d]));
      }
    }
    if (cells > most_cells) {
      fail("grid.points", fmt::format("expected at most {} points altogether, got {}", most_cells, cells));
    }
  }

  // [model]

  void check_species(const std::string& path, const std::string& name) const {
    if (contains(c_.model.species, name)) return;
    fail(path, "unknown species" + with_allowed(suggestion(name, c_.model.species), " for model " + c_.model.name, c_.model.species));
  }

  template <typename T>
  void check_species_names(const std::string& path, const NamedList<T>& list) const {
    for (const auto& entry : list) check_species(path + "." + entry.first, entry.first);
  }

  /// One entry for each species, in the model's order.
  template <typename T, typename Default>
  void in_order_of_species(NamedList<T>& list, Default default_of) const {
    NamedList<T> complete;
    for (std::size_t s = 0; s < c_.model.species.size(); ++s) {
      const T* given = find_entry(list, c_.model.species[s]);
      complete.emplace_back(c_.model.species[s], given != nullptr ? *given : default_of(s));
    }
    list = std::move(complete);
  }

  template <typename T>
  void require_all_species(const std::string& path, const NamedList<T>& list, const std::string& what) const {
    std::vector<std::string> missing;
    for (const std::string& species : c_.model.species) {
      if (find_entry(list, species) == nullptr) missing.push_back(species);
    }
    if (!missing.empty()) fail(path, fmt::format("no {} for {}; every species needs one", what, comma_list(missing)));
  }

  void model() {
    ModelOptions& model = c_.model;
    if (model.is_custom()) {
      custom_model();
    } else {
      registered_model();
    }
    check_species_names("model.diffusion", model.diffusion);
    units();
    diffusion_coefficients();
    in_order_of_species(model.diffusion,
                        [this](std::size_t s) { return Value(description_ == nullptr ? 0.0 : description_->diffusion[s]); });
    if (model.is_custom()) compile_custom_model();
  }

  void units() const {
    std::vector<std::string> allowed{"x", "t"};
    allowed.insert(allowed.end(), c_.model.species.begin(), c_.model.species.end());
    for (const auto& [name, unit] : c_.model.units) {
      if (!contains(allowed, name)) {
        fail("model.units." + name, "unknown quantity" + with_allowed(suggestion(name, allowed), " for model " + c_.model.name, allowed));
      }
    }
  }

  /// The value must be an expression of these variables and the parameters.
  /// @return its value if it is constant
  std::optional<double> check_expression(const std::string& path, const Value& value, std::vector<std::string> variables) const {
    if (const double* number = std::get_if<double>(&value)) return *number;
    const std::map<std::string, double> constants(c_.model.parameters.begin(), c_.model.parameters.end());
    ExpressionGraph graph(std::move(variables));
    try {
      const ExpressionGraph::Node node = graph.parse(std::get<std::string>(value), constants);
      return graph.is_constant(node) ? std::optional(graph.data(node).value) : std::nullopt;
    } catch (const Error& error) {
      fail(path, error.what());
    }
  }

  void diffusion_coefficients() const {
    for (const auto& [species, value] : c_.model.diffusion) {
      const std::string path = "model.diffusion." + species;
      const std::optional<double> coefficient = check_expression(path, value, {});
      if (!(coefficient.value_or(-1.0) >= 0.0)) {
        fail(path, fmt::format("expected a number not below 0, got {} = {}", tree_.text(path), coefficient.value_or(-1.0)));
      }
    }
  }

  void compile_custom_model() const {
    try {
      make_custom_model(custom_model_of(c_.model));
    } catch (const EntryError& error) {
      fail(error.key(), error.detail());
    } catch (const Error& error) {
      fail("model", error.what());
    }
  }

  void registered_model() {
    ModelOptions& model = c_.model;
    std::vector<std::string> allowed;
    for (const ModelDescription& m : models_) {
      allowed.push_back(m.name);
      if (m.name == model.name) description_ = &m;
    }
    allowed.emplace_back("custom");
    if (description_ == nullptr) {
      fail("model.name", "unknown model " + tree_.text("model.name") + with_allowed(suggestion(model.name, allowed), "", allowed));
    }
    for (const char* key : {"model.species", "model.reaction", "model.reactions"}) {
      if (tree_.has(key)) fail(key, "only for model.name = \"custom\"");
    }
    model.species = description_->species;
    std::vector<std::string> names;
    for (const auto& parameter : description_->parameters) names.push_back(parameter.name);
    for (const auto& [name, value] : model.parameters) {
      if (contains(names, name)) continue;
      fail("model.parameters." + name, "unknown parameter" + with_allowed(suggestion(name, names), " for model " + model.name, names));
    }
    NamedList<double> parameters;
    for (const auto& [name, value] : description_->parameters) {
      const double* given = find_entry(model.parameters, name);
      parameters.emplace_back(name, given != nullptr ? *given : value);
    }
    model.parameters = std::move(parameters);
  }

  void check_new_name(const std::string& path, const std::string& name) const {
    if (!is_identifier(name)) {
      fail(path, fmt::format("{} is no name: letters, digits and _, not beginning with a digit", toml_text(name)));
    }
    if (is_reserved(name)) fail(path, fmt::format("the name {} is taken; choose another one", name));
  }

  void custom_model() {
    ModelOptions& model = c_.model;
    if (model.species.empty()) {
      fail("model.species", "missing: a custom model needs the names of its species, as in species = [\"u\", \"v\"]");
    }
    for (std::size_t s = 0; s < model.species.size(); ++s) {
      const std::string path = fmt::format("model.species[{}]", s);
      check_new_name(path, model.species[s]);
      const auto here = model.species.begin() + static_cast<std::ptrdiff_t>(s);
      if (std::find(model.species.begin(), here, model.species[s]) != here) {
        fail(path, fmt::format("species {} is there twice", model.species[s]));
      }
    }
    for (const auto& [name, value] : model.parameters) {
      const std::string path = "model.parameters." + name;
      check_new_name(path, name);
      if (contains(model.species, name)) fail(path, fmt::format("{} is a species already", name));
    }
    if (model.reaction.empty() && model.reactions.empty()) {
      fail("model.reaction", "missing: [model.reaction] with an expression for each species, or [[model.reactions]], a reaction network");
    }
    check_species_names("model.reaction", model.reaction);
    if (model.reactions.empty()) {
      require_all_species("model.reaction", model.reaction, "expression");
      in_order_of_species(model.reaction, [](std::size_t) { return std::string(); });
    }
  }

  // [boundary]

  void boundary() {
    for (std::size_t d = 0; d < c_.boundary.sides.size(); ++d) {
      const std::string both = fmt::format("boundary.{}", "xyz"[d]);
      const std::array<std::string, 2> side_names = {both + "_lower", both + "_upper"};
      if (d >= c_.grid.points.size()) {
        for (const std::string& path : {both, side_names[0], side_names[1]}) {
          if (tree_.has(path)) fail(path, "the grid has no such direction: grid.points has one entry");
        }
        continue;
      }
      auto& sides = c_.boundary.sides[d];
      if ((sides[0].kind == BoundaryKind::periodic) != (sides[1].kind == BoundaryKind::periodic)) {
        const std::string& path = tree_.has(side_names[0]) ? side_names[0] : side_names[1];
        fail(path, fmt::format("periodic on one side only; write {} = \"periodic\" for both", both));
      }
      for (std::size_t s = 0; s < 2; ++s) boundary_values(sides[s], tree_.has(side_names[s]) ? side_names[s] : both);
    }
  }

  void boundary_values(SideOptions& side, const std::string& path) const {
    if (side.kind != BoundaryKind::dirichlet) {
      if (side.values.empty()) return;
      fail(path + "." + side.values[0].first, "values go with type = \"dirichlet\" only");
    }
    check_species_names(path, side.values);
    for (const auto& [species, value] : side.values) check_expression(path + "." + species, value, {"t", "x", "y"});
    in_order_of_species(side.values, [](std::size_t) { return Value(0.0); });
  }

  // [initial]

  void initial() {
    InitialOptions& initial = c_.initial;
    for (const auto& [name, value] : initial.expressions) {
      if (contains(c_.model.species, name)) continue;
      std::vector<std::string> allowed = {"profile", "file"};
      allowed.insert(allowed.end(), c_.model.species.begin(), c_.model.species.end());
      fail("initial." + name, "unknown key" + with_allowed(suggestion(name, allowed), " in [initial]", allowed));
    }
    const int given = (initial.profile.empty() ? 0 : 1) + (initial.expressions.empty() ? 0 : 1) + (initial.file.empty() ? 0 : 1);
    if (given != 1) {
      fail("initial",
           fmt::format("{}: profile, or an expression for each species, or file", given == 0 ? "missing: one of" : "expected only one of"));
    }
    if (!initial.profile.empty()) initial_profile();
    if (!initial.expressions.empty()) {
      require_all_species("initial", initial.expressions, "initial value");
      for (const auto& [species, value] : initial.expressions) check_expression("initial." + species, value, {"x", "y"});
      in_order_of_species(initial.expressions, [](std::size_t) { return Value(0.0); });
    }
  }

  void initial_profile() const {
    const std::string& name = c_.initial.profile;
    std::vector<std::string> allowed;
    if (description_ != nullptr) {
      for (const auto& profile : description_->profiles) {
        allowed.push_back(profile.name);
        if (profile.name == name && profile.dimension > c_.grid.dimension()) {
          fail("initial.profile",
               fmt::format("\"{}\" needs a grid of {} dimensions, this one has {}", name, profile.dimension, c_.grid.dimension()));
        }
      }
    }
    if (allowed.empty()) {
      fail("initial.profile", fmt::format("model {} has no profiles; give an expression for each species", c_.model.name));
    }
    if (!contains(allowed, name)) {
      fail("initial.profile", "unknown profile " + tree_.text("initial.profile") +
                                  with_allowed(suggestion(name, allowed), " for model " + c_.model.name, allowed));
    }
  }

  // [time]

  void check_increasing(const std::string& path, const std::vector<double>& times, bool ends_included) const {
    double before = c_.time.start;
    for (std::size_t i = 0; i < times.size(); ++i) {
      const bool after_start = i == 0 && ends_included ? times[i] >= before : times[i] > before;
      const bool before_end = ends_included ? times[i] <= c_.time.end : times[i] < c_.time.end;
      if (!after_start || !before_end) {
        const std::string start = toml_text(c_.time.start);
        const std::string end = toml_text(c_.time.end);
        expected(fmt::format("{}[{}]", path, i), ends_included ? fmt::format("increasing times from {} to {}", start, end)
                                                               : fmt::format("increasing times between {} and {}", start, end));
      }
      before = times[i];
    }
  }

  void check_interval(const std::string& path, double interval) const {
    if (interval > 0.0 && span() / interval > most_intervals) {
      expected(path, fmt::format("a number not below {}, a billionth of the time span", toml_text(span() / most_intervals)));
    }
  }

  void time() const {
    const TimeOptions& time = c_.time;
    if (!(time.end > time.start) || !std::isfinite(span())) {
      expected("time.end", fmt::format("a time after time.start = {}", toml_text(time.start)));
    }
    check_increasing("time.breakpoints", time.breakpoints, false);
    const auto& restart = time.restart_step;
    if ((restart.period > 0.0) != (restart.step > 0.0)) {
      fail("time.restart_step", "period and step are both positive or both 0");
    }
    if (restart.step > restart.period) {
      expected("time.restart_step.step", fmt::format("a number not above the period {}", toml_text(restart.period)));
    }
    check_interval("time.restart_step.period", restart.period);
  }

  // [method]

  void complete_step(double& step) const {
    if (step == 0.0 && c_.converge) step = c_.converge->steps.front();
  }

  void method(LieOptions& o) const { complete_step(o.step); }
  void method(StrangOptions& o) const { complete_step(o.step); }
  void method(AutoOptions&) const {}

  void method(AdaptiveStrangOptions& o) const {
    if (o.epsilon > o.epsilon_max) {
      expected(tree_.has("method.epsilon") ? "method.epsilon" : "method.epsilon_max",
               fmt::format("epsilon not above epsilon_max = {}", toml_text(o.epsilon_max)));
    }
    if (!(o.beta < o.gamma)) {
      expected(tree_.has("method.beta") ? "method.beta" : "method.gamma", fmt::format("beta below gamma = {}", toml_text(o.gamma)));
    }
    for (std::size_t i = 0; i < o.species.size(); ++i) check_species(fmt::format("method.species[{}]", i), o.species[i]);
    if (o.species.empty()) o.species = c_.model.species;
    if (!o.final_error) o.final_error = default_final_error(o.tolerance);
  }

  void method(DcsOptions& o) const {
    if (c_.converge && !o.tolerance && !o.step) o.step = c_.converge->steps.front();
    if (o.tolerance.has_value() == o.step.has_value()) {
      fail(o.step ? "method.step" : "method", fmt::format("{}: method.tolerance for adaptive steps, or method.step for fixed ones",
                                                          o.step ? "expected only one of" : "missing: one of"));
    }
    if (o.iterations && !o.step) fail("method.iterations", "goes with method.step, not with method.tolerance");
    const int to_full_order = std::max(1, 2 * o.stages - 1 - (o.splitting == Splitting::lie ? 1 : 2));
    if (!o.max_iterations) o.max_iterations = std::max(to_full_order, o.iterations.value_or(0));
    if (o.step && !o.iterations) o.iterations = o.max_iterations;
    if (o.iterations && *o.iterations > *o.max_iterations) {
      expected("method.iterations", fmt::format("an integer not above max_iterations = {}", *o.max_iterations));
    }
  }

  void method(SdcOptions& o) const {
    negative_states_are_reported();
    if (c_.converge && !o.tolerance && !o.step) o.step = c_.converge->steps.front();
    if (o.tolerance.has_value() == o.step.has_value()) {
      fail(o.step ? "method.step" : "method", fmt::format("{}: method.tolerance for adaptive steps, or method.step for fixed ones",
                                                          o.step ? "expected only one of" : "missing: one of"));
    }
    const bool lobatto = o.nodes == NodeFamily::gauss_lobatto;
    if (o.starting_order && *o.starting_order > o.node_count - (lobatto ? 1 : 0)) {
      expected("method.starting_order", fmt::format("an integer {} node_count = {}", lobatto ? "below" : "up to", o.node_count));
    }
    if (o.gamma_advection != 0.0) {
      if (!has_transport()) fail("method.gamma_advection", "expected 0: the model has no first derivatives");
      if (o.implicit_solver == SdcSolver::cell_local) fail("method.gamma_advection", "expected 0 with implicit_solver = \"cell-local\"");
      if (o.splitting == SdcSplitting::imex && o.implicit == SdcImplicit::reaction) {
        fail("method.gamma_advection", "expected 0 with splitting = \"imex\" and implicit = \"reaction\"");
      }
    }
    if (composes_flows(o)) {
      if (has_transport()) {
        fail("method.splitting", fmt::format("expected \"preconditioned\" or \"imex\": the model {} has first derivatives", c_.model.name));
      }
      const int order = o.splitting == SdcSplitting::lie ? 1 : 2;
      if (o.starting_order && *o.starting_order != order) {
        expected("method.starting_order", fmt::format("{}, the order of the splitting, or nothing", order));
      }
      if (!o.consistent) fail("method.consistent", "false goes with splitting = \"preconditioned\" or \"imex\" only");
      if (o.correction == SdcCorrection::alternative) {
        fail("method.correction", "\"alternative\" goes with splitting = \"preconditioned\" or \"imex\" only");
      }
      if (o.implicit_solver != SdcSolver::automatic) {
        fail("method.implicit_solver", "goes with splitting = \"preconditioned\" or \"imex\" only");
      }
    }
    if (o.splitting == SdcSplitting::diagonal) diagonal_splitting(o);
    complete_sdc(o, c_.space.order);
    if (o.final_update == SdcFinalUpdate::last_node && o.nodes == NodeFamily::gauss_legendre) {
      expected("method.final_update",
               "\"auto\", \"quadrature\" or \"extrapolation\" with Legendre nodes, whose last one is not the end of the step");
    }
    if (o.correction == SdcCorrection::alternative && (*o.starting_order != 1 || !o.consistent || o.acceleration || o.tolerance)) {
      fail("method.correction",
           "the alternative form converges to the collocation solution only where the starting method is the correction method; it needs "
           "starting_order = 1, consistent = true, a fixed step and no acceleration");
    }
    if (o.implicit_solver == SdcSolver::block_tridiagonal && c_.grid.points.size() > 1) {
      expected("method.implicit_solver", "\"auto\", \"multigrid\" or \"cell-local\" in two dimensions");
    }
    if (o.implicit_solver == SdcSolver::multigrid && c_.grid.points.size() == 1) {
      expected("method.implicit_solver", "\"auto\", \"block-tridiagonal\" or \"cell-local\" in one dimension");
    }
  }

  void diagonal_splitting(const SdcOptions& o) const {
    if (has_transport()) {
      fail("method.splitting", fmt::format("expected \"preconditioned\" or \"imex\": the model {} has first derivatives", c_.model.name));
    }
    if (c_.space.order == 8) expected("space.order", "2 or 4 with splitting = \"diagonal\"");
    if (o.nodes != NodeFamily::gauss_radau) expected("method.nodes", "\"gauss-radau\" with splitting = \"diagonal\"");
    if (o.node_count > max_parallel_nodes) {
      expected("method.node_count", fmt::format("an integer up to {} with splitting = \"diagonal\"", max_parallel_nodes));
    }
    if (!o.consistent) fail("method.consistent", "does not go with splitting = \"diagonal\", whose sweeps have no explicit part");
    if (o.acceleration) fail("method.acceleration", "does not go with splitting = \"diagonal\"");
    if (o.correction != SdcCorrection::standard) expected("method.correction", "\"standard\" with splitting = \"diagonal\"");
    if (o.final_update != SdcFinalUpdate::automatic && o.final_update != SdcFinalUpdate::last_node) {
      expected("method.final_update", "\"auto\" or \"last-node\" with splitting = \"diagonal\"");
    }
    if (o.implicit_solver != SdcSolver::automatic && o.implicit_solver != SdcSolver::cell_local) {
      expected("method.implicit_solver", "\"auto\" or \"cell-local\" with splitting = \"diagonal\"");
    }
    if (o.tolerance && o.corrections && *o.corrections < 1) {
      expected("method.corrections", "1 at least with splitting = \"diagonal\" and tolerance");
    }
  }

  bool has_transport() const { return description_ != nullptr && description_->has_transport; }

  template <typename... Options>
  bool method_is() const {
    return (std::holds_alternative<Options>(c_.method) || ...);
  }

  void transport() const {
    if (!has_transport()) return;
    if (c_.grid.points.size() != 1) fail("model.name", fmt::format("the model {} is for one dimension", c_.model.name));
    const bool splits = method_is<LieOptions, StrangOptions>();
    if (method_is<SdcOptions, CvodeOptions, AutoOptions>() || (splits && c_.diffusion_solver.name == DiffusionSolver::crank_nicolson))
      return;
    fail(splits ? "diffusion_solver.name" : "method.name",
         fmt::format("the model {} has first derivatives, for which there are the methods sdc, cvode and auto, and lie and strang with "
                     "diffusion_solver.name = \"crank-nicolson\"",
                     c_.model.name));
  }

  void textbook_solvers() const {
    const bool splits = method_is<LieOptions, StrangOptions>();
    if (c_.diffusion_solver.name == DiffusionSolver::crank_nicolson) {
      if (!splits)
        fail("diffusion_solver.name",
             fmt::format("\"crank-nicolson\" goes with methods lie and strang, not with {}", method_name(c_.method)));
      if (c_.grid.points.size() != 1) fail("diffusion_solver.name", "\"crank-nicolson\" is for one dimension");
    }
    if (c_.reaction_solver.name == ReactionSolver::trapezoidal && !splits) {
      fail("reaction_solver.name", fmt::format("\"trapezoidal\" goes with methods lie and strang, not with {}", method_name(c_.method)));
    }
  }

  /// For methods that cannot try a step again because of a negative value.
  void negative_states_are_reported() const {
    if (c_.reaction_solver.positivity != Positivity::reject_step) return;
    fail("reaction_solver.positivity",
         fmt::format("\"reject-step\" does not go with method \"{}\"; use \"report\"", method_name(c_.method)));
  }

  void complete_tolerance(std::optional<Tolerance>& absolute, double relative) const {
    if (!absolute) absolute = relative / 100.0;
    if (auto* each = std::get_if<NamedList<double>>(&*absolute)) {
      check_species_names("method.absolute_tolerance", *each);
      require_all_species("method.absolute_tolerance", *each, "tolerance");
      in_order_of_species(*each, [](std::size_t) { return 0.0; });
    }
  }

  void method(SbdfOptions& o) const {
    if (c_.space.order == 8) expected("space.order", "2 or 4 with method \"sbdf\"; order 8 goes with cvode, sdc, dcs and the splittings");
    complete_tolerance(o.absolute_tolerance, o.relative_tolerance);
  }

  void method(CvodeOptions& o) const {
    complete_tolerance(o.absolute_tolerance, o.relative_tolerance);
    if (!o.linear_solver) o.linear_solver = LinearSolver::gmres;
    negative_states_are_reported();
  }

  // [output]

  void output() const {
    const OutputOptions& output = c_.output;
    const int given = (output.times.empty() ? 0 : 1) + (output.every > 0.0 ? 1 : 0) + (output.steps > 0 ? 1 : 0);
    if (given > 1) fail(output.steps > 0 ? "output.steps" : "output.every", "expected only one of times, every and steps");
    check_increasing("output.times", output.times, true);
    check_interval("output.every", output.every);
    for (std::size_t i = 0; i < output.probes.size(); ++i) {
      const std::vector<double>& point = output.probes[i];
      const std::string path = fmt::format("output.probes[{}]", i);
      if (point.size() != c_.grid.points.size()) {
        expected(path, fmt::format("a point with {} coordinate{}", c_.grid.points.size(), c_.grid.points.size() == 1 ? "" : "s"));
      }
      for (std::size_t d = 0; d < point.size(); ++d) {
        if (point[d] >= c_.grid.lower[d] && point[d] <= c_.grid.upper[d]) continue;
        expected(path,
                 fmt::format("a point of the domain, {} from {} to {}", "xy"[d], toml_text(c_.grid.lower[d]), toml_text(c_.grid.upper[d])));
      }
    }
  }

  // [converge]

  void converge(ConvergeOptions& o) const {
    const std::string& name = method_name(c_.method);
    const std::vector<std::string> with_fixed_step = {"lie", "strang", "dcs", "sdc"};
    if (!contains(with_fixed_step, name)) {
      fail("converge", fmt::format("method \"{}\" has no fixed step to study; take one of {}", name, comma_list(with_fixed_step)));
    }
    for (std::size_t i = 0; i < o.steps.size(); ++i) {
      const std::string path = fmt::format("converge.steps[{}]", i);
      if (o.steps[i] > span()) expected(path, fmt::format("a step not above the time span {}", toml_text(span())));
      const auto here = o.steps.begin() + static_cast<std::ptrdiff_t>(i);
      if (std::find(o.steps.begin(), here, o.steps[i]) != here) fail(path, fmt::format("{} is there twice", tree_.text(path)));
    }
    const auto* dcs = std::get_if<DcsOptions>(&c_.method);
    if (dcs == nullptr && name != "sdc" && !o.iterations.empty()) {
      fail("converge.iterations", "goes with methods \"dcs\" and \"sdc\" only");
    }
    if (dcs != nullptr && o.iterations.empty()) o.iterations = {dcs->iterations.value_or(*dcs->max_iterations)};

    ReferenceOptions& reference = o.reference;
    if (!reference.method.empty() && !reference.file.empty()) {
      fail("converge.reference", "expected only one of method and file");
    }
    if (reference.method.empty() && reference.file.empty()) reference.method = "cvode";
    if (reference.tolerance && reference.method != "cvode") {
      fail("converge.reference.tolerance", "goes with method = \"cvode\" only");
    }
    if (reference.step.has_value() != (reference.method == "sdc")) {
      fail("converge.reference.step",
           reference.step ? "goes with method = \"sdc\" only" : "missing: a positive number, the time step of the reference");
    }
    if (reference.method == "cvode" && !reference.tolerance) reference.tolerance = 1e-12;
  }

  Case& c_;
  const CaseTree& tree_;
  const std::vector<ModelDescription>& models_;
  const ModelDescription* description_ = nullptr;  // null: custom
};

}  // namespace

void complete(Case& c, const CaseTree& tree, const std::vector<ModelDescription>& models) { Completion(c, tree, models).run(); }

int fewest_points(int order, bool dirichlet) { return order == 8 && dirichlet ? 10 : order + 1; }

}  // namespace stiffront::app
