// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>

#include "stiffront/core/error.hpp"

namespace stiffront {

/// Bad input in one entry of a case, for those who know in which file and line the entry stands.
class EntryError : public Error {
 public:
  /// @param key the entry's dotted path, as in "model.reaction.u"
  EntryError(const std::string& key, const std::string& detail)
      : Error(ErrorKind::input, key + ": " + detail), key_(key), detail_(detail) {}

  const std::string& key() const { return key_; }
  const std::string& detail() const { return detail_; }

 private:
  std::string key_;
  std::string detail_;
};

}  // namespace stiffront
