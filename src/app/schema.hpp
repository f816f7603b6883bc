// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "config_node.hpp"
#include "stiffront/app/options.hpp"

namespace stiffront::app {

/// One key of the case file: how to read it, how to write it, how to explain it.
struct Key {
  Key(std::string path_, std::string expected_, std::string doc_)
      : path(std::move(path_)), expected(std::move(expected_)), doc(std::move(doc_)) {}

  std::string path;          ///< dotted; "initial.*" stands for every entry of [initial] that no other key claims
  std::string expected;      ///< what its value has to be, in words
  std::string doc;           ///< one line
  std::string default_note;  ///< says what the default is where it depends on something else
  bool required = false;
  std::string method;           ///< the one method it belongs to; empty: to every case
  bool entry_per_line = false;  ///< `write` gives lines "name = value" instead of one value
  std::function<void(Case&, const ConfigNode&, const std::string& path)> read;
  std::function<std::string(const Case&)> write;  ///< TOML; empty: nothing to say

  std::string section() const { return path.substr(0, path.find('.')); }
};

/// Every key, in the order of the documentation. method.name comes before the keys of the methods.
const std::vector<Key>& schema();

/// The key exists with this method.
inline bool applies(const Key& key, const std::string& method) { return key.method.empty() || key.method == method; }

}  // namespace stiffront::app
