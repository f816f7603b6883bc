// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

/// Values written as TOML; reading them back gives the same bits.
namespace stiffront::app {

std::string toml_text(double x);
std::string toml_text(std::int64_t i);
std::string toml_text(int i);
std::string toml_text(bool b);
std::string toml_text(const std::string& s);
/// A word with quotation marks only where a bare key would not do.
std::string toml_key(const std::string& key);

template <typename T>
std::string toml_text(const std::vector<T>& elements) {
  std::string text = "[";
  for (const auto& element : elements) {
    if (text.size() > 1) text += ", ";
    text += toml_text(static_cast<const T&>(element));
  }
  return text + "]";
}

}  // namespace stiffront::app
