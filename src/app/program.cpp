// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/app/program.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "guidance.hpp"
#include "job.hpp"
#include "memory_limit.hpp"
#include "plot.hpp"
#include "stiffront/app/builtin_cases.hpp"
#include "stiffront/app/case_source.hpp"
#include "stiffront/app/command_line.hpp"
#include "stiffront/app/convergence.hpp"
#include "stiffront/app/methods.hpp"
#include "stiffront/app/simulation.hpp"
#include "stiffront/app/stability.hpp"
#include "stiffront/core/error.hpp"
#include "stiffront/core/spelling.hpp"
#include "stiffront/io/info.hpp"

namespace stiffront::app {
namespace {

void print(const std::string& text) {
  if (!speaks_without_mpi()) return;
  const bool written = std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0;
  if (!written) throw Error(ErrorKind::io, fmt::format("standard output: {}", std::strerror(errno)));
}

std::string case_list(const std::vector<ModelDescription>& models) {
  std::string text;
  for (const BuiltinCase& c : builtin_cases()) {
    const Case parsed = parse_case({std::string(c.name), std::string(c.text), {}}, models);
    text += fmt::format("{:<26} {}\n", c.name, parsed.title);
  }
  return text;
}

std::string model_list(const std::vector<ModelDescription>& models) {
  std::string text;
  for (const ModelDescription& m : models) {
    std::vector<std::string> profiles;
    for (const auto& profile : m.profiles) profiles.push_back(profile.name);
    text += fmt::format("{:<26} {}; species {}; {}\n", m.name, m.source, comma_list(m.species),
                        profiles.empty() ? "no profiles" : "profiles " + comma_list(profiles));
  }
  return text;
}

std::string method_list() {
  std::string text;
  for (const MethodEntry& m : methods()) text += fmt::format("{:<26} {}; {}\n", m.name, m.description, m.source);
  return text;
}

/// Does what a command asks for; throws Error.
class Obey {
 public:
  Obey(int& argc, char**& argv, const ModelRegistry& models) : argc_(argc), argv_(argv), models_(models) {}

  int operator()(const AnswerCommand& command) const { return said(command.text + "\n"); }
  int operator()(const InputReferenceCommand&) const { return said(input_reference()); }
  int operator()(const ManualCommand&) const { return said(manual_page()); }
  int operator()(const CompletionCommand&) const { return said(bash_completion()); }

  int operator()(const CheckCommand& command) const {
    const CaseSource source = read_case_source(command.source.file, command.source.overrides);
    const Case c = parse_case(source, models_.descriptions());
    said(effective_configuration(c));
    // Not part of the case: what a reader wants to know, a program that reads the case does not.
    return run_on_all_ranks(argc_, argv_, [&](const Communicator& comm) {
      const Communicator self(MPI_COMM_SELF);
      if (!comm.is_root()) return;
      std::string text;
      for (const std::string& line : guidance(c, models_, self)) text += "# " + line + "\n";
      std::fputs(text.c_str(), stderr);
    });
  }

  int operator()(const ListCommand& command) const {
    const auto models = models_.descriptions();
    if (command.what == "cases") return said(case_list(models));
    if (command.what == "models") return said(model_list(models));
    if (command.what == "methods") return said(method_list());
    return said(fmt::format("cases\n\n{}\nmodels\n\n{}\nmethods\n\n{}", case_list(models), model_list(models), method_list()));
  }

  int operator()(const CaseCommand& command) const {
    std::vector<std::string> names;
    for (const BuiltinCase& c : builtin_cases()) {
      if (c.name == command.name) return said(std::string(c.text));
      names.emplace_back(c.name);
    }
    throw Error(ErrorKind::usage,
                fmt::format("unknown case {}{}", command.name, with_allowed(suggestion(command.name, names), " cases", names)));
  }

  int operator()(const InfoCommand& command) const { return said(describe_file(command.file)); }

  int operator()(const PlotCommand& command) const {
    if (speaks_without_mpi()) plot(command);
    return 0;
  }
  int operator()(const ReportCommand& command) const {
    if (speaks_without_mpi()) report(command);
    return 0;
  }

  int operator()(const RunCommand& command) const { return on_all_ranks(command.source, command.run, simulate); }
  int operator()(const StabilityCommand& command) const {
    return run_on_all_ranks(argc_, argv_, [&](const Communicator& comm) {
      if (comm.is_root()) print(measure_stability(command, models_.descriptions()));
    });
  }
  int operator()(const ConvergeCommand& command) const { return on_all_ranks(command.source, command.run, run_convergence); }

 private:
  using Run = void (*)(const Case&, const ModelRegistry&, const Communicator&, const RunOptions&);

  int on_all_ranks(const CaseArguments& source, const RunArguments& arguments, Run run) const {
    RunOptions options;
    options.restart = arguments.restart;
    options.force = arguments.force;
    options.quiet = arguments.quiet;
    options.progress = arguments.progress == "always"  ? ProgressMode::always
                       : arguments.progress == "never" ? ProgressMode::never
                                                       : ProgressMode::automatic;
    return run_on_all_ranks(argc_, argv_, [&](const Communicator& comm) {
      const Case c = parse_case(read_case_source(source.file, source.overrides, comm), models_.descriptions());
      require_memory(c, comm);
      run(c, models_, comm, options);
    });
  }

  static int said(const std::string& text) {
    print(text);
    return 0;
  }

  int& argc_;
  char**& argv_;
  const ModelRegistry& models_;
};

}  // namespace

int run(int argc, char** argv, const ModelRegistry& models) {
  try {
    return std::visit(Obey(argc, argv, models), parse_command_line(argc, argv));
  } catch (const Error& error) {
    // Under mpirun every process fails alike. The silent ones leave the verdict to the one that speaks: the launcher kills the job at the
    // first failure it sees, which might be before the message is out.
    if (!speaks_without_mpi()) return 0;
    complain(error.what());
    return error.exit_status();
  } catch (const std::exception& error) {
    complain(fmt::format("a bug of the program: {}", error.what()));
    return static_cast<int>(ErrorKind::bug);
  }
}

int run(int argc, char** argv) {
  ModelRegistry models;
  register_builtin_models(models);
  return run(argc, argv, models);
}

}  // namespace stiffront::app
