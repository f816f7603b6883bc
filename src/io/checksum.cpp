// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/io/checksum.hpp"

#include <fmt/format.h>

#include <bit>
#include <cstdint>

namespace stiffront {
namespace {

std::uint64_t mix(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

}  // namespace

std::string checksum(const Field& u) {
  const Decomposition& d = u.decomposition();
  std::uint64_t sum = 0;
  for (int s = 0; s < u.n_species(); ++s) {
    for (int j = 0; j < u.n_y(); ++j) {
      const double* row = u.row(s, j);
      const std::int64_t first = (d.offset_y() + j) * d.grid().points[0] + d.offset_x();
      for (int i = 0; i < u.n_x(); ++i) {
        const auto place = static_cast<std::uint64_t>((first + i) * u.n_species() + s + 1);
        sum += mix(std::bit_cast<std::uint64_t>(row[i] == 0.0 ? 0.0 : row[i]) + mix(place));
      }
    }
  }
  std::uint64_t total = 0;
  check_mpi(MPI_Allreduce(&sum, &total, 1, MPI_UINT64_T, MPI_SUM, u.comm().get()), "MPI_Allreduce");
  return fmt::format("{:016x}", mix(total));
}

}  // namespace stiffront
