// SPDX-License-Identifier: BSD-3-Clause
// Every rule of the case file, with its message word for word.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "../../src/app/schema.hpp"
#include "app/example_case.hpp"
#include "stiffront/core/error.hpp"

namespace stiffront::app {
namespace {

std::string message_of(const std::vector<std::string>& overrides, const std::string& text = example_text,
                       ErrorKind kind = ErrorKind::input) {
  try {
    parse_example(overrides, text);
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), kind) << error.what();
    return error.what();
  }
  return "no error";
}

/// Overrides that make a case in which the key exists.
std::vector<std::string> setting_of(const Key& key) {
  std::vector<std::string> setting;
  if (!key.method.empty()) setting.push_back(fmt::format("method={{ name = \"{}\" }}", key.method));
  return setting;
}

TEST(CaseErrors, EveryKeyRefusesADateAndSaysWhatItExpects) {
  for (const Key& key : schema()) {
    std::string path = key.path;
    if (path == "initial.*") path = "initial.a";
    std::vector<std::string> overrides = setting_of(key);
    overrides.push_back(path + "=1979-05-27");
    EXPECT_EQ(message_of(overrides), fmt::format("command line: {}: expected {}, got 1979-05-27", path, key.expected));
  }
}

TEST(CaseErrors, EveryKeyRefusesNanAndInfinity) {
  for (const Key& key : schema()) {
    const std::string path = key.path == "initial.*" ? "initial.a" : key.path;
    for (const char* value : {"nan", "inf", "-inf"}) {
      std::vector<std::string> overrides = setting_of(key);
      overrides.push_back(path + "=" + value);
      EXPECT_EQ(message_of(overrides), fmt::format("command line: {}: expected {}, got {}", path, key.expected, value));
    }
  }
}

TEST(CaseErrors, EveryListRefusesNanInIt) {
  EXPECT_EQ(message_of({"output.times=[0.5, nan]"}), "command line: output.times[1]: expected a number, got nan");
  EXPECT_EQ(message_of({"grid.lower=[-inf]"}), "command line: grid.lower[0]: expected a number, got -inf");
  EXPECT_EQ(message_of({"time.breakpoints=[inf]"}), "command line: time.breakpoints[0]: expected a number, got inf");
  EXPECT_EQ(message_of({"output.probes=[[nan]]"}), "command line: output.probes[0][0]: expected a number, got nan");
  EXPECT_EQ(message_of({"model.parameters.q=nan"}), "command line: model.parameters.q: expected a number, got nan");
  EXPECT_EQ(message_of({"model.diffusion.a=nan"}), "command line: model.diffusion.a: expected a number not below 0, got nan");
  EXPECT_EQ(message_of({"boundary.x={ type = \"dirichlet\", a = nan }"}),
            "command line: boundary.x.a: expected a number or an expression in quotation marks, got nan");
  EXPECT_EQ(message_of({"method={name = \"sbdf\", absolute_tolerance = { a = nan }}"}),
            "command line: method.absolute_tolerance.a: expected a positive number, got nan");
}

TEST(CaseErrors, MessagesNameFileLineAndKey) {
  std::string text = example_text;
  text.replace(text.find("tolerance = 1e-5"), 16, "tolerance = -1");
  EXPECT_EQ(message_of({}, text), "bz.toml:13:1: method.tolerance: expected a positive number, got -1");
  text = example_text;
  text.replace(text.find("end = 2.0"), 9, "ends = 2.0");
  EXPECT_EQ(message_of({}, text),
            "bz.toml:10:1: time.ends: unknown key; did you mean end? Allowed in [time]: start, end, breakpoints, restart_step");
  text = example_text;
  text.replace(text.find("end = 2.0"), 9, "");
  EXPECT_EQ(message_of({}, text), "bz.toml:9:2: time.end: missing: a number (time at which the run ends)");
  text = example_text;
  text.replace(text.find("points = [101]"), 14, "points = [101");
  EXPECT_EQ(message_of({}, text).substr(0, 29), "bz.toml:4: not valid TOML: Er");
}

TEST(CaseErrors, MissingEntriesAreNamed) {
  EXPECT_EQ(message_of({}, ""),
            "bz.toml: grid.points: missing: one or two integers, the points in each direction (grid points in each "
            "direction, "
            "end points included; one entry: 1-D, two: 2-D)");
  EXPECT_EQ(message_of({"method={ name = \"strang\" }"}),
            "command line: method.step: missing: a positive number (time step; with [converge] it may be left out)");
  EXPECT_EQ(message_of({"method={ name = \"lie\" }", "converge={}"}),
            "command line: converge.steps: missing: an array of positive numbers (time steps of the study)");
}

