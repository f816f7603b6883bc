// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <cstring>
#include <string_view>

namespace stiffront {

/// The finaliser of splitmix64 (Steele, Lea & Flood, OOPSLA 2014): a bijection of 64-bit words in which every bit depends on every bit.
inline std::uint64_t mix(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

/// A hash of bytes that comes in pieces. Each word goes through a bijection of the state, so a change confined to one word never goes
/// unnoticed.
class ContentHash {
 public:
  /// Pieces other than the last must be multiples of eight bytes long.
  void add(std::string_view bytes) {
    length_ += bytes.size();
    while (bytes.size() >= sizeof(std::uint64_t)) {
      std::uint64_t word;
      std::memcpy(&word, bytes.data(), sizeof word);
      state_ = mix(state_ ^ word) + 0x9e3779b97f4a7c15ULL;
      bytes.remove_prefix(sizeof word);
    }
    if (bytes.empty()) return;
    std::uint64_t word = 0;
    std::memcpy(&word, bytes.data(), bytes.size());
    state_ = mix(state_ ^ word) + 0x9e3779b97f4a7c15ULL;
  }
  std::uint64_t value() const { return mix(state_ ^ length_); }

 private:
  std::uint64_t state_ = 0;
  std::uint64_t length_ = 0;
};

inline std::uint64_t content_hash(std::string_view bytes) {
  ContentHash hash;
  hash.add(bytes);
  return hash.value();
}

}  // namespace stiffront
