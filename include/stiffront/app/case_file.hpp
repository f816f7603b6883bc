// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <vector>

#include "stiffront/app/options.hpp"
#include "stiffront/model/model.hpp"

namespace stiffront::app {

/// A case as it reaches the program, before anybody looked into it.
struct CaseSource {
  std::string file;                    ///< its name, for messages
  std::string text;                    ///< TOML
  std::vector<std::string> overrides;  ///< "dotted.key=VALUE", applied in this order
};

/// Reads a case: defaults, then the file, then the overrides, each of which replaces the value at its key. The result
/// is complete: nothing in it depends on a default any more.
///
/// @param models those a case may name: ModelRegistry::descriptions()
///
/// Depends on nothing but its arguments, so ranks that hold the same source get the same case or the same error.
/// @throws Error(input) with one line: file, line, column, key, what is wrong, what is allowed.
///         Error(usage) if an override is not of the form KEY=VALUE.
Case parse_case(const CaseSource& source, const std::vector<ModelDescription>& models);

/// The complete case as TOML. parse_case of it gives the same options, bit by bit.
std::string effective_configuration(const Case& c);

/// Reference of all keys in Markdown: the text of docs/input.md.
std::string input_reference();

}  // namespace stiffront::app