TEST(CaseErrors, MessagesStayOnOneLine) {
  EXPECT_EQ(message_of({}, std::string(example_text) + "\"a\\nb\" = 1\n").substr(0, 37), "bz.toml:14:1: method.a b: unknown key");
}

TEST(CaseErrors, ModelsWithFirstDerivativesNameTheMethodsTheyGoWith) {
  const auto message = [](const std::vector<std::string>& overrides) -> std::string {
    std::vector<ModelDescription> models;
    models.push_back({"drift", "of its own", {"u"}, {}, {1.0}, {{"step", "a step"}}, true});
    const char* const text = R"toml(
[grid]
points = [33]
[model]
name = "drift"
[initial]
profile = "step"
[time]
end = 1
[method]
name = "sdc"
step = 0.1
)toml";
    try {
      parse_case({"drift.toml", text, overrides}, models);
    } catch (const Error& error) {
      return error.what();
    }
    return "no error";
  };
  const std::string goes_with =
      "the model drift has first derivatives, for which there are the methods sdc, cvode and auto, and lie and "
      "strang with diffusion_solver.name = \"crank-nicolson\"";
  for (const char* method :
       {"method={ name = \"adaptive-strang\" }", "method={ name = \"dcs\", step = 0.1 }", "method={ name = \"sbdf\" }"}) {
    EXPECT_EQ(message({method}), "command line: method.name: " + goes_with);
  }
  EXPECT_EQ(message({"method={ name = \"sbdf\" }", "space.order=8"}), "command line: method.name: " + goes_with);
  for (const char* method : {"method={ name = \"lie\", step = 0.1 }", "method={ name = \"strang\", step = 0.1 }"}) {
    EXPECT_EQ(message({method}), "drift.toml: diffusion_solver.name: " + goes_with);
    EXPECT_EQ(message({method, "diffusion_solver.name=crank-nicolson"}), "no error");
  }
  for (const char* method : {"method.gamma_advection=2", "method={ name = \"cvode\" }", "method={ name = \"auto\" }"}) {
    EXPECT_EQ(message({method}), "no error");
  }
  for (const char* splitting : {"lie", "strang"}) {
    EXPECT_EQ(message({std::string("method.splitting=") + splitting}),
              "command line: method.splitting: expected \"preconditioned\" or \"imex\": the model drift has first derivatives");
  }
  EXPECT_EQ(message({"method.gamma_advection=1", "method.implicit_solver=cell-local"}),
            "command line: method.gamma_advection: expected 0 with implicit_solver = \"cell-local\"");
  EXPECT_EQ(message({"method.gamma_advection=1", "method.splitting=imex", "method.implicit=reaction"}),
            "command line: method.gamma_advection: expected 0 with splitting = \"imex\" and implicit = \"reaction\"");
  EXPECT_EQ(message({"grid.points=[33, 33]"}), "drift.toml:5:1: model.name: the model drift is for one dimension");
}

TEST(CaseErrors, TwiceDefinedKeysAreRefusedByTheParser) {
  EXPECT_EQ(message_of({}, std::string(example_text) + "tolerance = 1\n").substr(0, 27), "bz.toml:14: not valid TOML:");
}

struct Rule {
  std::vector<std::string> overrides;
  std::string message;
};

class CaseRule : public ::testing::TestWithParam<Rule> {};

TEST_P(CaseRule, HasItsMessage) { EXPECT_EQ(message_of(GetParam().overrides), "command line: " + GetParam().message); }

const char* const adaptive_keys =
    "name, tolerance, initial_step, epsilon, epsilon_max, critical_step, period, safety, critical_safety, beta, gamma, "
    "theta, "
    "max_growth, final_error, order, species";

