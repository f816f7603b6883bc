// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "stiffront/io/checkpoint.hpp"

namespace stiffront {

/// One rank's file in a checkpoint.
struct Shard {
  std::array<std::int64_t, 4> box{};  ///< offset_x, offset_y, n_x, n_y
  std::int64_t bytes = 0;
  std::uint64_t hash = 0;
};

/// Everything in a checkpoint that is no distributed array, and where those are. As text it is JSON with a hash of itself in the last
/// line; doubles are written as the hexadecimal digits of their bits, so they come back as they were.
struct Manifest {
  CheckpointHeader header;
  std::map<std::string, std::vector<double>> numbers;
  std::vector<std::string> fields;  ///< names of distributed fields
  std::vector<std::string> cells;   ///< names of arrays with one number per cell
  std::vector<Shard> shards;

  std::string text() const;
  /// @throws Error(io) if the text is not whole, of another format version, or its boxes do not cover the grid.
  static Manifest parse(const std::string& text);
};

/// rank-NNNN.h5.
std::string shard_name(std::size_t rank);

}  // namespace stiffront
