// SPDX-License-Identifier: BSD-3-Clause
#include "config_node.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cctype>
#include <optional>
#include <sstream>
#include <tuple>

#include "stiffront/core/error.hpp"
#include "toml_text.hpp"

namespace stiffront::app {
namespace {

constexpr std::size_t max_text_size = std::size_t{1} << 20;
constexpr std::size_t max_dots_in_a_row = 1000;

[[noreturn]] void fail(const std::string& message) { throw Error(ErrorKind::input, message); }

/// toml++ builds one table inside the other for every part of a dotted key and takes them apart by recursion: a key of
/// a hundred thousand parts would exhaust the stack.
void check_nesting(const std::string& text, const std::string& file) {
  std::size_t line = 1;
  std::size_t dots = 0;
  for (const char c : text) {
    if (c == '\n') ++line;
    if (c == '.') ++dots;
    if (c == '\n' || c == '=' || c == ',' || c == '{' || c == '[') dots = 0;
    if (dots > max_dots_in_a_row) fail(fmt::format("{}:{}: a key has more than {} parts", file, line, max_dots_in_a_row));
  }
}

template <typename T>
std::string streamed(const T& x) {
  std::ostringstream stream;
  stream << x;
  return stream.str();
}

/// As compilers and editors write it: FILE:LINE:COLUMN. What dotted keys and overrides imply stands nowhere.
std::string place(const std::string& file, const toml::source_position& at) {
  return at.line > 0 ? fmt::format("{}:{}:{}", file, at.line, at.column) : file;
}

ConfigNode convert(const toml::node& node, const std::string& file) {
  ConfigNode result;
  result.origin = place(file, node.source().begin);
  if (const auto* boolean = node.as_boolean()) {
    result.type = ConfigNode::Type::boolean;
    result.boolean = boolean->get();
  } else if (const auto* integer = node.as_integer()) {
    result.type = ConfigNode::Type::integer;
    result.integer = integer->get();
  } else if (const auto* number = node.as_floating_point()) {
    result.type = ConfigNode::Type::number;
    result.number = number->get();
  } else if (const auto* string = node.as_string()) {
    result.type = ConfigNode::Type::string;
    result.string = string->get();
  } else if (const auto* array = node.as_array()) {
    result.type = ConfigNode::Type::array;
    for (const toml::node& element : *array) result.elements.push_back(convert(element, file));
  } else if (const auto* table = node.as_table()) {
    result.type = ConfigNode::Type::table;
    struct Entry {
      toml::source_position position;
      const toml::key* key;
      const toml::node* value;
    };
    std::vector<Entry> order;  // toml++ sorts by name, people do not
    for (auto&& [key, value] : *table) order.push_back({key.source().begin, &key, &value});
    std::stable_sort(order.begin(), order.end(), [](const Entry& a, const Entry& b) {
      return std::tie(a.position.line, a.position.column) < std::tie(b.position.line, b.position.column);
    });
    for (const Entry& entry : order) {
      ConfigNode value = convert(*entry.value, file);
      if (entry.position.line > 0) value.origin = place(file, entry.position);
      result.entries.push_back({std::string(entry.key->str()), std::move(value)});
    }
  } else {
    result.type = ConfigNode::Type::date;
    node.visit([&result](const auto& value) {
      if constexpr (!toml::is_container<decltype(value)>) result.string = streamed(value.get());
    });
  }
  return result;
}

/// The node of "value = VALUE", or nothing if VALUE is not one TOML value.
std::optional<ConfigNode> parse_value(const std::string& value, std::string& problem) {
  try {
    const toml::table table = toml::parse("value = " + value);
    if (table.size() != 1) {
      problem = "more than one value";
      return std::nullopt;
    }
    return convert(*table.get("value"), "command line");
  } catch (const toml::parse_error& error) {
    problem = one_line(error.description());
    return std::nullopt;
  }
}

void set_origin(ConfigNode& node, const std::string& origin) {
  node.origin = origin;
  for (ConfigNode& element : node.elements) set_origin(element, origin);
  for (auto& [key, value] : node.entries) set_origin(value, origin);
}

std::vector<std::string> key_parts(const std::string& key) {
  std::vector<std::string> parts(1);
  for (const char c : key) {
    if (c == '.') {
      parts.emplace_back();
    } else if (std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-') {
      parts.back() += c;
    } else {
      return {};
    }
  }
  const bool complete = std::none_of(parts.begin(), parts.end(), [](const std::string& part) { return part.empty(); });
  return complete && parts.size() <= max_dots_in_a_row ? parts : std::vector<std::string>{};
}

void append_text(const ConfigNode& node, std::string& text) {
  constexpr std::size_t limit = 60;
  if (text.size() > limit) return;
  switch (node.type) {
    case ConfigNode::Type::boolean:
      text += toml_text(node.boolean);
      break;
    case ConfigNode::Type::integer:
      text += toml_text(node.integer);
      break;
    case ConfigNode::Type::number:
      text += toml_text(node.number);
      break;
    case ConfigNode::Type::string:
      text += toml_text(node.string);
      break;
    case ConfigNode::Type::date:
      text += node.string;
      break;
    case ConfigNode::Type::array:
      text += '[';
      for (const ConfigNode& element : node.elements) {
        if (&element != &node.elements.front()) text += ", ";
        append_text(element, text);
      }
      text += ']';
      break;
    case ConfigNode::Type::table:
      text += '{';
      for (const auto& entry : node.entries) {
        text += &entry != &node.entries.front() ? ", " : " ";
        text += toml_key(entry.key) + " = ";
        append_text(entry.node, text);
      }
      text += node.entries.empty() ? "}" : " }";
      break;
  }
}

}  // namespace

const ConfigNode* ConfigNode::find(std::string_view key) const {
  for (const auto& [name, value] : entries) {
    if (name == key) return &value;
  }
  return nullptr;
}

ConfigNode* ConfigNode::find(std::string_view key) { return const_cast<ConfigNode*>(static_cast<const ConfigNode*>(this)->find(key)); }

std::string one_line(std::string_view text) {
  std::string line;
  for (const char c : text) {
    const bool printable = static_cast<unsigned char>(c) >= 0x20 && c != 0x7f;
    line += printable ? c : ' ';
  }
  return line;
}

std::string short_text(const ConfigNode& node) {
  constexpr std::size_t limit = 72;
  std::string text;
  append_text(node, text);
  if (text.size() <= limit) return text;
  std::size_t end = limit - 3;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) --end;  // not inside a character of UTF-8
  return text.substr(0, end) + "...";
}

