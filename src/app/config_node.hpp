// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace stiffront::app {

struct ConfigEntry;

/// One value of a case file, in the order of the file, with the place it comes from.
struct ConfigNode {
  enum class Type { boolean, integer, number, string, array, table, date };

  Type type = Type::table;
  bool boolean = false;
  std::int64_t integer = 0;
  double number = 0.0;
  std::string string;                ///< string; date: as text
  std::vector<ConfigNode> elements;  ///< array
  std::vector<ConfigEntry> entries;  ///< table
  std::string origin;                ///< "bz.toml:12:1" or "command line"

  bool is_number() const { return type == Type::integer || type == Type::number; }
  double as_number() const { return type == Type::integer ? static_cast<double>(integer) : number; }

  /// Null if there is no such entry or this is no table.
  const ConfigNode* find(std::string_view key) const;
  ConfigNode* find(std::string_view key);
};

/// A key of a table and its value.
struct ConfigEntry {
  std::string key;
  ConfigNode node;
};

/// Control characters become spaces.
std::string one_line(std::string_view text);

/// The value as a user would write it, cut after about 60 characters: for messages.
std::string short_text(const ConfigNode& node);

/// Reads TOML. `file` is only a name for messages.
/// @throws Error(input) "FILE:LINE: not valid TOML: ..."
ConfigNode parse_toml(const std::string& text, const std::string& file);

/// Sets one entry from "dotted.key=VALUE". VALUE is TOML; what is no TOML and does not begin like a TOML string, array
/// or table is taken as a string. Replaces what the file says there; tables on the way are made.
/// @throws Error(usage) if it is not of that form, Error(input) if VALUE is broken TOML or the key leads through a
/// value
void apply_override(ConfigNode& root, const std::string& key_value);

}  // namespace stiffront::app
