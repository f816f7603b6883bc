// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

namespace stiffront::testing {

/// Rounds of a mutation test: STIFFRONT_FUZZ_ROUNDS times what a test takes by itself.
inline std::uint64_t mutation_rounds(std::uint64_t usual) {
  const char* factor = std::getenv("STIFFRONT_FUZZ_ROUNDS");
  return factor != nullptr ? usual * static_cast<std::uint64_t>(std::atoll(factor)) : usual;
}

/// Changes texts and files at random; the same seed gives the same change.
class Mutation {
 public:
  explicit Mutation(std::uint64_t seed) : random_(seed) {}

  /// The text with a few changes; `fragments` are what a parser might stumble over.
  std::string of(std::string text, const std::vector<std::string>& fragments) {
    const bool gentle = pick(2) == 0;
    const int changes = 1 + static_cast<int>(pick(gentle ? 3 : 6));
    for (int i = 0; i < changes; ++i) {
      if (gentle) {  // one digit for another: most such texts are still cases
        const std::size_t digit = text.find_first_of("0123456789", pick(text.size()));
        if (digit != std::string::npos) text[digit] = static_cast<char>('0' + pick(10));
        continue;
      }
      const std::size_t at = pick(text.size() + 1);
      switch (pick(6)) {
        case 0:
          text.erase(at, pick(12));
          break;
        case 1:
          text.insert(at, fragments[pick(fragments.size())]);
          break;
        case 2:
          text.insert(at, 1, static_cast<char>(pick(256)));
          break;
        case 3:
          text.insert(at, text.substr(pick(text.size() + 1), pick(60)));
          break;
        case 4:
          text.resize(at);
          break;
        default:
          if (at < text.size()) text[at] = static_cast<char>(text[at] ^ (1 << pick(8)));
      }
    }
    return text;
  }
  std::size_t pick(std::size_t n) { return n == 0 ? 0 : static_cast<std::size_t>(random_() % n); }

 private:
  std::mt19937_64 random_;
};

}  // namespace stiffront::testing
