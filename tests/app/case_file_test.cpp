// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/app/case_file.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "app/example_case.hpp"
#include "stiffront/app/methods.hpp"

namespace stiffront::app {
namespace {

TEST(CaseFile, EntriesOfTheFileArrive) {
  const Case c = parse_example();
  EXPECT_EQ(c.title, "A wave");
  EXPECT_EQ(c.grid.points, std::vector<std::int64_t>{101});
  EXPECT_EQ(c.model.name, "bz");
  EXPECT_EQ(c.initial.profile, "bz-front");
  EXPECT_EQ(c.time.end, 2.0);
  EXPECT_EQ(std::get<AdaptiveStrangOptions>(c.method).tolerance, 1e-5);
  EXPECT_EQ(c.file, "bz.toml");
  EXPECT_EQ(c.text, example_text);
}

TEST(CaseFile, DefaultsAreFilledInFromTheModelAndTheGrid) {
  const Case c = parse_example();
  EXPECT_EQ(c.grid.lower, std::vector<double>{0.0});
  EXPECT_EQ(c.grid.upper, std::vector<double>{1.0});
  EXPECT_EQ(c.grid.processes, std::vector<std::int64_t>{0});
  EXPECT_EQ(c.space.quadrature_order, 2);
  EXPECT_EQ(c.model.species, (std::vector<std::string>{"a", "b", "c"}));
  EXPECT_EQ(c.model.parameters, (NamedList<double>{{"epsilon", 1e-2}, {"mu", 1e-5}, {"f", 3.0}, {"q", 2e-3}}));
  EXPECT_EQ(c.model.diffusion, (NamedList<Value>{{"a", 2.5e-3}, {"b", 2.5e-3}, {"c", 1.5e-3}}));
  EXPECT_EQ(std::get<AdaptiveStrangOptions>(c.method).species, c.model.species);
  EXPECT_EQ(c.boundary.sides[0][0].kind, BoundaryKind::neumann);
  EXPECT_FALSE(c.converge.has_value());
}

TEST(CaseFile, AMethodChosenOnTheCommandLineDropsTheFilesKeysOfAnother) {
  const Case c = parse_example({"method.step=1e-3", "method.name=strang"});
  EXPECT_EQ(std::get<StrangOptions>(c.method), (StrangOptions{1e-3, SplittingOrder::reaction_last}));
  // The same method again changes nothing.
  EXPECT_EQ(std::get<AdaptiveStrangOptions>(parse_example({"method.name=adaptive-strang"}).method).tolerance, 1e-5);
}

TEST(CaseFile, CustomModelKeepsTheOrderOfItsSpeciesAndOfTheFile) {
  const Case c = parse_example({}, custom_text);
  EXPECT_TRUE(c.model.is_custom());
  EXPECT_EQ(c.model.parameters, (NamedList<double>{{"B", 3.0}, {"A", 1.0}, {"nu", 2e-3}}));
  EXPECT_EQ(c.model.diffusion, (NamedList<Value>{{"u", "nu"}, {"v", 0.0}}));
  EXPECT_EQ(c.model.reaction, (NamedList<std::string>{{"u", "A + u^2*v - (B + 1)*u"}, {"v", "B*u - u^2*v"}}));
  EXPECT_EQ(c.initial.expressions, (NamedList<Value>{{"u", "1 + 0.1*sin(pi*x)"}, {"v", 3.0}}));
  EXPECT_EQ(std::get<StrangOptions>(c.method).step, 1e-3);
}

TEST(CaseFile, ReactionNetworksAreArraysOfTables) {
  const Case c = parse_example({}, network_text);
  ASSERT_EQ(c.model.reactions.size(), 2U);
  EXPECT_EQ(c.model.reactions[0], (ReactionOptions{"2 u + v -> 3 u", 1.0, std::nullopt, true}));
  EXPECT_EQ(c.model.reactions[1], (ReactionOptions{"u <-> 0", "0.1*(1 + x)", Value(0.01), false}));
}

TEST(CaseFile, AReactionNetworkTakesExpressionsForSomeSpeciesBesides) {
  const Case c = parse_example({"model.reaction.v=0.5*(1 - v)"}, network_text);
  EXPECT_EQ(c.model.reaction, (NamedList<std::string>{{"v", "0.5*(1 - v)"}}));
  EXPECT_EQ(c.model.reactions.size(), 2U);
  EXPECT_TRUE(c.same_options(parse_example({}, effective_configuration(c))));
}

TEST(CaseFile, BoundariesAreGivenByAxisOrBySide) {
  const auto& sides = [](const Case& c) { return c.boundary.sides; };
  Case c = parse_example({"boundary.x=periodic"});
  EXPECT_EQ(sides(c)[0][0].kind, BoundaryKind::periodic);
  EXPECT_EQ(sides(c)[0][1].kind, BoundaryKind::periodic);
  c = parse_example({"boundary.x_lower={ type = \"dirichlet\", b = \"sin(t)\", a = 1 }"});
  EXPECT_EQ(sides(c)[0][0].kind, BoundaryKind::dirichlet);
  EXPECT_EQ(sides(c)[0][0].values, (NamedList<Value>{{"a", 1.0}, {"b", "sin(t)"}, {"c", 0.0}}));
  EXPECT_EQ(sides(c)[0][1].kind, BoundaryKind::neumann);
  c = parse_example({"boundary.x_upper=neumann", "boundary.x=dirichlet"});
  EXPECT_EQ(sides(c)[0][0].kind, BoundaryKind::dirichlet);
  EXPECT_EQ(sides(c)[0][1].kind, BoundaryKind::neumann);
}

TEST(CaseFile, MethodsFillInWhatDependsOnOtherKeys) {
  const auto method = [](const std::string& table, const std::vector<std::string>& more = {}) {
    std::vector<std::string> overrides = {"method=" + table};
    overrides.insert(overrides.end(), more.begin(), more.end());
    return parse_example(overrides).method;
  };
  const auto dcs = std::get<DcsOptions>(method(R"({name = "dcs", step = 1e-3, splitting = "strang"})"));
  EXPECT_EQ(dcs.max_iterations, 3);
  EXPECT_EQ(dcs.iterations, 3);
  const auto adaptive_dcs = std::get<DcsOptions>(method(R"({name = "dcs", tolerance = 1e-3, stages = 2})"));
  EXPECT_EQ(adaptive_dcs.max_iterations, 2);
  EXPECT_EQ(adaptive_dcs.iterations, std::nullopt);
  EXPECT_EQ(std::get<SdcOptions>(method(R"({name = "sdc", step = 1e-3})")).corrections, 5);
  EXPECT_EQ(std::get<SdcOptions>(method(R"({name = "sdc", step = 1e-3, nodes = "gauss-legendre"})")).corrections, 6);
  EXPECT_EQ(std::get<SdcOptions>(method(R"({name = "sdc", step = 1e-3, nodes = "gauss-lobatto"})")).corrections, 4);
  const auto sbdf = std::get<SbdfOptions>(method(R"({name = "sbdf", relative_tolerance = 1e-6})"));
  EXPECT_EQ(sbdf.absolute_tolerance, Tolerance(1e-6 / 100.0));
  const auto cvode = std::get<CvodeOptions>(method(R"({name = "cvode", absolute_tolerance = { c = 3e-9, a = 1e-6, b = 2e-8 }})"));
  EXPECT_EQ(cvode.absolute_tolerance, Tolerance(NamedList<double>{{"a", 1e-6}, {"b", 2e-8}, {"c", 3e-9}}));
  EXPECT_EQ(cvode.linear_solver, LinearSolver::gmres);
  EXPECT_EQ(std::get<CvodeOptions>(method(R"({name = "cvode"})", {"grid.points=[9, 9]"})).linear_solver, LinearSolver::gmres);
}

TEST(CaseFile, ConvergeGivesTheStepItStudies) {
  const Case c = parse_example({"converge.steps=[2e-2, 1e-2]", R"(method={name = "dcs"})"});
  EXPECT_EQ(std::get<DcsOptions>(c.method).step, 2e-2);
  ASSERT_TRUE(c.converge.has_value());
  EXPECT_EQ(c.converge->iterations, std::vector<int>{4});
  EXPECT_EQ(c.converge->reference.method, "cvode");
  EXPECT_EQ(c.converge->reference.tolerance, 1e-12);
  EXPECT_EQ(std::get<LieOptions>(parse_example({"converge.steps=[2e-2, 1e-2]", R"(method={name = "lie"})"}).method).step, 2e-2);
}

TEST(Override, ReplacesAddsAndMakesTables) {
  const Case c = parse_example({"time.end=0.5", "output.checkpoint.keep=7", "grid.points=[41]", "model.parameters.q=1e-3"});
  EXPECT_EQ(c.time.end, 0.5);
  EXPECT_EQ(c.output.checkpoint.keep, 7);
  EXPECT_EQ(c.grid.points, std::vector<std::int64_t>{41});
  EXPECT_EQ(c.model.parameters, (NamedList<double>{{"epsilon", 1e-2}, {"mu", 1e-5}, {"f", 3.0}, {"q", 1e-3}}));
  EXPECT_EQ(c.overrides.size(), 4U);
}

TEST(Override, LastOneWins) { EXPECT_EQ(parse_example({"time.end=0.5", "time.end=0.25"}).time.end, 0.25); }

TEST(Override, ReplacesAWholeTable) {
  EXPECT_EQ(parse_example({"model.parameters={ mu = 1e-4 }"}).model.parameters,
            (NamedList<double>{{"epsilon", 1e-2}, {"mu", 1e-4}, {"f", 1.6}, {"q", 2e-3}}));
}

TEST(Override, WhatIsNoTomlIsText) {
  EXPECT_EQ(parse_example({"title=a = b, c"}).title, "a = b, c");
  EXPECT_EQ(parse_example({"title=\"a = b\""}).title, "a = b");
  EXPECT_EQ(parse_example({"title=two words"}).title, "two words");
  EXPECT_EQ(parse_example({"limits.wall_time=3h50m"}).limits.wall_time, 13800.0);
  EXPECT_EQ(parse_example({"output.directory=/tmp/a=b"}).output.directory, "/tmp/a=b");
  const std::vector<std::string> expressions = {"initial={ a = \"exp(-x^2)\", b = 0 }", "initial.c=if(x < 0.5, 1, 0)"};
  EXPECT_EQ(parse_example(expressions).initial.expressions, (NamedList<Value>{{"a", "exp(-x^2)"}, {"b", 0.0}, {"c", "if(x < 0.5, 1, 0)"}}));
}

std::string every_option_text(const std::string& method) {
  std::string text = custom_text;
  text.erase(text.find("[method]"));
  return text + method + R"toml(
[boundary]
x_lower = { type = "dirichlet", u = 0.1, v = "sin(t)*2" }
y = "periodic"
[space]
order = 4
quadrature_order = 2
[diffusion_solver]
tolerance = 1.2345678901234567e-7
[reaction_solver]
name = "cvode"
balance = "off"
positivity = "reject-step"
[output]
directory = "a \"b\" \\ \u00e4\t"
times = [0.1, 0.3, 2.0]
mode = "land"
probes = [[0.25, 1.5], [1, 0]]
checkpoint = { every_seconds = 0.1, every_steps = 3, keep = 5, at_end = true, on_failure = "continue" }
[limits]
wall_time = "3h50m0.7s"
max_steps = 9007199254740993
)toml";
}

struct Named {
  const char* name;
  std::string text;
  std::vector<std::string> overrides;
};

class RoundTrip : public ::testing::TestWithParam<Named> {};

TEST_P(RoundTrip, EffectiveConfigurationGivesTheSameCase) {
  const Case c = parse_example(GetParam().overrides, GetParam().text);
  const std::string text = effective_configuration(c);
  const Case again = parse_example({}, text);
  EXPECT_TRUE(c.same_options(again)) << text;
  EXPECT_EQ(effective_configuration(again), text);
}

INSTANTIATE_TEST_SUITE_P(
    Cases, RoundTrip,
    ::testing::Values(
        Named{"example", example_text, {}}, Named{"custom", custom_text, {}}, Named{"network", network_text, {}},
        Named{"lie", every_option_text("[method]\nname = \"lie\"\nstep = 1e-3\norder = \"diffusion-last\""), {}},
        Named{"strang", every_option_text("[method]\nname = \"strang\"\nstep = 0.1"), {"time.restart_step={period=1, step=1e-9}"}},
        Named{"adaptive_strang",
              every_option_text("[method]\nname = \"adaptive-strang\"\nspecies = [\"v\"]\nbeta = 0.3\ncritical_step = false"),
              {}},
        Named{"dcs", every_option_text("[method]\nname = \"dcs\"\ntolerance = 1e-7\nstep_rule = \"min\"\npredict = false"), {}},
        Named{"dcs_fixed", every_option_text("[method]\nname = \"dcs\"\nstep = 1e-4\niterations = 2\nstages = 5"), {}},
        Named{"sdc",
              every_option_text("[method]\nname = \"sdc\"\nstep = 1e-4\nnodes = \"gauss-lobatto\"\nconsistent = false"),
              {"reaction_solver.positivity=report"}},
        Named{"sbdf", every_option_text("[method]\nname = \"sbdf\"\nabsolute_tolerance = {v = 1e-9, u = 1e-3}\nmax_order = 2"), {}},
        Named{"cvode", every_option_text("[method]\nname = \"cvode\"\nlinear_solver = \"band\""), {"reaction_solver.positivity=report"}},
        Named{"auto", every_option_text("[method]\nname = \"auto\"\ntolerance = 1e-3"), {"time.breakpoints=[0.5, 1.0]"}},
        Named{"converge",
              every_option_text("[method]\nname = \"dcs\""),
              {"converge.steps=[0.1, 0.05]", "converge.iterations=[0, 1]", "converge.kind=local",
               "converge.reference={method = \"sdc\", step = 1e-5}"}},
        Named{"file",
              example_text,
              {"initial={ file = \"out/fields-000120.h5\" }", "converge.steps=[0.1]", "converge.reference.file=ref.h5",
               "method={ name = \"lie\" }"}}),
    [](const auto& info) { return info.param.name; });

TEST(CaseFile, DifferentOptionsAreSeenAsDifferent) {
  EXPECT_TRUE(parse_example().same_options(parse_example()));
  for (const char* change : {"title=B", "grid.points=[102]", "boundary.x=periodic", "space.order=4", "model.parameters.q=1e-9",
                             "initial.profile=bz-ignition", "time.end=3", "method.tolerance=1e-6", "diffusion_solver.tolerance=1e-6",
                             "reaction_solver.tolerance=1e-6", "output.checkpoint.at_end=true", "limits.max_steps=5"}) {
    EXPECT_FALSE(parse_example().same_options(parse_example({change}))) << change;
  }
}

TEST(InputReference, DocumentationIsWhatTheProgramSays) {
  std::ifstream file(STIFFRONT_SOURCE_DIR "/docs/input.md");
  std::stringstream text;
  text << file.rdbuf();
  EXPECT_EQ(text.str(), input_reference()) << "regenerate it: stiffront input-reference > docs/input.md";
}

TEST(Methods, EveryNameGivesItsOwnOptions) {
  for (const MethodEntry& entry : methods()) EXPECT_EQ(method_name(entry.defaults), entry.name);
  EXPECT_EQ(methods().size(), std::variant_size_v<MethodOptions>);
}

}  // namespace
}  // namespace stiffront::app