INSTANTIATE_TEST_SUITE_P(
    Names, CaseRule,
    ::testing::Values(
        Rule{{"methd.name=lie"},
             "methd: unknown key; did you mean method? Allowed at the top: title, grid, boundary, space, model, "
             "initial, time, "
             "method, diffusion_solver, reaction_solver, output, limits, converge"},
        Rule{{"method.tolerence=1"},
             fmt::format("method.tolerence: unknown key; did you mean tolerance? Allowed in [method] with name = "
                         "\"adaptive-strang\": {}",
                         adaptive_keys)},
        Rule{{"method.step=1"},
             fmt::format("method.step: unknown key; it belongs to method \"lie\" or method \"strang\" or method \"dcs\" or "
                         "method \"sdc\"; allowed in [method] with name = \"adaptive-strang\": {}",
                         adaptive_keys)},
        Rule{{"grid.end=1"}, "grid.end: unknown key; it belongs to [time]; allowed in [grid]: points, lower, upper, processes"},
        Rule{{"grid.bananas=1"}, "grid.bananas: unknown key; allowed in [grid]: points, lower, upper, processes"},
        Rule{{"output.checkpoint.kep=3"},
             "output.checkpoint.kep: unknown key; did you mean keep? Allowed in [output.checkpoint]: every_seconds, "
             "every_steps, keep, at_end, on_failure"},
        Rule{{"grid=5"}, "grid: expected a table, got 5"}, Rule{{"output.checkpoint=5"}, "output.checkpoint: expected a table, got 5"},
        Rule{{"method.name=strng"},
             "method.name: expected \"lie\", \"strang\", \"adaptive-strang\", \"dcs\", \"sdc\", \"sbdf\", \"cvode\" or "
             "\"auto\", "
             "got \"strng\"; did you mean strang?"},
        Rule{{"reaction_solver.name=radau"},
             "reaction_solver.name: expected \"radau5\", \"cvode\" or \"trapezoidal\", got \"radau\"; did you mean radau5?"},
        Rule{{"model.name=bzz"}, "model.name: unknown model \"bzz\"; did you mean bz? Allowed: bz, kpp, custom"},
        Rule{{"model.parameters.eps=1"}, "model.parameters.eps: unknown parameter; allowed for model bz: epsilon, mu, f, q"},
        Rule{{"model.units.bb=\"M\""}, "model.units.bb: unknown quantity; did you mean b? Allowed for model bz: x, t, a, b, c"},
        Rule{{"model.parameters.epsilo=1"},
             "model.parameters.epsilo: unknown parameter; did you mean epsilon? Allowed for model bz: epsilon, mu, f, "
             "q"},
        Rule{{"model.diffusion.d=1"}, "model.diffusion.d: unknown species; allowed for model bz: a, b, c"},
        Rule{{"method.species=[\"B\"]"}, "method.species[0]: unknown species; did you mean b? Allowed for model bz: a, b, c"},
        Rule{{"initial.profile=bz-frnt"},
             "initial.profile: unknown profile \"bz-frnt\"; did you mean bz-front? Allowed for model bz: bz-front, "
             "bz-ignition, "
             "bz-spiral"},
        Rule{{"initial.profil=bz-front"},
             "initial.profil: unknown key; did you mean profile? Allowed in [initial]: profile, file, a, b, c"}));

INSTANTIATE_TEST_SUITE_P(
    Grid, CaseRule,
    ::testing::Values(
        Rule{{"grid.points=[]"}, "grid.points: expected one or two integers, the points in each direction, got []"},
        Rule{{"grid.points=[9, 9, 9]"}, "grid.points: expected one or two integers, the points in each direction, got [9, 9, 9]"},
        Rule{{"grid.points=[1]"}, "grid.points[0]: expected an integer not below 2 and not above 1000000000, got 1"},
        Rule{{"grid.points=[100.0]"}, "grid.points[0]: expected an integer not below 2 and not above 1000000000, got 100.0"},
        Rule{{"grid.points=[9999999999]"}, "grid.points[0]: expected an integer not below 2 and not above 1000000000, got 9999999999"},
        Rule{{"grid.points=[1000000000, 1000000000]"}, "grid.points: expected at most 10000000000000 points altogether, got 1e+18"},
        Rule{{"grid.points=[2]"}, "grid.points[0]: expected at least 3 points for differences of order 2, got 2"},
        Rule{{"grid.points=[9, 4]", "space.order=4"}, "grid.points[1]: expected at least 5 points for differences of order 4, got 4"},
        Rule{{"grid.points=[8]", "space.quadrature_order=8"},
             "grid.points[0]: expected at least 9 points for differences of order 8, got 8"},
        Rule{{"grid.points=[9]", "space.order=8", "boundary.x=dirichlet"},
             "grid.points[0]: expected at least 10 points for differences of order 8, got 9"},
        Rule{{"space.quadrature_order=8", "boundary.x=dirichlet"},
             "space.quadrature_order: order 8 next to a side of given values has a grid of its own; use the same order for both"},
        Rule{{"space.order=8", "method={name=\"sbdf\"}"},
             "space.order: expected 2 or 4 with method \"sbdf\"; order 8 goes with cvode, sdc, dcs and the splittings, got 8"},
        Rule{{"grid.upper=[1, 2]"}, "grid.upper: expected as many entries as grid.points has, 1, got [1, 2]"},
        Rule{{"grid.lower=[]"}, "grid.lower: expected one number for each direction, got []"},
        Rule{{"grid.upper=[0]"}, "grid.upper[0]: expected grid.lower below grid.upper, got 0.0 and 0.0"},
        Rule{{"grid.lower=[2]"}, "grid.lower[0]: expected grid.lower below grid.upper, got 2.0 and 1.0"},
        Rule{{"grid.lower=[-1e308]", "grid.upper=[1e308]"}, "grid.upper[0]: expected grid.lower below grid.upper, got -1e308 and 1e308"},
        Rule{{"grid.processes=[1, 1]"}, "grid.processes: expected as many entries as grid.points has, 1, got [1, 1]"},
        Rule{{"grid.processes=[-1]"}, "grid.processes[0]: expected an integer not below 0 and not above 1000000, got -1"},
        Rule{{"grid.processes=[102]"}, "grid.processes[0]: expected at most one process for each of 101 points, got 102"},
        Rule{{"space.order=3"}, "space.order: expected 2, 4 or 8, got 3"}));

