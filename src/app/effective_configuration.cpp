// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include "schema.hpp"
#include "stiffront/app/case_file.hpp"
#include "stiffront/app/methods.hpp"

namespace stiffront::app {

std::string effective_configuration(const Case& c) {
  std::string text;
  std::string section;
  std::string table;  // a table inside a section is written inline once it is complete
  std::string table_entries;
  const auto end_table = [&] {
    if (!table_entries.empty()) text += fmt::format("{} = {{ {} }}\n", table, table_entries);
    table_entries.clear();
  };
  for (const Key& key : schema()) {
    if (!applies(key, method_name(c.method)) || (key.section() == "converge" && !c.converge)) continue;
    const std::string value = key.write(c);
    if (value.empty()) continue;
    const std::size_t first_dot = key.path.find('.');
    const std::size_t last_dot = key.path.rfind('.');
    const std::string name = key.path.substr(last_dot + 1);
    const std::string its_table = first_dot == last_dot ? "" : key.path.substr(first_dot + 1, last_dot - first_dot - 1);
    if (its_table != table || key.section() != section) end_table();
    table = its_table;
    if (first_dot != std::string::npos && key.section() != section) {
      section = key.section();
      text += fmt::format("{}[{}]\n", text.empty() ? "" : "\n", section);
    }
    if (!table.empty()) {
      table_entries += fmt::format("{}{} = {}", table_entries.empty() ? "" : ", ", name, value);
    } else {
      text += key.entry_per_line ? value : fmt::format("{} = {}\n", name, value);
    }
  }
  end_table();
  return text;
}

}  // namespace stiffront::app
