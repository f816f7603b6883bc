// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <span>
#include <string_view>

namespace stiffront::app {

/// A case file that is part of the program: drivers/cases/NAME.toml.
struct BuiltinCase {
  std::string_view name;
  std::string_view text;
};

/// In order of their names.
std::span<const BuiltinCase> builtin_cases();

}  // namespace stiffront::app
