// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <string>

namespace stiffront::csv {

/// Rewrites a file whose lines begin with a step number: header, then the lines whose step is at most `last`. Lines cut short are
/// dropped. A file that is not there, or has another header, becomes the header alone. On one process. @throws Error(io)
void keep_up_to(const std::string& path, const std::string& header, std::int64_t last);

}  // namespace stiffront::csv
