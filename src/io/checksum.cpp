// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/io/checksum.hpp"

#include <fmt/format.h>

#include <bit>
#include <cstdint>

#include "content_hash.hpp"

namespace stiffront {

std::string checksum(const Field& u) {
  const Decomposition& d = u.decomposition();
  std::uint64_t sum = 0;
  for (int s = 0; s < u.n_species(); ++s) {
    for (int j = 0; j < u.n_y(); ++j) {
      const double* row = u.row(s, j);
      const std::int64_t first = (d.offset_y() + j) * d.grid().points[0] + d.offset_x();
      for (int i = 0; i < u.n_x(); ++i) {
        const auto place = static_cast<std::uint64_t>((first + i) * u.n_species() + s + 1);
        // By bits: a comparison may take a denormal for zero.
        const auto bits = std::bit_cast<std::uint64_t>(row[i]);
        sum += mix((bits << 1 == 0 ? 0 : bits) + mix(place));
      }
    }
  }
  std::uint64_t total = 0;
  check_mpi(MPI_Allreduce(&sum, &total, 1, MPI_UINT64_T, MPI_SUM, u.comm().get()), "MPI_Allreduce");
  return fmt::format("{:016x}", mix(total));
}

}  // namespace stiffront
