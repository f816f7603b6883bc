// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <vector>

#include "stiffront/app/options.hpp"

namespace stiffront::app {

/// A time integration method a case file may name.
struct MethodEntry {
  std::string name;
  std::string description;  ///< one line
  std::string source;       ///< where it is published
  MethodOptions defaults;
};

const std::vector<MethodEntry>& methods();

/// The name in the case file of the alternative that `options` holds.
const std::string& method_name(const MethodOptions& options);

}  // namespace stiffront::app
