// SPDX-License-Identifier: BSD-3-Clause
#include "plot.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <vector>

#include "stiffront/core/error.hpp"

namespace stiffront::app {
namespace {

std::filesystem::path find_script(const char* name) {
  std::error_code error;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", error);
  const std::filesystem::path installed = program.parent_path() / "../share/stiffront/plot" / name;
  const std::filesystem::path in_sources = std::filesystem::path(STIFFRONT_PLOT_FOLDER) / name;
  for (const std::filesystem::path& script : {installed, in_sources}) {
    if (std::filesystem::exists(script, error)) return script;
  }
  throw Error(ErrorKind::io, fmt::format("the script is neither {} nor {}", installed.lexically_normal().string(), in_sources.string()));
}

/// @tparam Command with directory, species and output
template <class Command>
[[noreturn]] void become(const char* script, const Command& command) {
  std::vector<std::string> words = {"python3", find_script(script).string(), command.directory};
  if (command.species) words.insert(words.end(), {"--species", *command.species});
  if (command.output) words.insert(words.end(), {"-o", *command.output});
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  execvp(arguments[0], arguments.data());
  throw Error(
      ErrorKind::io,
      fmt::format("python3, which draws the pictures, cannot be started: {} (Debian: apt-get install python3-h5py python3-matplotlib)",
                  std::strerror(errno)));
}

}  // namespace

void plot(const PlotCommand& command) { become("plot.py", command); }

void report(const ReportCommand& command) { become("report.py", command); }

}  // namespace stiffront::app
