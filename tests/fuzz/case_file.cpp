// SPDX-License-Identifier: BSD-3-Clause
// libFuzzer: a case file, or after a first line "--KEY=VALUE" that override on top of it, is read or refused in one line, and what was
// read is read again from its complete form.
#include "stiffront/app/case_file.hpp"

#include <cstdint>
#include <cstdlib>
#include <string>

#include "stiffront/core/error.hpp"
#include "stiffront/solvers/model_registry.hpp"

using namespace stiffront;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::vector<ModelDescription> models = [] {
    ModelRegistry registry;
    register_builtin_models(registry);
    return registry.descriptions();
  }();
  std::string text(reinterpret_cast<const char*>(data), size);
  app::CaseSource source{"case.toml", text, {}};
  if (text.starts_with("--")) {
    const std::size_t end = text.find('\n');
    source.overrides.push_back(text.substr(2, end == std::string::npos ? end : end - 2));
    source.text = end == std::string::npos ? "" : text.substr(end + 1);
  }
  app::Case c;
  try {
    c = app::parse_case(source, models);
  } catch (const Error& e) {
    const bool expected = e.kind() == ErrorKind::input || e.kind() == ErrorKind::usage;
    if (!expected || std::string(e.what()).find('\n') != std::string::npos) std::abort();
    return 0;
  }
  if (!c.same_options(app::parse_case({"again.toml", app::effective_configuration(c), {}}, models))) std::abort();
  return 0;
}
