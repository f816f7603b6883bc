// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/app/command_line.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>

#include "stiffront/core/error.hpp"
#include "stiffront/core/spelling.hpp"
#include "toml_text.hpp"

namespace stiffront::app {
namespace {

constexpr const char* footer = R"(
Exit status: 0 done, 2 wrong command line, 3 bad case file or input, 4 numerical failure, 5 a file could not be read or
written, 6 MPI failure, 70 a bug of the program, 75 stopped early on request with a valid checkpoint: run again.)";

constexpr const char* case_description = "case file, or the name of a built-in case";

/// What every option writes into; one for all commands, since one command is given.
struct Arguments {
  CaseArguments source;
  RunArguments run;
  std::string output;
  std::string what;
  std::string name;
  std::string species;
  StabilityCommand stability;
};

void add_case(CLI::App& command, Arguments& arguments) {
  command.add_option("CASE.toml", arguments.source.file, case_description)->required();
  command.add_option("KEY=VALUE", arguments.source.overrides,
                     "replaces an entry of the case file, as in time.end=0.5; VALUE is TOML or a bare word");
}

void add_output_directory(CLI::App& command, Arguments& arguments) {
  command.add_option("-o,--output", arguments.output, "directory of the results, instead of output.directory")->type_name("DIR");
  command.add_flag("--force", arguments.run.force, "overwrite the results of another run in that directory");
  command.add_flag("--quiet", arguments.run.quiet, "print nothing but errors");
}

void add_run(CLI::App& app, Arguments& arguments) {
  CLI::App& command = *app.add_subcommand("run", "Solve a case. mpirun -n N stiffront run ... solves it on N processes.");
  add_case(command, arguments);
  add_output_directory(command, arguments);
  command.add_option("--restart", arguments.run.restart, "continue from the latest checkpoint, or from that in DIR")
      ->type_name("latest|DIR");
  command.add_option("--progress", arguments.run.progress, "auto: on a terminal")
      ->check(CLI::IsMember({"auto", "always", "never"}))
      ->type_name("auto|always|never");
}

void add_commands(CLI::App& app, Arguments& arguments) {
  add_run(app, arguments);
  CLI::App* command = app.add_subcommand(
      "check", "Validate a case; print the complete case, defaults filled in, as TOML, and on standard error what to expect of it.");
  add_case(*command, arguments);
  command = app.add_subcommand("converge", "Measure the order of a method: the study [converge] of the case.");
  add_case(*command, arguments);
  add_output_directory(*command, arguments);
  command = app.add_subcommand("stability",
                               "Measure the domain of stability of sdc: area, real axis and strip, from its amplification matrices.");
  command->add_option("KEY=VALUE", arguments.source.overrides,
                      "keys of method sdc, as in nodes=gauss-legendre node_count=6 starting_order=2");
  command->add_option("--implicit-real", arguments.stability.implicit_real, "part of Re z that is implicit; default 1")->type_name("D");
  command->add_option("--implicit-imaginary", arguments.stability.implicit_imaginary, "part of Im z that is implicit; default 0")
      ->type_name("D");
  command->add_option("-o,--output", arguments.output, "directory for stability.json, which stiffront plot draws")->type_name("DIR");
  command = app.add_subcommand("list", "List what is built in, one line each with its source.");
  command->add_option("WHAT", arguments.what, "cases, models or methods; all without it")
      ->check(CLI::IsMember({"cases", "models", "methods"}))
      ->type_name("");
  command = app.add_subcommand("case", "Print a built-in case file, to start one of your own.");
  command->add_option("NAME", arguments.name, "see stiffront list cases")->required();
  command = app.add_subcommand("info", "Say what is in a result or checkpoint file.");
  command->add_option("FILE.h5", arguments.name, "result or checkpoint file")->required();
  command = app.add_subcommand("plot", "Draw the results in a directory: species, step sizes, errors; or an animation; or an order study.");
  command->add_option("DIR", arguments.name, "output directory of a run")->required();
  command->add_option("--species", arguments.species, "draw this species only")->type_name("S");
  command->add_option("-o,--output", arguments.output, "picture to write: .png, .svg, or an animation .gif, .mp4")->type_name("F");
  command = app.add_subcommand("report", "Write one HTML file about the run in a directory, pictures and tables in it.");
  command->add_option("DIR", arguments.name, "output directory of a run")->required();
  command->add_option("--species", arguments.species, "show these species only")->type_name("S");
  command->add_option("-o,--output", arguments.output, "file to write, instead of DIR/report.html")->type_name("F");
  app.add_subcommand("manual-page", "Print the manual page.")->group("");
  app.add_subcommand("bash-completion", "Print the completion for bash.")->group("");
  app.add_subcommand("input-reference", "Print the reference of all keys of a case file in Markdown.")->group("");
}

std::optional<std::string> if_given(const std::string& text) { return text.empty() ? std::nullopt : std::optional(text); }

CaseArguments source_of(const Arguments& arguments) {
  CaseArguments source = arguments.source;
  if (!arguments.output.empty()) source.overrides.push_back("output.directory=" + toml_text(arguments.output));
  return source;
}

Command command_of(const std::string& name, const Arguments& arguments) {
  if (name == "run") return RunCommand{source_of(arguments), arguments.run};
  if (name == "check") return CheckCommand{arguments.source};
  if (name == "converge") return ConvergeCommand{source_of(arguments), arguments.run};
  if (name == "stability") {
    StabilityCommand stability = arguments.stability;
    stability.overrides = arguments.source.overrides;
    stability.output = arguments.output;
    return stability;
  }
  if (name == "list") return ListCommand{arguments.what};
  if (name == "case") return CaseCommand{arguments.name};
  if (name == "info") return InfoCommand{arguments.name};
  if (name == "plot") return PlotCommand{arguments.name, if_given(arguments.species), if_given(arguments.output)};
  if (name == "report") return ReportCommand{arguments.name, if_given(arguments.species), if_given(arguments.output)};
  if (name == "manual-page") return ManualCommand{};
  if (name == "bash-completion") return CompletionCommand{};
  return InputReferenceCommand{};
}

/// Commands for those who build and package the program.
bool is_hidden(const std::string& name) { return name == "input-reference" || name == "manual-page" || name == "bash-completion"; }

[[noreturn]] void refuse(const std::string& command, const std::string& problem) {
  const std::string program = command.empty() ? "stiffront" : "stiffront " + command;
  throw Error(ErrorKind::usage, fmt::format("{}; see {} --help", problem, program));
}

/// Names of visible commands, or of the options of one.
std::vector<std::string> command_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App* c) { return !c->get_group().empty(); })) {
    names.push_back(command->get_name());
  }
  return names;
}
std::vector<std::string> option_names(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

}  // namespace

