// SPDX-License-Identifier: BSD-3-Clause
#include "case_tree.hpp"

#include <fmt/format.h>

#include <charconv>

#include "stiffront/core/error.hpp"

namespace stiffront::app {

const ConfigNode* CaseTree::find(const std::string& path) const {
  const ConfigNode* node = &root_;
  std::size_t begin = 0;
  while (node != nullptr && begin < path.size()) {
    const std::size_t end = std::min(path.find_first_of(".[", begin), path.size());
    if (path[begin == 0 ? 0 : begin - 1] == '[') {
      std::size_t index = 0;
      std::from_chars(path.data() + begin, path.data() + path.find(']', begin), index);
      node = index < node->elements.size() ? &node->elements[index] : nullptr;
      begin = path.find(']', begin) + 2;
      continue;
    }
    node = node->find(path.substr(begin, end - begin));
    begin = end + 1;
  }
  return node;
}

std::string CaseTree::text(const std::string& path) const {
  const ConfigNode* node = find(path);
  return node != nullptr ? short_text(*node) : "nothing";
}

void CaseTree::fail(const std::string& path, const std::string& message) const {
  std::string place = file_;
  for (std::string at = path; !at.empty();) {
    if (const ConfigNode* node = find(at)) {
      place = node->origin;
      break;
    }
    const std::size_t end = at.find_last_of(".[");
    at.resize(end == std::string::npos ? 0 : end);
  }
  throw Error(ErrorKind::input, one_line(fmt::format("{}: {}: {}", place, path, message)));
}

}  // namespace stiffront::app
