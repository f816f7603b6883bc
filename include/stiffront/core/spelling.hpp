// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace stiffront {

/// The name of `allowed` that `word` most likely means; empty if none is near. Letter case counts for nothing; a
/// distance of one edit (insertion, deletion, change, swap of neighbours) in three letters is near.
std::string nearest_name(std::string_view word, const std::vector<std::string>& allowed);

/// "; did you mean NAME?" or nothing.
std::string suggestion(std::string_view word, const std::vector<std::string>& allowed);

/// "HINT; allowed IN: a, b, c", or "HINT Allowed IN: ..." after a question. `where` is "" or " in [grid]".
std::string with_allowed(const std::string& hint, const std::string& where, const std::vector<std::string>& allowed);

/// "a, b, c"
std::string comma_list(const std::vector<std::string>& names);

}  // namespace stiffront