INSTANTIATE_TEST_SUITE_P(
    Boundary, CaseRule,
    ::testing::Values(Rule{{"boundary.y=neumann"}, "boundary.y: the grid has no such direction: grid.points has one entry"},
                      Rule{{"boundary.y_upper=neumann"}, "boundary.y_upper: the grid has no such direction: grid.points has one entry"},
                      Rule{{"boundary.x_lower=periodic"},
                           "boundary.x_lower: periodic on one side only; write boundary.x = \"periodic\" for both"},
                      Rule{{"boundary.x=periodic", "boundary.x_upper=neumann"},
                           "boundary.x_upper: periodic on one side only; write boundary.x = \"periodic\" for both"},
                      Rule{{"boundary.x=peridic"},
                           "boundary.x: expected \"neumann\", \"periodic\" or \"dirichlet\", got \"peridic\"; did you mean periodic?"},
                      Rule{{"boundary.x={ a = 1.0 }"}, "boundary.x: type is missing: \"neumann\", \"periodic\" or \"dirichlet\""},
                      Rule{{"boundary.x={ type = \"neumann\", a = 1.0 }"}, "boundary.x.a: values go with type = \"dirichlet\" only"},
                      Rule{{"boundary.x_upper={ type = \"dirichlet\", A = 1.0 }"},
                           "boundary.x_upper.A: unknown species; did you mean a? Allowed for model bz: a, b, c"}));

INSTANTIATE_TEST_SUITE_P(
    Model, CaseRule,
    ::testing::Values(
        Rule{{"model.species=[\"u\"]"}, "model.species: only for model.name = \"custom\""},
        Rule{{"model.reaction.u=1"}, "model.reaction: only for model.name = \"custom\""},
        Rule{{"model.reactions=[{ equation = \"a -> b\", rate = 1 }]"}, "model.reactions: only for model.name = \"custom\""},
        Rule{{"model.reactions=[]"}, "model.reactions: expected an array of tables { equation = \"...\", rate = ... }, got []"},
        Rule{{"model.reactions=[1]"}, "model.reactions[0]: expected a table { equation = \"...\", rate = ... }, got 1"},
        Rule{{"model.reactions=[{ rate = 1 }]"}, "model.reactions[0].equation: missing"},
        Rule{{"model.reactions=[{ equation = \"a -> b\" }]"}, "model.reactions[0].rate: missing"},
        Rule{{"model.reactions=[{ equation = \"a -> b\", rate = 1, mass_action = 1 }]"},
             "model.reactions[0].mass_action: expected true or false, got 1"},
        Rule{{"model.reactions=[{ equation = \"\", rate = 1 }]"},
             "model.reactions[0].equation: expected an equation in quotation marks, got \"\""},
        Rule{{"model.reactions=[{ equation = \"a -> b\", rates = 1 }]"},
             "model.reactions[0].rates: unknown key; did you mean rate? Allowed: equation, rate, "
             "reverse_rate, mass_action"},
        Rule{{"model.diffusion.a=-1"}, "model.diffusion.a: expected a number not below 0, got -1"},
        Rule{{"model.diffusion.a=\"\""}, "model.diffusion.a: expected a number or an expression in quotation marks, got \"\""},
        Rule{{"model.parameters.q=many"}, "model.parameters.q: expected a number, got \"many\""}));

