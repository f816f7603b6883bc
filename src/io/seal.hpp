// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

/// A seal on result files: a hash, in the block before the HDF5 part that HDF5 leaves to its users, of every byte but the values.
///
/// HDF5 1.10 trusts what it reads: a changed byte in a header can crash it or make it write beyond its memory. Whatever a program has
/// sealed is looked at with eyes of its own before the library sees it. The block is text, for whoever opens the file with `head`.
namespace stiffront::seal {

/// Bytes of the block.
inline constexpr std::size_t block_size = 4096;

/// Bytes of a file that are values of a dataset.
struct Extent {
  std::int64_t begin = 0;
  std::int64_t size = 0;
};

/// Seals a closed file with an empty block. @throws Error(io)
void put(const std::string& path, std::vector<Extent> values);

/// Looks whether a file is as it was sealed. A file that begins with HDF5's own signature was made by another program and is believed.
/// @throws Error(io) if it is not, or is no HDF5 file
void check(const std::string& path);

}  // namespace stiffront::seal
