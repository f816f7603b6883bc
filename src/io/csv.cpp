// SPDX-License-Identifier: BSD-3-Clause
#include "csv.hpp"

#include <algorithm>
#include <charconv>
#include <filesystem>

#include "file.hpp"

namespace stiffront::csv {

void keep_up_to(const std::string& path, const std::string& header, std::int64_t last) {
  std::string kept = header + "\n";
  const std::string old = std::filesystem::exists(path) ? file::read(path) : std::string();
  if (old.starts_with(kept)) {
    const auto columns = std::count(header.begin(), header.end(), ',');
    for (std::size_t begin = kept.size(); begin < old.size();) {
      const std::size_t end = old.find('\n', begin);
      if (end == std::string::npos) break;
      const std::string line = old.substr(begin, end - begin);
      std::int64_t step = 0;
      const auto parsed = std::from_chars(line.data(), line.data() + line.size(), step);
      const bool whole = parsed.ec == std::errc() && std::count(line.begin(), line.end(), ',') == columns;
      if (whole && step <= last) kept += line + "\n";
      begin = end + 1;
    }
  }
  file::replace(path, kept);
}

}  // namespace stiffront::csv
