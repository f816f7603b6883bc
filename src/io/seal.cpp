// SPDX-License-Identifier: BSD-3-Clause
#include "seal.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string_view>
#include <system_error>

#include "content_hash.hpp"
#include "file.hpp"
#include "stiffront/core/error.hpp"

namespace stiffront::seal {
namespace {

constexpr std::string_view hdf5_signature = "\x89HDF\r\n\x1a\n";
constexpr std::string_view title = "stiffront result file, HDF5 from byte 4096\nhash ";
constexpr std::size_t digits = 16;
constexpr std::string_view length_key = "\nlength ";
constexpr std::string_view values_key = "\nvalues ";

/// Collects pieces of any length for ContentHash, which wants whole words.
class PieceHash {
 public:
  void add(std::string_view bytes) {
    while (!bytes.empty()) {
      const std::size_t n = std::min(bytes.size(), capacity - held_.size());
      held_.append(bytes.substr(0, n));
      bytes.remove_prefix(n);
      if (held_.size() == capacity) flush();
    }
  }
  std::uint64_t value() {
    flush();
    return hash_.value();
  }

 private:
  static constexpr std::size_t capacity = 1 << 16;
  void flush() {
    hash_.add(held_);
    held_.clear();
  }
  ContentHash hash_;
  std::string held_;
};

/// Of the block, its own digits counted as zeros, and of everything else but the values.
std::uint64_t hash_of(const std::string& path, std::string block, std::int64_t length, const std::vector<Extent>& values) {
  std::fill_n(block.begin() + title.size(), digits, '0');
  PieceHash hash;
  hash.add(block);
  std::ifstream in(path, std::ios::binary);
  std::string buffer(1 << 16, '\0');
  const auto add_until = [&](std::int64_t from, std::int64_t to) {
    in.seekg(from);
    while (from < to && in) {
      const std::int64_t n = std::min<std::int64_t>(to - from, static_cast<std::int64_t>(buffer.size()));
      in.read(buffer.data(), n);
      hash.add(std::string_view(buffer).substr(0, static_cast<std::size_t>(in.gcount())));
      from += n;
    }
    if (!in) file::fail(path, "be read", errno);
  };
  std::int64_t at = static_cast<std::int64_t>(block_size);
  for (const Extent& e : values) {
    add_until(at, e.begin);
    at = e.begin + e.size;
  }
  add_until(at, length);
  return hash.value();
}

/// Takes a key and the number behind it off the front of the text.
std::optional<std::int64_t> take_number(std::string_view& text, std::string_view key) {
  if (!text.starts_with(key)) return std::nullopt;
  std::int64_t number = 0;
  const auto [end, failed] = std::from_chars(text.data() + key.size(), text.data() + text.size(), number);
  if (failed != std::errc()) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return number;
}

[[noreturn]] void damaged(const std::string& path) {
  throw Error(ErrorKind::io, fmt::format("{}: the file is damaged: it is not as it was written", path));
}

std::int64_t length_of(const std::string& path) {
  std::error_code failed;
  const auto length = std::filesystem::file_size(path, failed);
  if (failed) file::fail(path, "be read", failed.value());
  return static_cast<std::int64_t>(length);
}

}  // namespace

void put(const std::string& path, std::vector<Extent> values) {
  std::erase_if(values, [](const Extent& e) { return e.size == 0; });
  std::sort(values.begin(), values.end(), [](const Extent& a, const Extent& b) { return a.begin < b.begin; });
  const std::int64_t length = length_of(path);
  std::string block = fmt::format("{}{:0{}x}{}{}", title, 0, digits, length_key, length);
  std::vector<Extent> named;
  for (const Extent& e : values) {
    const std::string line = fmt::format("{}{} {}", values_key, e.begin, e.size);
    if (block.size() + line.size() + 1 > block_size) break;  // the rest is hashed like everything else
    block += line;
    named.push_back(e);
  }
  block += '\n';
  block.resize(block_size, '\0');
  const std::string hash = fmt::format("{:0{}x}", hash_of(path, block, length, named), digits);
  std::copy(hash.begin(), hash.end(), block.begin() + title.size());
  std::fstream out(path, std::ios::binary | std::ios::in | std::ios::out);
  out.write(block.data(), static_cast<std::streamsize>(block.size()));
  out.close();
  if (!out) file::fail(path, "be written", errno);
}

void check(const std::string& path) {
  std::string block(block_size, '\0');
  {
    std::ifstream in(path, std::ios::binary);
    if (!in) file::fail(path, "be read", errno);
    in.read(block.data(), static_cast<std::streamsize>(block.size()));
    block.resize(static_cast<std::size_t>(in.gcount()));
  }
  if (block.starts_with(hdf5_signature)) return;
  if (!block.starts_with(title) || block.size() < block_size) {
    throw Error(
        ErrorKind::io,
        fmt::format("{}: cannot be opened as an HDF5 file: it begins neither with the signature of HDF5 nor with this program's seal",
                    path));
  }
  std::string_view text(block);
  text.remove_prefix(title.size());
  const std::string_view hash = text.substr(0, digits);
  text.remove_prefix(digits);
  const std::optional<std::int64_t> length = take_number(text, length_key);
  if (!length || *length != length_of(path)) damaged(path);
  std::vector<Extent> values;
  std::int64_t at = static_cast<std::int64_t>(block_size);
  while (const std::optional<std::int64_t> begin = take_number(text, values_key)) {
    const std::optional<std::int64_t> size = take_number(text, " ");
    if (!size || *begin < at || *size < 0 || *size > *length - *begin) damaged(path);
    values.push_back({*begin, *size});
    at = *begin + *size;
  }
  if (hash != fmt::format("{:0{}x}", hash_of(path, block, *length, values), digits)) damaged(path);
}

}  // namespace stiffront::seal