INSTANTIATE_TEST_SUITE_P(
    InitialAndTime, CaseRule,
    ::testing::Values(Rule{{"initial={}"}, "initial: missing: one of: profile, or an expression for each species, or file"},
                      Rule{{"initial={ profile = \"bz-front\", file = \"a.h5\" }"},
                           "initial: expected only one of: profile, or an expression for each species, or file"},
                      Rule{{"initial.profile=bz-spiral"}, "initial.profile: \"bz-spiral\" needs a grid of 2 dimensions, this one has 1"},
                      Rule{{"initial={ a = 0, c = 0 }"}, "initial: no initial value for b; every species needs one"},
                      Rule{{"time.end=-1"}, "time.end: expected a time after time.start = 0.0, got -1"},
                      Rule{{"time.start=-1e308", "time.end=1e308"}, "time.end: expected a time after time.start = -1e308, got 1e308"},
                      Rule{{"time.breakpoints=[0.5, 0.5]"}, "time.breakpoints[1]: expected increasing times between 0.0 and 2.0, got 0.5"},
                      Rule{{"time.breakpoints=[0]"}, "time.breakpoints[0]: expected increasing times between 0.0 and 2.0, got 0"},
                      Rule{{"time.breakpoints=[2.0]"}, "time.breakpoints[0]: expected increasing times between 0.0 and 2.0, got 2.0"},
                      Rule{{"time.restart_step={ period = 0.1 }"}, "time.restart_step: period and step are both positive or both 0"},
                      Rule{{"time.restart_step={ period = 0.1, step = 0.2 }"},
                           "time.restart_step.step: expected a number not above the period 0.1, got 0.2"},
                      Rule{{"time.restart_step={ period = 1e-12, step = 1e-13 }"},
                           "time.restart_step.period: expected a number not below 2e-9, a billionth of the time span, got 1e-12"}));

INSTANTIATE_TEST_SUITE_P(
    Method, CaseRule,
    ::testing::Values(
        Rule{{"method.epsilon=0.5"}, "method.epsilon: expected a number above 0 and below 0.5, got 0.5"},
        Rule{{"method.epsilon=0.4", "method.epsilon_max=0.3"}, "method.epsilon: expected epsilon not above epsilon_max = 0.3, got 0.4"},
        Rule{{"method.epsilon_max=0.01"}, "method.epsilon_max: expected epsilon not above epsilon_max = 0.01, got 0.01"},
        Rule{{"method.beta=0.95"}, "method.beta: expected beta below gamma = 0.95, got 0.95"},
        Rule{{"method.gamma=0.05"}, "method.gamma: expected beta below gamma = 0.05, got 0.05"},
        Rule{{"method.period=0"}, "method.period: expected an integer not below 1 and not above 1000000000, got 0"},
        Rule{{"method.safety=1.5"}, "method.safety: expected a number above 0 and not above 1, got 1.5"},
        Rule{{"method.max_growth=1"}, "method.max_growth: expected a number above 1, got 1"},
        Rule{{"method.initial_step=-1"}, "method.initial_step: expected a number not below 0, got -1"},
        Rule{{"method.critical_step=1"}, "method.critical_step: expected true or false, got 1"},
        Rule{{"method.species=[]"}, "method.species: expected an array of names in quotation marks, got []"},
        Rule{{"method.species=[1]"}, "method.species[0]: expected a name in quotation marks, got 1"},
        Rule{{"method={ name = \"dcs\" }"}, "method: missing: one of: method.tolerance for adaptive steps, or method.step for fixed ones"},
        Rule{{"method={ name = \"dcs\", tolerance = 1, step = 1 }"},
             "method.step: expected only one of: method.tolerance for adaptive steps, or method.step for fixed ones"},
        Rule{{"method={ name = \"dcs\", tolerance = 1, iterations = 1 }"},
             "method.iterations: goes with method.step, not with method.tolerance"},
        Rule{{"method={ name = \"dcs\", step = 1, iterations = 3, max_iterations = 2 }"},
             "method.iterations: expected an integer not above max_iterations = 2, got 3"},
        Rule{{"method={ name = \"dcs\", step = 1, stages = 6 }"}, "method.stages: expected an integer not below 2 and not above 5, got 6"},
        Rule{{"method={ name = \"sbdf\", max_order = 1 }"}, "method.max_order: expected an integer not below 2 and not above 5, got 1"},
        Rule{{"method={ name = \"sbdf\", absolute_tolerance = 0 }"},
             "method.absolute_tolerance: expected a positive number, or a table with one for each species, got 0"},
        Rule{{"method={ name = \"cvode\", absolute_tolerance = { a = 1, b = 1 } }"},
             "method.absolute_tolerance: no tolerance for c; every species needs one"},
        Rule{{"method={ name = \"cvode\", absolute_tolerance = { d = 1 } }"},
             "method.absolute_tolerance.d: unknown species; allowed for model bz: a, b, c"}));

