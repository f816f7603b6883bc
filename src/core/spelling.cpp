// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/core/spelling.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>

namespace stiffront {
namespace {

std::string lower_case(std::string_view word) {
  std::string lower(word);
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return lower;
}

/// Optimal string alignment distance.
std::size_t edits(const std::string& a, const std::string& b) {
  const std::size_t n = b.size() + 1;
  std::vector<std::size_t> before(n), previous(n), current(n);
  for (std::size_t j = 0; j < n; ++j) previous[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    current[0] = i;
    for (std::size_t j = 1; j < n; ++j) {
      current[j] = std::min({previous[j] + 1, current[j - 1] + 1, previous[j - 1] + (a[i - 1] == b[j - 1] ? 0U : 1U)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) current[j] = std::min(current[j], before[j - 2] + 1);
    }
    std::swap(before, previous);
    std::swap(previous, current);
  }
  return previous[n - 1];
}

}  // namespace

std::string nearest_name(std::string_view word, const std::vector<std::string>& allowed) {
  if (word.empty() || word.size() > 64) return {};
  const std::string wanted = lower_case(word);
  std::string best;
  std::size_t least = std::max<std::size_t>(1, word.size() / 3) + 1;
  for (const std::string& name : allowed) {
    const std::size_t distance = edits(wanted, lower_case(name));
    if (distance >= std::max(wanted.size(), name.size())) continue;  // not a letter in common
    if (distance < least) {
      least = distance;
      best = name;
    }
  }
  return best;
}

std::string suggestion(std::string_view word, const std::vector<std::string>& allowed) {
  const std::string name = nearest_name(word, allowed);
  return name.empty() ? "" : fmt::format("; did you mean {}?", name);
}

std::string with_allowed(const std::string& hint, const std::string& where, const std::vector<std::string>& allowed) {
  const bool after_question = !hint.empty() && hint.back() == '?';
  return fmt::format("{}{}{}: {}", hint, after_question ? " Allowed" : "; allowed", where, comma_list(allowed));
}

std::string comma_list(const std::vector<std::string>& names) { return fmt::format("{}", fmt::join(names, ", ")); }

}  // namespace stiffront
