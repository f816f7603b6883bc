// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/app/case_source.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>

#include "stiffront/app/builtin_cases.hpp"
#include "stiffront/core/agree.hpp"
#include "stiffront/core/error.hpp"
#include "stiffront/core/spelling.hpp"

namespace stiffront::app {
namespace {

std::string read_text(const std::string& name) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(name.c_str(), "rb"), std::fclose);
  const int problem = errno;
  if (!file) {
    std::vector<std::string> builtin;
    for (const BuiltinCase& c : builtin_cases()) {
      if (c.name == name) return std::string(c.text);
      builtin.emplace_back(c.name);
    }
    const std::string hint = with_allowed(suggestion(name, builtin), " built-in cases", builtin);
    throw Error(ErrorKind::io, fmt::format("{}: {}{}", name, std::strerror(problem), hint));
  }
  std::string text;
  char block[65536];
  for (std::size_t n = 0; (n = std::fread(block, 1, sizeof block, file.get())) > 0;) text.append(block, n);
  if (std::ferror(file.get()) != 0) throw Error(ErrorKind::io, fmt::format("{}: {}", name, std::strerror(errno)));
  return text;
}

}  // namespace

CaseSource read_case_source(const std::string& name, const std::vector<std::string>& overrides) {
  return {name, read_text(name), overrides};
}

CaseSource read_case_source(const std::string& name, const std::vector<std::string>& overrides, const Communicator& comm) {
  std::string text;
  collectively(comm, [&] {
    if (comm.is_root()) text = read_text(name);
  });
  return {name, comm.broadcast(text), overrides};
}

}  // namespace stiffront::app