INSTANTIATE_TEST_SUITE_P(
    OutputAndConverge, CaseRule,
    ::testing::Values(
        Rule{{"method={ name = \"cvode\" }", "reaction_solver.positivity=reject-step"},
             "reaction_solver.positivity: \"reject-step\" does not go with method \"cvode\"; use \"report\""},
        Rule{{"method={ name = \"sdc\", step = 0.1, gamma_advection = 1 }"},
             "method.gamma_advection: expected 0: the model has no first derivatives"},
        Rule{{"diffusion_solver.name=crank-nicolson"},
             "diffusion_solver.name: \"crank-nicolson\" goes with methods lie and strang, not with adaptive-strang"},
        Rule{{"method={ name = \"strang\", step = 0.1 }", "diffusion_solver.name=crank-nicolson", "grid.points=[9, 9]",
              "initial.profile=bz-spiral"},
             "diffusion_solver.name: \"crank-nicolson\" is for one dimension"},
        Rule{{"method={ name = \"sdc\", step = 0.1, splitting = \"strang\" }", "reaction_solver.name=trapezoidal"},
             "reaction_solver.name: \"trapezoidal\" goes with methods lie and strang, not with sdc"},
        Rule{{"method={ name = \"sdc\", step = 0.1 }", "reaction_solver.positivity=reject-step"},
             "reaction_solver.positivity: \"reject-step\" does not go with method \"sdc\"; use \"report\""},
        Rule{{"output.every=0.1", "output.steps=3"}, "output.steps: expected only one of times, every and steps"},
        Rule{{"output.times=[1.0]", "output.every=0.1"}, "output.every: expected only one of times, every and steps"},
        Rule{{"output.times=[0.5, 0.4]"}, "output.times[1]: expected increasing times from 0.0 to 2.0, got 0.4"},
        Rule{{"output.times=[2.5]"}, "output.times[0]: expected increasing times from 0.0 to 2.0, got 2.5"},
        Rule{{"output.every=1e-30"}, "output.every: expected a number not below 2e-9, a billionth of the time span, got 1e-30"},
        Rule{{"output.directory=\"\""}, "output.directory: expected the name of a directory in quotation marks, got \"\""},
        Rule{{"output.probes=[[0.5, 0.5]]"}, "output.probes[0]: expected a point with 1 coordinate, got [0.5, 0.5]"},
        Rule{{"output.probes=[0.5, 1.5]"}, "output.probes[1]: expected a point of the domain, x from 0.0 to 1.0, got 1.5"},
        Rule{{"output.probes=[[]]"}, "output.probes[0]: expected a point, got []"},
        Rule{{"output.checkpoint.keep=1"}, "output.checkpoint.keep: expected an integer not below 2 and not above 1000000, got 1"},
        Rule{{"limits.wall_time=90"}, "limits.wall_time: expected a duration like \"90s\", \"3h50m\" or \"1d\", got 90"},
        Rule{{"limits.wall_time=3 hours"}, "limits.wall_time: expected a duration like \"90s\", \"3h50m\" or \"1d\", got \"3 hours\""},
        Rule{{"converge.steps=[0.1]"},
             "converge: method \"adaptive-strang\" has no fixed step to study; take one of lie, strang, dcs, sdc"},
        Rule{{"method={ name = \"lie\" }", "converge.steps=[]"}, "converge.steps: expected an array of positive numbers, got []"},
        Rule{{"method={ name = \"lie\" }", "converge.steps=[0.1, 0]"}, "converge.steps[1]: expected a positive number, got 0"},
        Rule{{"method={ name = \"lie\" }", "converge.steps=[0.1, 0.1]"}, "converge.steps[1]: 0.1 is there twice"},
        Rule{{"method={ name = \"lie\" }", "converge.steps=[3]"}, "converge.steps[0]: expected a step not above the time span 2.0, got 3"},
        Rule{{"method={ name = \"lie\" }", "converge={ steps = [0.1], iterations = [1] }"},
             "converge.iterations: goes with methods \"dcs\" and \"sdc\" only"},
        Rule{{"method={ name = \"lie\" }", "converge={ steps = [0.1], reference = { method = \"cvode\", file = \"a\" } }"},
             "converge.reference: expected only one of method and file"},
        Rule{{"method={ name = \"lie\" }", "converge={ steps = [0.1], reference = { file = \"a\", tolerance = 1 } }"},
             "converge.reference.tolerance: goes with method = \"cvode\" only"},
        Rule{{"method={ name = \"lie\" }", "converge={ steps = [0.1], reference = { step = 1 } }"},
             "converge.reference.step: goes with method = \"sdc\" only"},
        Rule{{"method={ name = \"lie\" }", "converge={ steps = [0.1], reference = { method = \"sdc\" } }"},
             "converge.reference.step: missing: a positive number, the time step of the reference"}));