ConfigNode parse_toml(const std::string& text, const std::string& file) {
  if (text.size() > max_text_size) {
    fail(fmt::format("{}: the file has {} bytes, a case file at most {}", file, text.size(), max_text_size));
  }
  check_nesting(text, file);
  try {
    return convert(toml::parse(text), file);
  } catch (const toml::parse_error& error) {
    const auto position = error.source().begin;
    fail(fmt::format("{}:{}: not valid TOML: {} (column {})", file, position.line, one_line(error.description()), position.column));
  }
}

void apply_override(ConfigNode& root, const std::string& key_value) {
  const std::size_t equals = key_value.find('=');
  const std::string key = key_value.substr(0, equals);
  const std::vector<std::string> parts = key_parts(key);
  if (equals == std::string::npos || parts.empty()) {
    throw Error(ErrorKind::usage, fmt::format("\"{}\" is not KEY=VALUE with a key like method.tolerance", one_line(key_value)));
  }
  const std::string value = key_value.substr(equals + 1);
  if (value.empty()) fail(fmt::format("command line: {}: no value after the equals sign", key));
  check_nesting(value, "command line");

  std::string problem;
  std::optional<ConfigNode> parsed = parse_value(value, problem);
  if (!parsed) {
    const std::size_t first = value.find_first_not_of(" \t");
    if (first != std::string::npos && std::string_view("[{\"'").find(value[first]) != std::string_view::npos) {
      fail(fmt::format("command line: {}: not valid TOML: {}", key, problem));
    }
    parsed.emplace();
    parsed->type = ConfigNode::Type::string;
    parsed->string = value;
  }
  set_origin(*parsed, "command line");

  ConfigNode* table = &root;
  for (std::size_t i = 0; i + 1 < parts.size(); ++i) {
    ConfigNode* next = table->find(parts[i]);
    if (next == nullptr) {
      ConfigNode made;
      made.origin = "command line";
      table->entries.push_back({parts[i], std::move(made)});
      next = &table->entries.back().node;
    }
    if (next->type != ConfigNode::Type::table) {
      std::string path = parts[0];
      for (std::size_t j = 1; j <= i; ++j) path += "." + parts[j];
      fail(fmt::format("command line: {}: {} is a value, not a table", key, path));
    }
    table = next;
  }
  if (ConfigNode* old = table->find(parts.back())) {
    *old = std::move(*parsed);
  } else {
    table->entries.push_back({parts.back(), std::move(*parsed)});
  }
}

}  // namespace stiffront::app
