// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace stiffront::app {

/// A case as the command line names it.
struct CaseArguments {
  std::string file;                    ///< a path, or the name of a built-in case
  std::vector<std::string> overrides;  ///< KEY=VALUE
};

/// What the command line says about a run that is no part of the case.
struct RunArguments {
  std::string restart;            ///< "latest", the directory of a checkpoint, or empty
  std::string progress = "auto";  ///< "auto", "always" or "never"
  bool force = false;             ///< results of another run may be overwritten
  bool quiet = false;
};

struct RunCommand {
  CaseArguments source;  ///< -o is the last override, of output.directory
  RunArguments run;
};
struct CheckCommand {
  CaseArguments source;
};
struct ConvergeCommand {
  CaseArguments source;
  RunArguments run;  ///< force and quiet
};
struct StabilityCommand {
  std::vector<std::string> overrides;  ///< KEY=VALUE; keys of [method] with or without their table
  double implicit_real = 1.0;
  double implicit_imaginary = 0.0;
  std::string output;  ///< directory; empty: none
};
struct ListCommand {
  std::string what;  ///< "cases", "models", "methods"; empty: all
};
struct CaseCommand {
  std::string name;
};
struct InfoCommand {
  std::string file;
};
struct PlotCommand {
  std::string directory;
  std::optional<std::string> species;
  std::optional<std::string> output;
};
struct ReportCommand {
  std::string directory;
  std::optional<std::string> species;
  std::optional<std::string> output;
};
struct InputReferenceCommand {};
struct ManualCommand {};
struct CompletionCommand {};
/// --help, --version: the answer itself.
struct AnswerCommand {
  std::string text;
};

using Command = std::variant<RunCommand, CheckCommand, ConvergeCommand, StabilityCommand, ListCommand, CaseCommand, InfoCommand,
                             PlotCommand, ReportCommand, InputReferenceCommand, ManualCommand, CompletionCommand, AnswerCommand>;

/// Needs no MPI.
/// @throws Error(usage) that says what is wrong and what is allowed
Command parse_command_line(int argc, const char* const* argv);

/// What the help of a command says.
struct CommandHelp {
  struct Entry {
    std::string name;   ///< "CASE.toml" or "-o,--output"
    std::string value;  ///< of an option that takes one, "DIR"; otherwise empty
    std::string description;
  };
  std::string name;
  std::string description;
  std::vector<Entry> positionals;
  std::vector<Entry> options;
};

/// Every command but the hidden ones.
std::vector<CommandHelp> command_help();

/// The manual page stiffront(1), in the language of man.
std::string manual_page();

/// Completion of commands, options, built-in cases and keys for bash.
std::string bash_completion();

/// Version, revision, compiler and libraries: what --version prints.
std::string version_text();

}  // namespace stiffront::app
