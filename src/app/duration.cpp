// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/app/duration.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

namespace stiffront::app {
namespace {

struct Unit {
  char name;
  double seconds;
};
constexpr Unit units[] = {{'d', 86400.0}, {'h', 3600.0}, {'m', 60.0}, {'s', 1.0}};

}  // namespace

std::optional<double> parse_duration(std::string_view text) {
  if (text.empty()) return std::nullopt;
  double total = 0.0;
  const Unit* next = units;
  while (!text.empty()) {
    std::size_t digits = 0;
    while (digits < text.size() && ((text[digits] >= '0' && text[digits] <= '9') || text[digits] == '.')) ++digits;
    if (digits == 0 || digits == text.size()) return std::nullopt;
    double count = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + digits, count, std::chars_format::fixed);
    if (error != std::errc{} || end != text.data() + digits) return std::nullopt;
    while (next != std::end(units) && next->name != text[digits]) ++next;
    if (next == std::end(units)) return std::nullopt;
    total += count * next->seconds;
    ++next;
    text.remove_prefix(digits + 1);
  }
  return std::isfinite(total) ? std::optional(total) : std::nullopt;
}

std::string format_duration(double seconds) {
  // Whole seconds up to 2^53 split exactly into units; anything else stays one number.
  if (seconds != std::floor(seconds) || seconds >= 9007199254740992.0) {
    std::string digits;
    for (int precision = 0; precision <= 1100; ++precision) {
      digits = fmt::format("{:.{}f}", seconds, precision);
      if (parse_duration(digits + "s") == seconds) break;
    }
    return digits + "s";
  }
  auto rest = static_cast<long long>(seconds);
  std::string text;
  for (const Unit& unit : units) {
    const auto size = static_cast<long long>(unit.seconds);
    if (rest >= size) {
      text += fmt::format("{}{}", rest / size, unit.name);
      rest %= size;
    }
  }
  return text.empty() ? "0s" : text;
}

}  // namespace stiffront::app
