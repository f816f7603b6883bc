// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/space/conserved_totals.hpp"

#include <cstddef>
#include <cstdint>

#include "stiffront/core/mpi.hpp"

namespace stiffront {
namespace {

/// The part of a cell that belongs to the domain.
double weight(const Grid& grid, int direction, std::int64_t index) {
  const auto d = static_cast<std::size_t>(direction);
  if (direction >= grid.dimension) return 1.0;
  if (grid.periodic[d]) return grid.spacing(direction);
  const double here = grid.place(direction, index);
  const double before = index == 0 ? here : grid.place(direction, index - 1);
  const double after = index == grid.points[d] - 1 ? here : grid.place(direction, index + 1);
  return 0.5 * (after - before) * grid.spacing(direction);
}

}  // namespace

std::vector<double> conserved_totals(const std::vector<ConservedSum>& sums, const Field& u) {
  const Decomposition& d = u.decomposition();
  Agreement agreement(static_cast<int>(sums.size()), 0);
  for (int j = 0; j < u.n_y(); ++j) {
    const double weight_y = weight(d.grid(), 1, d.offset_y() + j);
    for (int i = 0; i < u.n_x(); ++i) {
      const double area = weight_y * weight(d.grid(), 0, d.offset_x() + i);
      for (std::size_t k = 0; k < sums.size(); ++k) {
        double sum = 0.0;
        for (int s = 0; s < u.n_species(); ++s) sum += sums[k].weights[static_cast<std::size_t>(s)] * u.at(s, i, j);
        agreement.sums[k].add(area * sum);
      }
    }
  }
  u.comm().agree(agreement);
  std::vector<double> totals;
  for (const ReproducibleSum& sum : agreement.sums) totals.push_back(sum.value());
  return totals;
}

}  // namespace stiffront
