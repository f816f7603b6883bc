// SPDX-License-Identifier: BSD-3-Clause
#include "key_values.hpp"

#include <fmt/format.h>

#include <cmath>

#include "choices.hpp"
#include "stiffront/core/error.hpp"
#include "stiffront/core/spelling.hpp"

namespace stiffront::app {
namespace {

using Type = ConfigNode::Type;

constexpr Range positive{0.0, std::numeric_limits<double>::infinity(), true, false};

}  // namespace

void refuse(const ConfigNode& node, const std::string& path, const std::string& expected, const std::string& hint) {
  throw Error(ErrorKind::input,
              one_line(fmt::format("{}: {}: expected {}, got {}{}", node.origin, path, expected, short_text(node), hint)));
}

bool Range::contains(double x) const {
  return std::isfinite(x) && (lower_open ? x > lower : x >= lower) && (upper_open ? x < upper : x <= upper);
}

std::string Range::words(const std::string& noun) const {
  if (lower == 0.0 && lower_open && std::isinf(upper)) return fmt::format("a positive {}", noun);
  std::string text = fmt::format("{} {}", noun == "integer" ? "an" : "a", noun);
  if (std::isfinite(lower)) text += fmt::format("{}{}", lower_open ? " above " : " not below ", lower);
  if (std::isfinite(lower) && std::isfinite(upper)) text += " and";
  if (std::isfinite(upper)) text += fmt::format("{}{}", upper_open ? " below " : " not above ", upper);
  return text;
}

double read_number(const ConfigNode& node, const std::string& path, const Range& range) {
  if (!node.is_number() || !range.contains(node.as_number())) refuse(node, path, range.words("number"));
  return node.as_number();
}

std::int64_t read_integer(const ConfigNode& node, const std::string& path, const Range& range) {
  if (node.type != Type::integer || !range.contains(static_cast<double>(node.integer))) {
    refuse(node, path, range.words("integer"));
  }
  return node.integer;
}

std::string read_string(const ConfigNode& node, const std::string& path, const std::string& expected) {
  if (node.type != Type::string || node.string.empty()) refuse(node, path, expected);
  return node.string;
}

std::string read_word(const ConfigNode& node, const std::string& path, const std::vector<std::string>& allowed) {
  for (const std::string& word : allowed) {
    if (node.type == Type::string && node.string == word) return word;
  }
  refuse(node, path, quoted_alternatives(allowed), node.type == Type::string ? suggestion(node.string, allowed) : "");
}

Value read_value(const ConfigNode& node, const std::string& path) {
  if (node.type == Type::string && !node.string.empty()) return node.string;
  if (node.is_number() && std::isfinite(node.as_number())) return node.as_number();
  refuse(node, path, "a number or an expression in quotation marks");
}

SideOptions read_side(const ConfigNode& node, const std::string& path, const std::string& expected) {
  const std::vector<std::string> kinds = choice_list<BoundaryKind>();
  SideOptions side;
  const bool is_table = node.type == Type::table;
  const ConfigNode* type = is_table ? node.find("type") : &node;
  if (type == nullptr) {
    throw Error(ErrorKind::input, fmt::format("{}: {}: type is missing: {}", node.origin, path, quoted_alternatives(kinds)));
  }
  if (!is_table && type->type != Type::string) refuse(node, path, expected);
  const std::string kind = read_word(*type, is_table ? path + ".type" : path, kinds);
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    if (kinds[i] == kind) side.kind = static_cast<BoundaryKind>(i);
  }
  for (const auto& [name, value] : node.entries) {
    if (name != "type") side.values.emplace_back(name, read_value(value, path + "." + name));
  }
  return side;
}

Tolerance read_tolerance(const ConfigNode& node, const std::string& path, const std::string& expected) {
  const auto read_one = [](const ConfigNode& n, const std::string& p) { return read_number(n, p, positive); };
  if (node.type == Type::table) return read_entries(node, path, expected, read_one);
  if (!node.is_number() || !positive.contains(node.as_number())) refuse(node, path, expected);
  return node.as_number();
}

ReactionOptions read_reaction(const ConfigNode& node, const std::string& path) {
  if (node.type != Type::table) refuse(node, path, R"(a table { equation = "...", rate = ... })");
  const std::vector<std::string> allowed = {"equation", "rate", "reverse_rate", "mass_action"};
  ReactionOptions reaction;
  for (const auto& [name, value] : node.entries) {
    const std::string its_path = path + "." + name;
    if (name == "equation") {
      reaction.equation = read_string(value, its_path, "an equation in quotation marks");
    } else if (name == "rate") {
      reaction.rate = read_value(value, its_path);
    } else if (name == "reverse_rate") {
      reaction.reverse_rate = read_value(value, its_path);
    } else if (name == "mass_action") {
      if (value.type != Type::boolean) refuse(value, its_path, "true or false");
      reaction.mass_action = value.boolean;
    } else {
      throw Error(ErrorKind::input, one_line(fmt::format("{}: {}: unknown key{}", value.origin, its_path,
                                                         with_allowed(suggestion(name, allowed), "", allowed))));
    }
  }
  for (const char* name : {"equation", "rate"}) {
    if (node.find(name) == nullptr) {
      throw Error(ErrorKind::input, fmt::format("{}: {}.{}: missing", node.origin, path, name));
    }
  }
  return reaction;
}

std::string quoted_alternatives(const std::vector<std::string>& words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i > 0) text += i + 1 == words.size() ? " or " : ", ";
    text += '"' + words[i] + '"';
  }
  return text;
}

std::string value_text(const Value& value) {
  return std::visit([](const auto& v) { return toml_text(v); }, value);
}

std::string side_text(const SideOptions& side) {
  const std::string word = toml_text(choice_word(side.kind));
  return side.values.empty() ? word : entries_text(side.values, "type = " + word);
}

std::string reaction_text(const ReactionOptions& reaction) {
  std::string text = fmt::format("{{ equation = {}, rate = {}", toml_text(reaction.equation), value_text(reaction.rate));
  if (reaction.reverse_rate) text += fmt::format(", reverse_rate = {}", value_text(*reaction.reverse_rate));
  if (!reaction.mass_action) text += ", mass_action = false";
  return text + " }";
}

std::string tolerance_text(const Tolerance& tolerance) {
  if (const double* one = std::get_if<double>(&tolerance)) return toml_text(*one);
  return entries_text(std::get<NamedList<double>>(tolerance));
}

}  // namespace stiffront::app