std::vector<CommandHelp> command_help() {
  CLI::App app;
  Arguments arguments;
  add_commands(app, arguments);
  std::vector<CommandHelp> all;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App* c) { return !c->get_group().empty(); })) {
    CommandHelp help{command->get_name(), command->get_description(), {}, {}};
    for (const CLI::Option* option : command->get_options()) {
      if (option->get_name() == "--help") continue;
      if (option->get_positional()) {
        help.positionals.push_back({option->get_name(true), "", option->get_description()});
      } else {
        std::string value = option->get_expected_max() > 0 ? option->get_type_name() : "";
        value.resize(std::min(value.size(), value.find(':')));  // CLI11 adds what a check allows
        help.options.push_back({option->get_name(false, true), value, option->get_description()});
      }
    }
    all.push_back(std::move(help));
  }
  return all;
}

Command parse_command_line(int argc, const char* const* argv) {
  CLI::App app("Stiffront solves stiff reaction-diffusion equations on many processes.", "stiffront");
  app.footer(footer);
  app.require_subcommand(0, 1);
  app.set_version_flag("--version", version_text(), "print version, compiler and libraries");
  Arguments arguments;
  add_commands(app, arguments);

  const std::string first = argc > 1 ? argv[1] : "";
  const std::vector<std::string> commands = command_names(app);
  if (first.empty()) refuse("", "no command given; commands: " + comma_list(commands));
  const bool is_command = std::find(commands.begin(), commands.end(), first) != commands.end();
  if (first[0] != '-' && !is_command && !is_hidden(first)) {
    refuse("", "unknown command " + first + with_allowed(suggestion(first, commands), " commands", commands));
  }
  const CLI::App* command = nullptr;
  try {
    app.parse(argc, argv);
    if (!app.get_subcommands().empty()) command = app.get_subcommands().front();
  } catch (const CLI::CallForHelp&) {
    return AnswerCommand{app.help()};
  } catch (const CLI::CallForVersion&) {
    return AnswerCommand{version_text()};
  } catch (const CLI::ExtrasError&) {
    const CLI::App& parsed = app.get_subcommands().empty() ? app : *app.get_subcommands().front();
    const std::vector<std::string> extras = app.remaining(true);
    refuse(&parsed == &app ? "" : parsed.get_name(), fmt::format("unexpected argument {}{}", extras.empty() ? "" : extras.front(),
                                                                 suggestion(extras.empty() ? "" : extras.front(), option_names(parsed))));
  } catch (const CLI::ParseError& error) {
    refuse(app.get_subcommands().empty() ? "" : app.get_subcommands().front()->get_name(), error.what());
  }
  if (command == nullptr) refuse("", "no command given; commands: " + comma_list(commands));
  return command_of(command->get_name(), arguments);
}

}  // namespace stiffront::app
