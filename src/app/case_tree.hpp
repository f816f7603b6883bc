// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>

#include "config_node.hpp"

namespace stiffront::app {

/// A case file as a tree, which knows where each entry stands in it.
class CaseTree {
 public:
  CaseTree(ConfigNode root, std::string file) : root_(std::move(root)), file_(std::move(file)) {}

  const ConfigNode& root() const { return root_; }

  /// The value at a dotted path, "output.probes[2]" included; null if it was not given.
  const ConfigNode* find(const std::string& path) const;
  bool has(const std::string& path) const { return find(path) != nullptr; }

  /// The value at the path, for messages.
  std::string text(const std::string& path) const;

  /// @throws Error(input) "PLACE: PATH: MESSAGE", the place being that of the nearest table that was given
  [[noreturn]] void fail(const std::string& path, const std::string& message) const;

 private:
  ConfigNode root_;
  std::string file_;
};

}  // namespace stiffront::app
