// SPDX-License-Identifier: BSD-3-Clause
#include "schema.hpp"

#include <fmt/format.h>

#include "key_kinds.hpp"
#include "stiffront/app/duration.hpp"
#include "stiffront/app/methods.hpp"
#include "stiffront/control/sbdf_tables.hpp"

namespace stiffront::app {
namespace {

constexpr Range any{};
constexpr Range positive{0.0, any.upper, true, false};
constexpr Range not_negative{0.0, any.upper, false, false};
constexpr Range fraction{0.0, 1.0, true, false};
constexpr Range above_one{1.0, any.upper, true, false};
constexpr Range below_half{0.0, 0.5, true, true};
constexpr Range from(double lower, double upper) { return {lower, upper, false, false}; }

#define STIFFRONT_OPTION(member) \
  [](auto& c) -> auto& { return c.member; }
#define STIFFRONT_METHOD(Options, member) \
  [](auto& c) -> auto& { return std::get<Options>(c.method).member; }
#define STIFFRONT_CONVERGE(member) \
  [](auto& c) -> auto& { return c.converge->member; }

std::vector<Key> grid_keys() {
  return {
      required(integers("grid.points", "one or two integers, the points in each direction", from(2, 1e9), Empty::refused,
                        STIFFRONT_OPTION(grid.points), "grid points in each direction, end points included; one entry: 1-D, two: 2-D")),
      with_default(numbers("grid.lower", "one number for each direction", any, Empty::refused, STIFFRONT_OPTION(grid.lower),
                           "lower end of the domain"),
                   "0 in each direction"),
      with_default(numbers("grid.upper", "one number for each direction", any, Empty::refused, STIFFRONT_OPTION(grid.upper),
                           "upper end of the domain; a periodic direction has no point there and the spacing "
                           "(upper - lower) / points"),
                   "1 in each direction"),
      with_default(integers("grid.processes", "one integer for each direction", from(0, 1e6), Empty::refused,
                            STIFFRONT_OPTION(grid.processes), "processes in each direction; 0 = chosen by the program"),
                   "0 in each direction"),
  };
}

enum class Side { lower, upper, both };

Key boundary_key(std::size_t direction, Side side) {
  const std::string axis(1, "xy"[direction]);
  Key key("boundary." + axis, R"("neumann", "periodic", "dirichlet" or a table { type = "dirichlet", SPECIES = VALUE, ... })",
          fmt::format("both sides in {}{}: no flux, periodic, or given values; a value is a number or an expression in t, x, "
                      "y and the parameters, 0 for a species not named",
                      axis, direction == 1 ? " (2-D only)" : ""));
  key.default_note = R"("neumann")";
  if (side != Side::both) {
    const char* name = side == Side::lower ? "lower" : "upper";
    key.default_note = key.path;
    key.doc = fmt::format("the {} side alone, whatever {} says", name, key.path);
    key.path += fmt::format("_{}", name);
  }
  key.read = [direction, side, words = key.expected](Case& c, const ConfigNode& node, const std::string& path) {
    auto& [lower, upper] = c.boundary.sides[direction];
    const SideOptions given = read_side(node, path, words);
    if (side != Side::upper) lower = given;
    if (side != Side::lower) upper = given;
  };
  key.write = [direction, side](const Case& c) -> std::string {
    const auto& [lower, upper] = c.boundary.sides[direction];
    const bool present = direction < static_cast<std::size_t>(c.grid.dimension());
    if (!present || (lower == upper) != (side == Side::both)) return "";
    return side_text(side == Side::upper ? upper : lower);
  };
  return key;
}

std::vector<Key> boundary_keys() {
  std::vector<Key> keys;
  for (const std::size_t direction : {0U, 1U}) {
    for (const Side side : {Side::both, Side::lower, Side::upper}) keys.push_back(boundary_key(direction, side));
  }
  return keys;
}

std::vector<Key> space_keys() {
  return {
      integer_of("space.order", {2, 4, 8}, "2, 4 or 8", STIFFRONT_OPTION(space.order), "order of the centred differences"),
      with_default(integer_of("space.quadrature_order", {2, 4, 8}, "2, 4 or 8", STIFFRONT_OPTION(space.quadrature_order),
                              "order of the differences in the collocation quadrature of dcs"),
                   "space.order"),
  };
}

Key parameters_key() {
  Key key("model.parameters", "a table of numbers", "parameters of the model by name");
  key.default_note = "those of the model";
  key.read = [words = key.expected](Case& c, const ConfigNode& node, const std::string& path) {
    c.model.parameters = read_entries(node, path, words, [](const ConfigNode& n, const std::string& at) { return read_number(n, at); });
  };
  key.write = [](const Case& c) { return entries_text(c.model.parameters); };
  return key;
}

Key diffusion_key() {
  Key key("model.diffusion", "a table of numbers and expressions",
          "diffusion coefficient of each species: a number, or an expression in the parameters");
  key.default_note = "those of the model; custom: 0";
  key.read = [words = key.expected](Case& c, const ConfigNode& node, const std::string& path) {
    c.model.diffusion = read_entries(node, path, words, [](const ConfigNode& n, const std::string& at) -> Value {
      if (n.type == ConfigNode::Type::string) return read_value(n, at);
      return read_number(n, at, not_negative);
    });
  };
  key.write = [](const Case& c) { return entries_text(c.model.diffusion); };
  return key;
}

Key reaction_key() {
  Key key("model.reaction", "a table with one expression for each species",
          "custom only: rate of change of each species, an expression in the species, the parameters, t, x and y");
  key.default_note = "none";
  key.entry_per_line = true;
  key.read = [words = key.expected](Case& c, const ConfigNode& node, const std::string& path) {
    c.model.reaction = read_entries(node, path, words, [](const ConfigNode& n, const std::string& at) {
      const Value rate = read_value(n, at);
      const double* constant = std::get_if<double>(&rate);
      return constant != nullptr ? toml_text(*constant) : std::get<std::string>(rate);
    });
  };
  key.write = [](const Case& c) {
    std::string lines;
    for (const auto& [species, rate] : c.model.reaction) {
      lines += fmt::format("reaction.{} = {}\n", toml_key(species), toml_text(rate));
    }
    return lines;
  };
  return key;
}

Key reactions_key() {
  Key key("model.reactions", R"(an array of tables { equation = "...", rate = ... })",
          "custom only: a reaction network, instead of model.reaction or added to it: [[model.reactions]] with an equation like "
          "\"2 u + v -> 3 u\" and a rate, a number or an expression; also reverse_rate, of the backward direction of <->, "
          "and mass_action = false where rate is the whole rate");
  key.default_note = "none";
  key.read = [words = key.expected](Case& c, const ConfigNode& node, const std::string& path) {
    c.model.reactions = read_array(node, path, words, false, read_reaction);
  };
  key.write = [](const Case& c) {
    std::string lines;
    for (const ReactionOptions& reaction : c.model.reactions) lines += fmt::format("  {},\n", reaction_text(reaction));
    return lines.empty() ? "" : "[\n" + lines + "]";
  };
  return key;
}

Key units_key() {
  Key key("model.units", "a table of names in quotation marks",
          "units of x (and y), t and the species, as in { x = \"cm\", t = \"s\" }: pictures show them, nothing is converted");
  key.default_note = "none";
  key.read = [words = key.expected](Case& c, const ConfigNode& node, const std::string& path) {
    c.model.units = read_entries(
        node, path, words, [](const ConfigNode& n, const std::string& at) { return read_string(n, at, "a unit in quotation marks"); });
  };
  key.write = [](const Case& c) { return entries_text(c.model.units); };
  return key;
}

std::vector<Key> model_keys() {
  Key species =
      with_default(names("model.species", STIFFRONT_OPTION(model.species), "custom only: names of the species"), "those of the model");
  species.write = [](const Case& c) { return c.model.is_custom() ? toml_text(c.model.species) : ""; };
  return {
      required(text("model.name", "the name of a model in quotation marks", STIFFRONT_OPTION(model.name),
                    "a model of `stiffront list models`, or \"custom\" for one written in the case file")),
      species,
      parameters_key(),
      diffusion_key(),
      reaction_key(),
      reactions_key(),
      units_key(),
  };
}

Key initial_expressions_key() {
  Key key("initial.*", "a number or an expression in quotation marks",
          "one entry for each species: a number or an expression in x, y and the parameters; or");
  key.default_note = "none";
  key.entry_per_line = true;
  key.read = [](Case& c, const ConfigNode& node, const std::string& path) {
    for (const auto& [name, value] : node.entries) {
      if (name == "profile" || name == "file") continue;
      c.initial.expressions.emplace_back(name, read_value(value, path + "." + name));
    }
  };
  key.write = [](const Case& c) {
    std::string lines;
    for (const auto& [species, value] : c.initial.expressions) {
      lines += fmt::format("{} = {}\n", toml_key(species), value_text(value));
    }
    return lines;
  };
  return key;
}

std::vector<Key> initial_keys() {
  return {
      with_default(text("initial.profile", "the name of a profile in quotation marks", STIFFRONT_OPTION(initial.profile),
                        "a profile of the model, see `stiffront list models`; or"),
                   "none"),
      initial_expressions_key(),
      with_default(text("initial.file", "the name of a result file in quotation marks", STIFFRONT_OPTION(initial.file),
                        "a state written earlier; on another uniform grid it is interpolated"),
                   "none"),
  };
}

std::vector<Key> time_keys() {
  return {
      number("time.start", any, STIFFRONT_OPTION(time.start), "time of the initial state"),
      required(number("time.end", any, STIFFRONT_OPTION(time.end), "time at which the run ends")),
      numbers("time.breakpoints", "an array of numbers", any, Empty::allowed, STIFFRONT_OPTION(time.breakpoints),
              "times a step must land on, such as discontinuities in the data; increasing"),
      number("time.restart_step.period", not_negative, STIFFRONT_OPTION(time.restart_step.period),
             "at the end of every such period the trial step is set to restart_step.step; 0 = never"),
      number("time.restart_step.step", not_negative, STIFFRONT_OPTION(time.restart_step.step), "trial step at the start of a period"),
  };
}

template <typename Options>
std::vector<Key> fixed_splitting_keys() {
  return {
      required(number("method.step", positive, STIFFRONT_METHOD(Options, step), "time step; with [converge] it may be left out")),
      choice("method.order", STIFFRONT_METHOD(Options, order), "which flow a step ends with"),
  };
}

std::vector<Key> adaptive_strang_keys() {
  using Options = AdaptiveStrangOptions;
  return {
      number("method.tolerance", positive, STIFFRONT_METHOD(Options, tolerance),
             "bound on the local error estimate, relative to the maximum of each species"),
      number("method.initial_step", not_negative, STIFFRONT_METHOD(Options, initial_step), "first trial step; 0 = chosen by the program"),
      number("method.epsilon", below_half, STIFFRONT_METHOD(Options, epsilon), "shift of the embedded splitting at the start"),
      number("method.epsilon_max", below_half, STIFFRONT_METHOD(Options, epsilon_max),
             "largest shift; from 1/2 on a reaction substep would run backwards"),
      boolean("method.critical_step", STIFFRONT_METHOD(Options, critical_step),
              "estimate the critical step, keep below it and adapt the shift"),
      integer("method.period", from(1, 1e9), STIFFRONT_METHOD(Options, period),
              "accepted steps between two estimates of the critical step"),
      number("method.safety", fraction, STIFFRONT_METHOD(Options, safety), "factor on the step the tolerance allows"),
      number("method.critical_safety", fraction, STIFFRONT_METHOD(Options, critical_safety), "factor on the critical step"),
      number("method.beta", fraction, STIFFRONT_METHOD(Options, beta),
             "the shift is adapted when the step leaves [beta, gamma] times the critical step"),
      number("method.gamma", fraction, STIFFRONT_METHOD(Options, gamma), "see beta"),
      number("method.theta", positive, STIFFRONT_METHOD(Options, theta), "an adapted shift puts the critical step at theta times the step"),
      number("method.max_growth", above_one, STIFFRONT_METHOD(Options, max_growth), "largest factor from one trial step to the next"),
      with_default(
          number(
              "method.final_error", not_negative, STIFFRONT_METHOD(Options, final_error),
              "error at the end, in tolerances, for which steps are kept small enough, told by a second solution with four times the step; "
              "0: neither estimated nor kept; only with critical_step"),
          "3; below a tolerance of 3e-7 more, 2 (1e-6/tolerance)^(1/3)"),
      choice("method.order", STIFFRONT_METHOD(Options, order), "which flow a step ends with"),
      with_default(names("method.species", STIFFRONT_METHOD(Options, species), "species that enter the error"), "all"),
  };
}

std::vector<Key> dcs_keys() {
  using Options = DcsOptions;
  return {
      with_default(number("method.tolerance", positive, STIFFRONT_METHOD(Options, tolerance), "bound on the local error estimate; or"),
                   "none"),
      with_default(
          number("method.step", positive, STIFFRONT_METHOD(Options, step), "fixed time step; with [converge] both may be left out"),
          "none"),
      choice("method.splitting", STIFFRONT_METHOD(Options, splitting), "the splitting that is corrected"),
      integer("method.stages", from(2, 5), STIFFRONT_METHOD(Options, stages), "stages of Radau IIA"),
      with_default(integer("method.max_iterations", from(0, 20), STIFFRONT_METHOD(Options, max_iterations),
                           "most corrections in a step; 0 = the splitting alone"),
                   "2 stages - 1 - order of the splitting"),
      with_default(integer("method.iterations", from(0, 20), STIFFRONT_METHOD(Options, iterations),
                           "with step: number of corrections in every step"),
                   "max_iterations"),
      choice("method.step_rule", STIFFRONT_METHOD(Options, step_rule),
             "with tolerance: next step from the corrections done, from the most allowed, or the smaller one"),
      choice("method.exponent", STIFFRONT_METHOD(Options, exponent),
             "with tolerance: the step follows the power of it that the errors have, or the paper's, which oscillates"),
      number("method.safety", fraction, STIFFRONT_METHOD(Options, safety),
             "with tolerance: the next step aims at so much of it; with published exponents a factor on the next step"),
      boolean("method.predict", STIFFRONT_METHOD(Options, predict),
              "with tolerance: give up a step early when its corrections are not going to reach the tolerance"),
      number("method.initial_step", not_negative, STIFFRONT_METHOD(Options, initial_step),
             "with tolerance: first trial step; 0 = chosen by the program"),
  };
}

std::vector<Key> sdc_keys() {
  using Options = SdcOptions;
  return {
      choice("method.nodes", STIFFRONT_METHOD(Options, nodes), "family of the collocation nodes"),
      integer("method.node_count", from(2, 10), STIFFRONT_METHOD(Options, node_count), "collocation nodes in a step"),
      with_default(number("method.step", positive, STIFFRONT_METHOD(Options, step), "fixed time step, all nodes together; or"), "none"),
      with_default(number("method.tolerance", positive, STIFFRONT_METHOD(Options, tolerance),
                          "bound on the residual of the last node, relative to the maximum of each species; with [converge] both may "
                          "be left out"),
                   "none"),
      number("method.initial_step", not_negative, STIFFRONT_METHOD(Options, initial_step),
             "with tolerance: first trial step; 0 = chosen by the program"),
      with_default(integer("method.starting_order", from(1, 10), STIFFRONT_METHOD(Options, starting_order),
                           "order of the method that gives the provisional solution, up to node_count (Lobatto: below)"),
                   "2, with splitting = \"diagonal\" 3; below node_count"),
      with_default(integer("method.corrections", from(0, 40), STIFFRONT_METHOD(Options, corrections),
                           "correction sweeps in a step; with tolerance: the most"),
                   "order of the quadrature - starting_order"),
      boolean("method.consistent", STIFFRONT_METHOD(Options, consistent), "sweeps repeat the explicit part at the corrected values"),
      choice("method.correction", STIFFRONT_METHOD(Options, correction),
             "form of the sweeps; \"alternative\" only with starting_order = 1, consistent and step"),
      choice("method.final_update", STIFFRONT_METHOD(Options, final_update),
             "what the step ends with; \"auto\": the last node if it is the end, quadrature otherwise"),
      boolean("method.acceleration", STIFFRONT_METHOD(Options, acceleration),
              "sweeps are combined by nonlinear GMRES: fewer of them, and less loss of order where the problem is stiff"),
      with_default(number("method.gamma_diffusion", not_negative, STIFFRONT_METHOD(Options, gamma_diffusion),
                          "factor on the three-point Laplacian of the implicit part"),
                   "1 for space.order = 2, otherwise 2; with splitting = \"diagonal\" 0.25"),
      number("method.gamma_advection", not_negative, STIFFRONT_METHOD(Options, gamma_advection),
             "factor on the first derivatives of the implicit part, for models that have them"),
      choice(
          "method.splitting", STIFFRONT_METHOD(Options, splitting),
          "\"preconditioned\": diffusion and the Jacobian of the reaction are implicit; \"imex\": one of them; \"lie\", \"strang\": "
          "the flows of reaction and diffusion, to the tolerances of their solvers, are start and correction; \"diagonal\": the fast one, "
          "all Radau nodes of a step in parallel, no cell coupled to another, for diffusion that is not very stiff"),
      choice("method.implicit", STIFFRONT_METHOD(Options, implicit), "with splitting = \"imex\": which one"),
      choice("method.implicit_solver", STIFFRONT_METHOD(Options, implicit_solver),
             "\"block-tridiagonal\": direct, 1-D; \"multigrid\": GMRES preconditioned by multigrid, 2-D; \"cell-local\": of the "
             "Laplacian only its diagonal, for weak diffusion; \"auto\": one of the first two"),
      number("method.linear_tolerance", fraction, STIFFRONT_METHOD(Options, linear_tolerance),
             "with multigrid: residual of the linear systems, relative to the change of each species"),
  };
}

std::vector<Key> sbdf_keys() {
  using Options = SbdfOptions;
  return {
      number("method.relative_tolerance", positive, STIFFRONT_METHOD(Options, relative_tolerance), "relative bound on the local error"),
      with_default(tolerance("method.absolute_tolerance", STIFFRONT_METHOD(Options, absolute_tolerance),
                             "absolute bound on the local error, for all species or for each"),
                   "relative_tolerance / 100"),
      integer("method.max_order", from(2, sbdf_max_order), STIFFRONT_METHOD(Options, max_order),
              "highest order used; 2 for models with damped fast oscillations"),
      integer("method.max_sweeps", from(1, sbdf_max_sweeps), STIFFRONT_METHOD(Options, max_sweeps), "most sweeps in a step"),
      number("method.initial_step", not_negative, STIFFRONT_METHOD(Options, initial_step), "first step; 0 = chosen by the program"),
  };
}

std::vector<Key> cvode_keys() {
  using Options = CvodeOptions;
  return {
      number("method.relative_tolerance", positive, STIFFRONT_METHOD(Options, relative_tolerance), "relative bound on the local error"),
      with_default(tolerance("method.absolute_tolerance", STIFFRONT_METHOD(Options, absolute_tolerance),
                             "absolute bound on the local error, for all species or for each"),
                   "relative_tolerance / 100"),
      with_default(choice("method.linear_solver", STIFFRONT_METHOD(Options, linear_solver), "linear solver of the Newton iteration"),
                   R"("gmres")"),
  };
}

std::vector<Key> auto_keys() {
  return {number("method.tolerance", positive, STIFFRONT_METHOD(AutoOptions, tolerance),
                 "error wanted, relative to the maximum of each species")};
}

Key method_name_key() {
  std::vector<std::string> allowed;
  for (const MethodEntry& entry : methods()) allowed.push_back(entry.name);
  Key key("method.name", quoted_alternatives(allowed), "time integration method, see `stiffront list methods`");
  key.read = [allowed](Case& c, const ConfigNode& node, const std::string& path) {
    const std::string name = read_word(node, path, allowed);
    for (const MethodEntry& entry : methods()) {
      if (entry.name == name) c.method = entry.defaults;
    }
  };
  key.write = [](const Case& c) { return toml_text(method_name(c.method)); };
  return key;
}

std::vector<Key> method_keys() {
  std::vector<Key> keys = {method_name_key()};
  const auto add = [&keys](const std::string& method, std::vector<Key> its_keys) {
    for (Key& key : its_keys) {
      key.method = method;
      keys.push_back(std::move(key));
    }
  };
  add("lie", fixed_splitting_keys<LieOptions>());
  add("strang", fixed_splitting_keys<StrangOptions>());
  add("adaptive-strang", adaptive_strang_keys());
  add("dcs", dcs_keys());
  add("sdc", sdc_keys());
  add("sbdf", sbdf_keys());
  add("cvode", cvode_keys());
  add("auto", auto_keys());
  return keys;
}

std::vector<Key> solver_keys() {
  return {
      choice("diffusion_solver.name", STIFFRONT_OPTION(diffusion_solver.name),
             "integrator of the diffusion flow; \"crank-nicolson\": one step of second order, for lie and strang in 1-D, with the first "
             "derivatives of models that have them"),
      number("diffusion_solver.tolerance", positive, STIFFRONT_OPTION(diffusion_solver.tolerance), "its relative and absolute tolerance"),
      integer("diffusion_solver.halo_depth", from(0, 64), STIFFRONT_OPTION(diffusion_solver.halo_depth),
              "stages per pass over memory and exchange of halos, as far as the processes' parts of the grid allow; 0: chosen by the "
              "program. Results do not depend on it"),
      choice("reaction_solver.name", STIFFRONT_OPTION(reaction_solver.name),
             "integrator of the reaction flow; \"trapezoidal\": one step of second order, for lie and strang"),
      number("reaction_solver.tolerance", positive, STIFFRONT_OPTION(reaction_solver.tolerance), "its relative and absolute tolerance"),
      choice("reaction_solver.balance", STIFFRONT_OPTION(reaction_solver.balance),
             "\"auto\": cells move between processes by counted cost"),
      choice("reaction_solver.positivity", STIFFRONT_OPTION(reaction_solver.positivity),
             "\"report\": states with negative values are counted; \"reject-step\": such a step is tried again with half its "
             "size, with any method but sdc and cvode"),
  };
}

Key probes_key() {
  Key key("output.probes", "an array of points, such as [[0.25], [0.5]] in 1-D and [[0.5, 0.5]] in 2-D",
          "points whose values go to probes.csv after each accepted step");
  key.read = [words = key.expected](Case& c, const ConfigNode& node, const std::string& path) {
    const auto coordinate = [](const ConfigNode& n, const std::string& at) { return read_number(n, at); };
    c.output.probes = read_array(node, path, words, true, [&](const ConfigNode& n, const std::string& at) {
      if (n.is_number()) return std::vector<double>{coordinate(n, at)};
      return read_array(n, at, "a point", false, coordinate);
    });
  };
  key.write = [](const Case& c) { return toml_text(c.output.probes); };
  return key;
}

std::vector<Key> output_keys() {
  return {
      text("output.directory", "the name of a directory in quotation marks", STIFFRONT_OPTION(output.directory),
           "where results go; -o on the command line comes first"),
      numbers("output.times", "an array of numbers", any, Empty::allowed, STIFFRONT_OPTION(output.times),
              "times of the states written, increasing; the initial and the final state always are; or"),
      number("output.every", not_negative, STIFFRONT_OPTION(output.every), "time between two states written; 0 = off; or"),
      integer("output.steps", not_negative, STIFFRONT_OPTION(output.steps), "accepted steps between two states written; 0 = off"),
      choice("output.mode", STIFFRONT_OPTION(output.mode),
             "\"interpolate\": output never changes the steps; \"land\": steps are shortened to hit the times"),
      probes_key(),
      number("output.checkpoint.every_seconds", not_negative, STIFFRONT_OPTION(output.checkpoint.every_seconds),
             "seconds between two checkpoints; 0 = off"),
      integer("output.checkpoint.every_steps", not_negative, STIFFRONT_OPTION(output.checkpoint.every_steps),
              "accepted steps between two checkpoints; 0 = off"),
      integer("output.checkpoint.keep", from(2, 1e6), STIFFRONT_OPTION(output.checkpoint.keep), "checkpoints kept; older ones are removed"),
      boolean("output.checkpoint.at_end", STIFFRONT_OPTION(output.checkpoint.at_end), "write one at the end of the run, too"),
      choice("output.checkpoint.on_failure", STIFFRONT_OPTION(output.checkpoint.on_failure),
             "what to do when a checkpoint cannot be written"),
  };
}

Key wall_time_key() {
  Key key("limits.wall_time", R"(a duration like "90s", "3h50m" or "1d")",
          "the run stops with a checkpoint and status 75 in time for this; \"0s\" = no limit");
  key.read = [words = key.expected](Case& c, const ConfigNode& node, const std::string& path) {
    const auto seconds = node.type == ConfigNode::Type::string ? parse_duration(node.string) : std::nullopt;
    if (!seconds) refuse(node, path, words);
    c.limits.wall_time = *seconds;
  };
  key.write = [](const Case& c) { return toml_text(format_duration(c.limits.wall_time)); };
  return key;
}

std::vector<Key> limits_keys() {
  return {
      wall_time_key(),
      integer("limits.max_steps", not_negative, STIFFRONT_OPTION(limits.max_steps), "most attempted steps; 0 = no limit"),
      number("limits.stall_limit_s", not_negative, STIFFRONT_OPTION(limits.stall_limit_s),
             "a watchdog ends a job in which no step completes for so many seconds; 0 = off"),
  };
}

std::vector<Key> converge_keys() {
  return {
      required(numbers("converge.steps", "an array of positive numbers", positive, Empty::refused, STIFFRONT_CONVERGE(steps),
                       "time steps of the study")),
      choice("converge.kind", STIFFRONT_CONVERGE(kind), "\"global\": the whole time span; \"local\": one step from the initial state"),
      integers("converge.iterations", "an array of integers", from(0, 20), Empty::allowed, STIFFRONT_CONVERGE(iterations),
               "dcs only: one column for each number of corrections"),
      with_default(
          word("converge.reference.method", {"cvode", "sdc"}, STIFFRONT_CONVERGE(reference.method), "method of the reference solution; or"),
          "none"),
      with_default(text("converge.reference.file", "the name of a result file in quotation marks", STIFFRONT_CONVERGE(reference.file),
                        "file with the reference solution"),
                   "none"),
      with_default(number("converge.reference.tolerance", positive, STIFFRONT_CONVERGE(reference.tolerance),
                          "cvode: relative tolerance of the reference"),
                   "1e-12"),
      with_default(number("converge.reference.step", positive, STIFFRONT_CONVERGE(reference.step), "sdc: time step of the reference"),
                   "none"),
  };
}

#undef STIFFRONT_OPTION
#undef STIFFRONT_METHOD
#undef STIFFRONT_CONVERGE

Key title_key() {
  Key key("title", "text in quotation marks", "one line about the case");
  key.read = [words = key.expected](Case& c, const ConfigNode& node, const std::string& path) {
    if (node.type != ConfigNode::Type::string) refuse(node, path, words);
    c.title = node.string;
  };
  key.write = [](const Case& c) { return toml_text(c.title); };
  return key;
}

}  // namespace

const std::vector<Key>& schema() {
  static const std::vector<Key> keys = [] {
    std::vector<Key> all = {title_key()};
    for (auto* section : {grid_keys, boundary_keys, space_keys, model_keys, initial_keys, time_keys, method_keys, solver_keys, output_keys,
                          limits_keys, converge_keys}) {
      for (Key& key : section()) all.push_back(std::move(key));
    }
    return all;
  }();
  return keys;
}

}  // namespace stiffront::app
