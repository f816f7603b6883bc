// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/app/command_line.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "stiffront/core/error.hpp"
#include "stiffront/core/version.hpp"

namespace stiffront::app {
namespace {

Command parse(std::vector<const char*> words) {
  words.insert(words.begin(), "stiffront");
  return parse_command_line(static_cast<int>(words.size()), words.data());
}

std::string message_of(const std::vector<const char*>& words) {
  try {
    parse(words);
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::usage);
    return error.what();
  }
  return "no error";
}

TEST(CommandLine, RunTakesACaseOverridesAndOptionsInAnyOrder) {
  const auto run = std::get<RunCommand>(parse({"run", "-o", "my out", "bz.toml", "time.end=0.5", "--force", "grid.points=[5, 6]", "--quiet",
                                               "--restart", "latest", "--progress", "never", "time.start=-1"}));
  EXPECT_EQ(run.source.file, "bz.toml");
  EXPECT_EQ(run.source.overrides,
            (std::vector<std::string>{"time.end=0.5", "grid.points=[5, 6]", "time.start=-1", "output.directory=\"my out\""}));
  EXPECT_TRUE(run.run.force);
  EXPECT_TRUE(run.run.quiet);
  EXPECT_EQ(run.run.restart, "latest");
  EXPECT_EQ(run.run.progress, "never");
}

TEST(CommandLine, RunHasDefaults) {
  const auto run = std::get<RunCommand>(parse({"run", "bz.toml"}));
  EXPECT_TRUE(run.source.overrides.empty());
  EXPECT_FALSE(run.run.force);
  EXPECT_FALSE(run.run.quiet);
  EXPECT_EQ(run.run.restart, "");
  EXPECT_EQ(run.run.progress, "auto");
}

TEST(CommandLine, ValuesWithSpacesAndBracketsStayWhole) {
  const auto check =
      std::get<CheckCommand>(parse({"check", "bz.toml", "initial.a=exp(-x^2) + 1", "title=[a, b]", "model.parameters={ q = 1 }"}));
  EXPECT_EQ(check.source.overrides, (std::vector<std::string>{"initial.a=exp(-x^2) + 1", "title=[a, b]", "model.parameters={ q = 1 }"}));
}

TEST(CommandLine, OtherCommandsHaveTheirArguments) {
  EXPECT_EQ(std::get<ConvergeCommand>(parse({"converge", "a.toml", "-o", "out"})).source.overrides,
            std::vector<std::string>{"output.directory=\"out\""});
  EXPECT_EQ(std::get<ListCommand>(parse({"list"})).what, "");
  EXPECT_EQ(std::get<ListCommand>(parse({"list", "models"})).what, "models");
  EXPECT_EQ(std::get<CaseCommand>(parse({"case", "bz-1d"})).name, "bz-1d");
  EXPECT_EQ(std::get<InfoCommand>(parse({"info", "a.h5"})).file, "a.h5");
  const auto plot = std::get<PlotCommand>(parse({"plot", "out", "--species", "a", "-o", "a.png"}));
  EXPECT_EQ(plot.directory, "out");
  EXPECT_EQ(plot.species, "a");
  EXPECT_EQ(plot.output, "a.png");
  EXPECT_EQ(std::get<PlotCommand>(parse({"plot", "out"})).output, std::nullopt);
  const auto report = std::get<ReportCommand>(parse({"report", "out", "-o", "a.html"}));
  EXPECT_EQ(report.directory, "out");
  EXPECT_EQ(report.output, "a.html");
  EXPECT_EQ(report.species, std::nullopt);
  EXPECT_TRUE(std::holds_alternative<InputReferenceCommand>(parse({"input-reference"})));
}

TEST(CommandLine, HelpAndVersionAreAnswered) {
  const std::string help = std::get<AnswerCommand>(parse({"--help"})).text;
  for (const char* word : {"run", "check", "converge", "stability", "list", "case", "info", "plot", "report", "Exit status"}) {
    EXPECT_NE(help.find(word), std::string::npos) << word;
  }
  EXPECT_EQ(help.find("input-reference"), std::string::npos);
  const std::string run_help = std::get<AnswerCommand>(parse({"run", "--help"})).text;
  for (const char* word : {"CASE.toml", "KEY=VALUE", "--restart", "--force", "--quiet", "--progress", "-o,--output"}) {
    EXPECT_NE(run_help.find(word), std::string::npos) << word;
  }
  const std::string version = std::get<AnswerCommand>(parse({"--version"})).text;
  EXPECT_EQ(version.find(std::string("stiffront ") + version::number), 0U);
  for (const char* word : {version::git_hash, version::compiler, "MPI", "HDF5", "SUNDIALS", "denormals flushed"}) {
    EXPECT_NE(version.find(word), std::string::npos) << word;
  }
}

TEST(CommandLine, MistakesAreExplained) {
  const std::string commands = "run, check, converge, stability, list, case, info, plot, report";
  EXPECT_EQ(message_of({}), "no command given; commands: " + commands + "; see stiffront --help");
  EXPECT_EQ(message_of({"rnu"}), "unknown command rnu; did you mean run? Allowed commands: " + commands + "; see stiffront --help");
  EXPECT_EQ(message_of({"xyzzy"}), "unknown command xyzzy; allowed commands: " + commands + "; see stiffront --help");
  EXPECT_EQ(message_of({"--frobnicate"}), "unexpected argument --frobnicate; see stiffront --help");
  EXPECT_EQ(message_of({"run"}), "CASE.toml is required; see stiffront run --help");
  EXPECT_EQ(message_of({"run", "a.toml", "--forse"}), "unexpected argument --forse; did you mean --force?; see stiffront run --help");
  EXPECT_EQ(message_of({"run", "a.toml", "--progress", "maybe"}), "--progress: maybe not in {auto,always,never}; see stiffront run --help");
  EXPECT_EQ(message_of({"run", "a.toml", "-o"}), "--output: 1 required DIR missing; see stiffront run --help");
  EXPECT_EQ(message_of({"list", "modls"}), "WHAT: modls not in {cases,models,methods}; see stiffront list --help");
  EXPECT_EQ(message_of({"case", "a", "b"}), "unexpected argument b; see stiffront case --help");
}

std::string content_of(const std::string& path) {
  std::ifstream file(std::string(STIFFRONT_SOURCE_DIR) + "/" + path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

TEST(Packaging, ManualPageAndCompletionAreWhatTheProgramSays) {
  EXPECT_EQ(content_of("packaging/stiffront.1"), manual_page()) << "make it again: stiffront manual-page > packaging/stiffront.1";
  EXPECT_EQ(content_of("packaging/completion/stiffront"), bash_completion())
      << "make it again: stiffront bash-completion > packaging/completion/stiffront";
}

TEST(Packaging, HelpIsKnownForEveryCommand) {
  const std::vector<CommandHelp> commands = command_help();
  ASSERT_EQ(commands.size(), 9U);
  EXPECT_EQ(commands[0].name, "run");
  ASSERT_EQ(commands[0].options.size(), 5U);
  EXPECT_EQ(commands[0].options[0].name, "-o,--output");
  EXPECT_EQ(commands[0].options[0].value, "DIR");
  EXPECT_EQ(commands[0].options[1].value, "");
  EXPECT_EQ(commands[0].options[4].value, "auto|always|never");
  EXPECT_EQ(commands[7].positionals[0].name, "DIR");
}

}  // namespace
}  // namespace stiffront::app
