// SPDX-License-Identifier: BSD-3-Clause
// What `check` says beforehand and `run` says afterwards.
#include "../../src/app/guidance.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "../../src/app/advice.hpp"
#include "app/example_case.hpp"
#include "stiffront/app/builtin_cases.hpp"
#include "stiffront/control/sbdf.hpp"
#include "stiffront/io/memory.hpp"

namespace stiffront::app {
namespace {

bool says(const std::vector<std::string>& lines, const std::string& part) {
  return std::any_of(lines.begin(), lines.end(), [&part](const std::string& line) { return line.find(part) != std::string::npos; });
}

ModelRegistry all_models() {
  ModelRegistry models;
  register_builtin_models(models);
  return models;
}

std::vector<std::string> guidance_of(const std::vector<std::string>& overrides, const std::string& text) {
  const ModelRegistry models = all_models();
  const Case c = parse_case({"a.toml", text, overrides}, models.descriptions());
  return guidance(c, models, Communicator(MPI_COMM_SELF));
}

std::vector<std::string> questions_of(const std::vector<std::string>& overrides, const std::string& text) {
  return questionable(parse_case({"a.toml", text, overrides}, all_models().descriptions()));
}

TEST(Guidance, FindsTheEigenvaluesOfTheInitialState) {
  // d(u, v)/dt = (-3 u + 40 v, -40 u - 3 v): eigenvalues -3 +- 40 i, and u grows nowhere. D / h^2 = 1e-2 * 100^2, radius 4 D / h^2.
  const std::string text = R"toml([grid]
points = [101]
[model]
name = "custom"
species = ["u", "v"]
diffusion = { u = 1e-2 }
[model.reaction]
u = "-3*u + 40*v"
v = "-40*u - 3*v"
[initial]
u = "x"
v = 1
[time]
end = 1
[method]
name = "sbdf"
)toml";
  const std::vector<std::string> lines = guidance_of({}, text);
  EXPECT_TRUE(says(lines, "101 points x 2 species = 202 unknowns"));
  EXPECT_TRUE(says(lines, "largest eigenvalue 40.1"));
  EXPECT_TRUE(says(lines, "spectral radius 400"));
  EXPECT_TRUE(says(lines, "a step takes about"));
  EXPECT_FALSE(says(lines, "growth"));
  EXPECT_FALSE(says(lines, "warning"));
}

TEST(Guidance, SaysWhereRatesAreNotFinite) {
  EXPECT_TRUE(says(guidance_of({"model.reaction.u=1/(x - 0.25)", "grid.points=[5, 9]"}, custom_text),
                   "warning: the rates or their derivatives are not finite in the initial state at x = 0.25, y = 0"));
}

TEST(Guidance, EveryBuiltInCaseIsLookedAtWithoutAComplaintThatItsStepsFail) {
  const ModelRegistry models = all_models();
  const Communicator self(MPI_COMM_SELF);
  for (const char* name : {"bz-1d", "brusselator-2d", "pulse-1d"}) {
    for (const BuiltinCase& b : builtin_cases()) {
      if (b.name != name) continue;
      const Case c = parse_case({name, std::string(b.text), {}}, models.descriptions());
      const std::vector<std::string> lines = guidance(c, models, self);
      EXPECT_FALSE(says(lines, "no step") || says(lines, "not finite")) << name;
    }
  }
}

TEST(Guidance, WarnsOfErrorControlThatControlsLessThanItSeems) {
  EXPECT_TRUE(questions_of({}, example_text).empty());
  EXPECT_TRUE(says(questions_of({"method.critical_step=false"}, example_text), "warning: method.critical_step=false"));
  EXPECT_TRUE(says(questions_of({"method.species=[\"a\"]"}, example_text), "the error of b, c is not controlled"));
  EXPECT_TRUE(says(questions_of({"method={ name = \"strang\", step = 0.1 }"}, example_text), "controls no error"));
  EXPECT_TRUE(says(questions_of({"method={ name = \"dcs\", step = 0.1 }"}, example_text), "controls no error"));
  EXPECT_TRUE(says(questions_of({"boundary.x_lower={ type = \"dirichlet\", a = 1 }"}, example_text), "loses an order"));
  EXPECT_TRUE(questions_of({"boundary.x_lower={ type = \"dirichlet\", a = 1 }", "method={ name = \"sbdf\" }"}, example_text).empty());
  EXPECT_TRUE(says(guidance_of({"method={ name = \"sbdf\", absolute_tolerance = { a = 1e-6, b = 1e-6, c = 10 } }"}, example_text),
                   "method.absolute_tolerance: c = 10"));
}

TEST(Guidance, QuestionsRatesThatJumpAndParametersThatNothingUses) {
  const std::vector<std::string> plain = {"method={ name = \"sbdf\" }"};
  EXPECT_TRUE(questions_of(plain, custom_text).empty());
  std::vector<std::string> jumps = plain;
  jumps.emplace_back("model.reaction.u=if(t < 0.5, A, B) - u");
  EXPECT_TRUE(says(questions_of(jumps, custom_text), "a rate jumps in time"));
  jumps.emplace_back("time.breakpoints=[0.5]");
  EXPECT_TRUE(questions_of(jumps, custom_text).empty());
  std::vector<std::string> unused = plain;
  unused.emplace_back("model.parameters.Ab=1");
  EXPECT_TRUE(says(questions_of(unused, custom_text), "warning: model.parameters.Ab: no expression uses it"));
}

TEST(Guidance, MemoryIsOneProgramAndSoManyFields) {
  const auto mib = [](const std::vector<std::string>& overrides) {
    return estimated_memory_mib(parse_case({"a.toml", example_text, overrides}, all_models().descriptions()));
  };
  const double one_field = 1048576.0 * 3 * 8 / 1048576.0;
  EXPECT_NEAR(mib({"grid.points=[1048576]"}), 28.0 + 17.5 * one_field, 1.0);
  EXPECT_NEAR(mib({"grid.points=[1024, 1024]", "method={ name = \"dcs\", tolerance = 1e-4, stages = 2 }"}), 28.0 + 16.0 * one_field, 1.0);
}

StepRecord accepted(double error, double dt = 0.1, double critical = 0.0) {
  StepRecord r;
  r.dt = dt;
  r.attempt.accepted = true;
  r.attempt.error = error;
  r.attempt.critical_dt = critical;
  return r;
}

TEST(Advice, AddsUpWhatTheMethodEstimates) {
  ErrorRecord strang(MethodOptions(AdaptiveStrangOptions{}));
  strang.add(accepted(5e-5, 0.1, 0.2));
  strang.add(accepted(1e-5, 0.1, 0.11));
  StepRecord rejected = accepted(1.0);
  rejected.attempt.accepted = false;
  strang.add(rejected);
  EXPECT_DOUBLE_EQ(strang.sum(), 6e-5);
  EXPECT_DOUBLE_EQ(strang.largest(), 5e-5);
  EXPECT_EQ(strang.at_critical_step(), 1);
  // Estimates of multistep methods are in units of the tolerance of a step.
  SbdfOptions options;
  options.relative_tolerance = 1e-6;
  ErrorRecord sbdf((MethodOptions(options)));
  sbdf.add(accepted(0.5));
  EXPECT_DOUBLE_EQ(sbdf.sum(), 0.5 * sbdf_step_tolerance(1e-6));
}

TEST(Advice, TheErrorInSpaceIsThatOfTheDifferences) {
  // cos(k x) on n intervals: order two misses k^2 h^2 / 12 of the second derivative.
  const std::string text = R"toml([grid]
points = [65]
[model]
name = "custom"
species = ["u", "v"]
diffusion = { u = 1.0 }
[model.reaction]
u = 0
v = 0
[initial]
u = "cos(4*pi*x)"
v = "x"
[time]
end = 1
)toml";
  const ModelRegistry models = all_models();
  const Communicator self(MPI_COMM_SELF);
  const double kh = 4.0 * 3.14159265358979 / 64.0;
  for (const int order : {2, 4}) {
    const Case c = parse_case({"a.toml", text, {"space.order=" + std::to_string(order)}}, models.descriptions());
    Problem problem(c, models, self);
    const std::vector<double> error = spatial_error(problem).missed;
    const double expected = order == 2 ? kh * kh / 12.0 : kh * kh * kh * kh / 90.0;
    EXPECT_NEAR(error[0], expected, 0.02 * expected) << order;
    EXPECT_EQ(error[1], 0.0);
  }
}