TEST(CustomModelErrors, HaveTheirMessages) {
  const auto message = [](const std::vector<std::string>& overrides) { return message_of(overrides, custom_text); };
  EXPECT_EQ(message({"model={ name = \"custom\" }"}),
            "command line: model.species: missing: a custom model needs the names of its species, as in species = "
            "[\"u\", \"v\"]");
  EXPECT_EQ(message({"model.species=[\"u\", \"2v\"]"}),
            "command line: model.species[1]: \"2v\" is no name: letters, digits and _, not beginning with a digit");
  EXPECT_EQ(message({"model.species=[\"u\", \"u\"]"}), "command line: model.species[1]: species u is there twice");
  EXPECT_EQ(message({"model.species=[\"u\", \"x\"]"}), "command line: model.species[1]: the name x is taken; choose another one");
  EXPECT_EQ(message({"model.parameters.pi=3"}), "command line: model.parameters.pi: the name pi is taken; choose another one");
  EXPECT_EQ(message({"model.parameters.u=3"}), "command line: model.parameters.u: u is a species already");
  EXPECT_EQ(message({"model.species=[\"u\", \"v\", \"w\"]"}), "bz.toml:9:8: model.reaction: no expression for w; every species needs one");
  EXPECT_EQ(message({"model.reaction.w=1"}), "command line: model.reaction.w: unknown species; allowed for model custom: u, v");
  EXPECT_EQ(message({"model={ name = \"custom\", species = [\"u\"] }"}),
            "command line: model.reaction: missing: [model.reaction] with an expression for each species, or "
            "[[model.reactions]], a reaction network");
  EXPECT_EQ(message({"model.species=[\"a1\", \"a2\", \"a3\", \"a4\", \"a5\", \"a6\", \"a7\", \"a8\", \"a9\"]", "model.reaction={}",
                     "model.diffusion={}", "model.reactions=[{ equation = \"a1 -> a2\", rate = 1 }]"}),
            "command line: model.species: expected at most 8 species, got 9");
  EXPECT_EQ(message({"initial={ profile = \"bz-front\" }"}),
            "command line: initial.profile: model custom has no profiles; give an expression for each species");
  EXPECT_EQ(message({"model.reaction=[]"}), "command line: model.reaction: expected a table with one expression for each species, got []");
}

