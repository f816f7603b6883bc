// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <optional>
#include <string>
#include <string_view>

namespace stiffront::app {

/// Seconds in a text such as "90s", "3h50m", "1d", "1.5h": numbers with the units d, h, m, s, each at most once and in
/// this order, without spaces. Nothing if the text is anything else.
std::optional<double> parse_duration(std::string_view text);

/// The shortest such text; parse_duration gives exactly the same seconds back.
std::string format_duration(double seconds);

}  // namespace stiffront::app