TEST(Advice, NamesWhatStandsOut) {
  const Case c = parse_example();
  ErrorRecord errors(c.method);
  for (int k = 0; k < 100; ++k) errors.add(accepted(5e-6, 0.1, 0.1));
  Summary summary;
  summary.accepted = 100;
  summary.rejected = 50;
  summary.ranks = 4;
  summary.imbalance = 1.5;
  summary.negatives = 3;
  summary.wall_seconds = {{"communication", 9.0}, {"output", 12.0}, {"total", 20.0}};
  const std::vector<std::string> lines = advice(c, summary, errors, {{0.5, 0.0, 0.0}, 0.0});
  for (const char* part :
       {"sum over 100 steps 0.0005", "miss 50 % of the diffusion of a", "far above the one in time", "33 % of the attempts were rejected",
        "critical splitting step", "imbalance 1.50", "output took long", "waiting for other ranks", "3 states held negative"}) {
    EXPECT_TRUE(says(lines, part));
  }
  summary.rejected = summary.negatives = 0;
  summary.imbalance = 1.0;
  summary.wall_seconds.clear();
  EXPECT_EQ(advice(c, summary, ErrorRecord(c.method), {{0.0, 0.0, 0.0}, 0.0}).size(), 0U);
}

TEST(Advice, SaysWhatToAskForWhereTheErrorAtTheEndIsMoreThanKept) {
  Summary summary;
  summary.final_error = 9e-4;
  const auto says_more = [&](const char* method) {
    const Case c = parse_example({method});
    return advice(c, summary, ErrorRecord(c.method), {{0.0, 0.0, 0.0}, 0.0});
  };
  EXPECT_TRUE(says(says_more("method={name=\"adaptive-strang\", tolerance=1e-4}"), "A run with method.final_error=1 ends nearer to it"));
  EXPECT_FALSE(says(says_more("method={name=\"adaptive-strang\", tolerance=1e-4, final_error=8}"), "ends nearer to it"));
}

TEST(Advice, SaysWhetherTheToleranceOfDcsIsFinerThanTheGridDeserves) {
  const Case c = parse_example({"method={name=\"dcs\", tolerance=1e-6}"});
  ErrorRecord errors(c.method);
  errors.add(accepted(5e-7, 0.1, 0.0));
  Summary summary;
  summary.accepted = 1;
  EXPECT_TRUE(says(advice(c, summary, errors, {{1e-3, 0.0, 0.0}, 1e-4}),
                   "finer than the grid deserves: in a step of 0.1 the error in space is about 1e-05"));
  EXPECT_TRUE(says(advice(c, summary, errors, {{1e-3, 0.0, 0.0}, 1e-6}), "error in space of one step of 0.1: about 1e-07, below"));
}

}  // namespace
}  // namespace stiffront::app
