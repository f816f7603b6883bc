// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include "schema.hpp"
#include "stiffront/app/case_file.hpp"
#include "stiffront/app/methods.hpp"

namespace stiffront::app {
namespace {

constexpr const char* introduction = R"(# The case file

<!-- Made by the program from the table that parses case files: stiffront input-reference > docs/input.md -->

A run is described by one TOML file. Every entry of it can also be given on the command line:

    stiffront run bz.toml time.end=0.5 method.tolerance=1e-8 'initial.a=exp(-x^2)'

`KEY=VALUE` replaces what the file says at the dotted path KEY, a whole table included; several are applied from left to
right. VALUE is TOML; what is no TOML is taken as text, so a word needs no quotation marks.

An unknown key is an error, as is a key of another method. `stiffront check CASE.toml` prints the complete case with every
default filled in; `stiffront case NAME` prints a built-in one to start from. A number may be written as an integer; `nan`
and `inf` are refused. Lengths and times are in the units of the model. An expression is text in quotation marks, with
`+ - * / ^`, parentheses, comparisons, `if(condition, a, b)`, `min max abs sqrt exp log log10 sin cos tan asin acos atan
sinh cosh tanh pow`, `pi` and `e`.
)";

std::string table_cell(const std::string& text) {
  std::string cell;
  for (const char c : text) {
    if (c == '|') cell += '\\';
    cell += c;
  }
  return cell;
}

std::string default_text(const Key& key, const Case& defaults) {
  if (key.required) return "required";
  if (!key.default_note.empty()) return table_cell(key.default_note);
  return fmt::format("`{}`", table_cell(key.write(defaults)));
}

std::string row(const Key& key, const Case& defaults) {
  std::string name = key.path.substr(key.path.find('.') + 1);
  if (name == "*") name = "SPECIES";
  return fmt::format("| `{}` | {} | {} | {} |\n", name, table_cell(key.expected), default_text(key, defaults), table_cell(key.doc));
}

constexpr const char* table_head = "\n| key | value | default | meaning |\n| --- | --- | --- | --- |\n";

}  // namespace

std::string input_reference() {
  std::string text = introduction;
  std::string heading;
  for (const Key& key : schema()) {
    Case defaults;
    defaults.converge.emplace();
    std::string its_heading;
    if (key.path == "title") {
      its_heading = "\n## At the top\n";
    } else if (!key.method.empty()) {
      for (const MethodEntry& entry : methods()) {
        if (entry.name != key.method) continue;
        defaults.method = entry.defaults;
        its_heading = fmt::format("\n### `{}`\n\n{} ({}).\n", entry.name, entry.description, entry.source);
      }
    } else {
      its_heading = fmt::format("\n## [{}]\n", key.section());
    }
    if (its_heading != heading) text += its_heading + table_head;
    heading = its_heading;
    text += row(key, defaults);
  }
  return text;
}

}  // namespace stiffront::app