TEST(ExpressionErrors, NameTheEntryAndTheColumn) {
  const auto message = [](const std::vector<std::string>& overrides) { return message_of(overrides, custom_text); };
  EXPECT_EQ(message({"model.reaction.u=A + u*"}),
            "command line: model.reaction.u: column 7: the expression ends where a number, a name or ( is expected");
  EXPECT_EQ(message({"model.reaction.u=A + w"}),
            "command line: model.reaction.u: column 5: unknown name \"w\"; allowed: u, v, t, x, y, A, B, nu, pi, e");
  EXPECT_EQ(message({"model.diffusion.u=nu*u"}),
            "command line: model.diffusion.u: column 4: unknown name \"u\"; did you mean nu? Allowed: A, B, nu, pi, e");
  EXPECT_EQ(message({"model.diffusion.u=nu*x"}), "command line: model.diffusion.u: column 4: unknown name \"x\"; allowed: A, B, nu, pi, e");
  EXPECT_EQ(message({"model.diffusion.u=-nu"}), "command line: model.diffusion.u: expected a number not below 0, got \"-nu\" = -0.002");
  EXPECT_EQ(message({"initial.u=sin(t)"}), "command line: initial.u: column 5: unknown name \"t\"; allowed: x, y, A, B, nu, pi, e");
  EXPECT_EQ(message({"boundary.x={ type = \"dirichlet\", u = \"sin(t)*C\" }"}),
            "command line: boundary.x.u: column 8: unknown name \"C\"; allowed: t, x, y, A, B, nu, pi, e");
  EXPECT_EQ(message_of({"model.reactions=[{ equation = \"u -> v\", rate = \"k\" }]"}, network_text),
            "command line: model.reactions[0].rate: column 1: unknown name \"k\"; allowed: u, v, t, x, y, pi, e");
  EXPECT_EQ(message_of({"model.reactions=[{ equation = \"u -> w\", rate = 1 }]"}, network_text),
            "command line: model.reactions[0].equation: column 6: unknown species \"w\"; allowed: u, v");
  EXPECT_EQ(message_of({"model.reactions=[{ equation = \"u <-> v\", rate = 1 }]"}, network_text),
            "command line: model.reactions[0].reverse_rate: missing: the coefficient of the backward direction");
  EXPECT_EQ(message_of({"model.reactions=[{ equation = \"u <-> v\", rate = 1, reverse_rate = \"1 +\" }]"}, network_text),
            "command line: model.reactions[0].reverse_rate: column 4: the expression ends where a number, a name or ( is "
            "expected");
}

TEST(OverrideErrors, HaveTheirMessages) {
  EXPECT_EQ(message_of({"time.end"}, example_text, ErrorKind::usage), "\"time.end\" is not KEY=VALUE with a key like method.tolerance");
  EXPECT_EQ(message_of({"=3"}, example_text, ErrorKind::usage), "\"=3\" is not KEY=VALUE with a key like method.tolerance");
  EXPECT_EQ(message_of({"time..end=3"}, example_text, ErrorKind::usage),
            "\"time..end=3\" is not KEY=VALUE with a key like method.tolerance");
  EXPECT_EQ(message_of({"time end=3"}, example_text, ErrorKind::usage), "\"time end=3\" is not KEY=VALUE with a key like method.tolerance");
  EXPECT_EQ(message_of({"time.end="}), "command line: time.end: no value after the equals sign");
  EXPECT_EQ(message_of({"time.end.x=1"}), "command line: time.end.x: time.end is a value, not a table");
  EXPECT_EQ(message_of({"grid.points=[101"}).substr(0, 41), "command line: grid.points: not valid TOML");
  EXPECT_EQ(message_of({"title=\"A"}).substr(0, 35), "command line: title: not valid TOML");
  EXPECT_EQ(message_of({"time.start=0\nend = 7"}), "command line: time.start: expected a number, got \"0\\nend = 7\"");
}

TEST(CaseErrors, NestingAndSizeAreBounded) {
  std::string deep = "a";
  for (int i = 0; i < 200000; ++i) deep += ".a";
  EXPECT_EQ(message_of({}, deep + " = 1\n"), "bz.toml:1: a key has more than 1000 parts");
  EXPECT_EQ(message_of({}, "\nx = { " + deep + " = 1 }\n"), "bz.toml:2: a key has more than 1000 parts");
  EXPECT_EQ(message_of({deep + "=1"}, example_text, ErrorKind::usage).substr(0, 7), "\"a.a.a.");
  EXPECT_EQ(message_of({}, std::string(std::size_t{1} << 21, '\n')), "bz.toml: the file has 2097152 bytes, a case file at most 1048576");
  EXPECT_EQ(message_of({}, "x = " + std::string(100000, '[')).substr(0, 26), "bz.toml:1: not valid TOML:");
}

TEST(CaseErrors, LongValuesAreCutInMessages) {
  const std::string message = message_of({"time.end=" + std::string(5000, 'x')});
  EXPECT_LT(message.size(), 130U);
  EXPECT_EQ(message.substr(message.size() - 6), "xxx...");
}

}  // namespace
}  // namespace stiffront::app
