// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>

namespace stiffront {

struct FreeMemory {
  void operator()(double* p) const { std::free(p); }
};

/// Numbers that begin on a 64-byte line.
using AlignedArray = std::unique_ptr<double[], FreeMemory>;

/// n of them, all zero. @throws std::bad_alloc
inline AlignedArray aligned_zeros(std::size_t n) {
  constexpr std::size_t line = 64;
  const std::size_t bytes = (n * sizeof(double) + line - 1) / line * line;
  AlignedArray array(static_cast<double*>(std::aligned_alloc(line, bytes)));
  if (!array) throw std::bad_alloc();
  std::memset(array.get(), 0, bytes);
  return array;
}

}  // namespace stiffront
