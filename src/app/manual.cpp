// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include "schema.hpp"
#include "stiffront/app/command_line.hpp"
#include "stiffront/core/version.hpp"

namespace stiffront::app {
namespace {

/// Text as man reads it: no line begins with a dot, hyphens and backslashes are themselves.
std::string roff(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '-' || c == '\\') result += '\\';
    result += c == '\\' ? std::string("e") : std::string(1, c);
  }
  return result[0] == '.' || result[0] == '\'' ? "\\&" + result : result;
}

std::string synopsis(const CommandHelp& command) {
  std::string text = fmt::format(".B stiffront {}\n", command.name);
  for (const CommandHelp::Entry& p : command.positionals) {
    if (p.name == "KEY=VALUE") {
      text += ".RI [ KEY=VALUE \" ...]\"\n";
    } else if (p.name == "WHAT") {
      text += ".RI [ WHAT ]\n";
    } else {
      text += fmt::format(".I {}\n", roff(p.name));
    }
  }
  if (!command.options.empty()) text += "[options]\n";
  return text;
}

}  // namespace

std::string manual_page() {
  std::string text = fmt::format(".TH STIFFRONT 1 \"\" \"stiffront {}\" \"User Commands\"\n", version::number);
  text += ".SH NAME\nstiffront \\- solve stiff reaction\\-diffusion equations on many processes\n.SH SYNOPSIS\n";
  const std::vector<CommandHelp> commands = command_help();
  for (std::size_t k = 0; k < commands.size(); ++k) text += (k == 0 ? "" : ".br\n") + synopsis(commands[k]);
  text +=
      ".br\n.B stiffront\n.RB [ \\-\\-version | \\-\\-help ]\n.SH DESCRIPTION\n"
      "A case file in TOML describes grid, boundary, model, initial state, method and output.\n"
      ".B stiffront run\nsolves it, on many processes under\n.BR mpirun (1);\nthe result has the same bits on any number of them.\n"
      "Any entry is replaced by\n.I KEY=VALUE\non the command line, and the name of a built\\-in case stands for its file.\n.SH COMMANDS\n";
  for (const CommandHelp& command : commands) {
    text += fmt::format(".SS {}\n{}\n", command.name, roff(command.description));
    for (const std::vector<CommandHelp::Entry>& entries : {command.positionals, command.options}) {
      for (const CommandHelp::Entry& e : entries) {
        text +=
            e.value.empty() ? fmt::format(".TP\n.B {}\n", roff(e.name)) : fmt::format(".TP\n.BI {} \" {}\"\n", roff(e.name), roff(e.value));
        text += roff(e.description) + "\n";
      }
    }
  }
  text += ".SH EXIT STATUS\n";
  const std::pair<const char*, const char*> statuses[] = {
      {"0", "done"},
      {"2", "wrong command line"},
      {"3", "bad case file or input"},
      {"4", "numerical failure"},
      {"5", "a file could not be read or written"},
      {"6", "MPI failure"},
      {"70", "a bug of the program"},
      {"75", "stopped early on request, with a valid checkpoint: run again with --restart latest"}};
  for (const auto& [status, meaning] : statuses) text += fmt::format(".TP\n.B {}\n{}\n", status, roff(meaning));
  text +=
      ".SH SIGNALS\n.TP\n.B SIGUSR1\nwrite a checkpoint and go on\n.TP\n.B SIGUSR2, SIGTERM\nwrite a checkpoint and stop with status 75\n"
      ".SH EXAMPLES\n.nf\nstiffront case bz\\-1d > my.toml\nstiffront check my.toml method.tolerance=1e\\-6\n"
      "mpirun \\-n 2 stiffront run my.toml method.tolerance=1e\\-6 \\-o out\nstiffront plot out\nstiffront report out\nstiffront stability "
      "nodes=gauss\\-legendre node_count=6\n.fi\n"
      ".SH SEE ALSO\n.BR mpirun (1)\n";
  return text;
}

std::string bash_completion() {
  std::string commands;
  std::string options;
  for (const CommandHelp& command : command_help()) {
    commands += (commands.empty() ? "" : " ") + command.name;
    std::string words = "--help";
    for (const CommandHelp::Entry& e : command.options) {
      const std::size_t at = e.name.find("--");
      if (at != std::string::npos) words += " " + e.name.substr(at, e.name.find(',', at) - at);
    }
    options += fmt::format("    {}) options=\"{}\" ;;\n", command.name, words);
  }
  std::string keys;
  for (const Key& key : schema()) {
    if (key.path.ends_with(".*")) continue;
    keys += (keys.empty() ? "" : " ") + key.path + "=";
  }
  return fmt::format(R"bash(# bash completion for stiffront, made by: stiffront bash-completion
_stiffront() {{
  local word=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD-1]}} command=${{COMP_WORDS[1]}} options=""
  local keys="{}"
  if [ "$COMP_CWORD" -eq 1 ]; then
    mapfile -t COMPREPLY < <(compgen -W "{} --version --help" -- "$word")
    return
  fi
  case $command in
{}  esac
  case $before in
    --progress) mapfile -t COMPREPLY < <(compgen -W "auto always never" -- "$word"); return ;;
    --restart) mapfile -t COMPREPLY < <(compgen -W "latest" -- "$word"; compgen -d -- "$word"); return ;;
    -o | --output) mapfile -t COMPREPLY < <(compgen -f -- "$word"); return ;;
  esac
  if [[ $word == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$options" -- "$word")
    return
  fi
  case $command in
    run | check | converge)
      if [ "$COMP_CWORD" -eq 2 ]; then
        mapfile -t COMPREPLY < <(compgen -f -X '!*.toml' -- "$word"; compgen -d -- "$word"
                                 compgen -W "$("${{COMP_WORDS[0]}}" list cases 2>/dev/null | cut -d' ' -f1)" -- "$word")
      else
        compopt -o nospace
        mapfile -t COMPREPLY < <(compgen -W "$keys" -- "$word")
      fi
      ;;
    case) mapfile -t COMPREPLY < <(compgen -W "$("${{COMP_WORDS[0]}}" list cases 2>/dev/null | cut -d' ' -f1)" -- "$word") ;;
    list) mapfile -t COMPREPLY < <(compgen -W "cases models methods" -- "$word") ;;
    info) mapfile -t COMPREPLY < <(compgen -f -X '!*.h5' -- "$word"; compgen -d -- "$word") ;;
    plot | report) mapfile -t COMPREPLY < <(compgen -d -- "$word") ;;
  esac
}}
complete -F _stiffront stiffront
)bash",
                     keys, commands, options);
}

}  // namespace stiffront::app
