// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "config_node.hpp"
#include "stiffront/app/options.hpp"
#include "toml_text.hpp"

/// Reading and writing of single values. Every read_ function throws Error(input) that names the place, the path, what
/// was expected and what was found.
namespace stiffront::app {

/// @throws Error(input) "ORIGIN: PATH: expected EXPECTED, got VALUE"
[[noreturn]] void refuse(const ConfigNode& node, const std::string& path, const std::string& expected, const std::string& hint = "");

/// Finite numbers between two bounds.
struct Range {
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
  bool lower_open = false;
  bool upper_open = false;

  bool contains(double x) const;
  /// "a positive number", "an integer not below 2 and not above 5"
  std::string words(const std::string& noun) const;
};

double read_number(const ConfigNode& node, const std::string& path, const Range& range = {});
std::int64_t read_integer(const ConfigNode& node, const std::string& path, const Range& range);
std::string read_string(const ConfigNode& node, const std::string& path, const std::string& expected);
std::string read_word(const ConfigNode& node, const std::string& path, const std::vector<std::string>& allowed);
Value read_value(const ConfigNode& node, const std::string& path);
SideOptions read_side(const ConfigNode& node, const std::string& path, const std::string& expected);
Tolerance read_tolerance(const ConfigNode& node, const std::string& path, const std::string& expected);
ReactionOptions read_reaction(const ConfigNode& node, const std::string& path);

template <typename ReadElement>
auto read_array(const ConfigNode& node, const std::string& path, const std::string& expected, bool may_be_empty, ReadElement read_element) {
  std::vector<std::decay_t<decltype(read_element(node, path))>> result;
  if (node.type != ConfigNode::Type::array || (node.elements.empty() && !may_be_empty)) refuse(node, path, expected);
  for (std::size_t i = 0; i < node.elements.size(); ++i) {
    result.push_back(read_element(node.elements[i], path + "[" + std::to_string(i) + "]"));
  }
  return result;
}

template <typename ReadEntry>
auto read_entries(const ConfigNode& node, const std::string& path, const std::string& expected, ReadEntry read_entry) {
  NamedList<std::decay_t<decltype(read_entry(node, path))>> result;
  if (node.type != ConfigNode::Type::table) refuse(node, path, expected);
  for (const auto& [name, value] : node.entries) result.emplace_back(name, read_entry(value, path + "." + name));
  return result;
}

/// `"a", "b" or "c"`
std::string quoted_alternatives(const std::vector<std::string>& words);

std::string value_text(const Value& value);
std::string side_text(const SideOptions& side);
std::string reaction_text(const ReactionOptions& reaction);
std::string tolerance_text(const Tolerance& tolerance);

template <typename T>
std::string entries_text(const NamedList<T>& entries, std::string text = "") {
  for (const auto& [name, value] : entries) {
    text += (text.empty() ? "" : ", ") + toml_key(name) + " = " + value_text(value);
  }
  return text.empty() ? "{}" : "{ " + text + " }";
}

}  // namespace stiffront::app
