// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/space/sub_cell_closure.hpp"

#include <cstddef>

#include "stiffront/mesh/grid.hpp"

namespace stiffront {
namespace {

constexpr int columns = SubCellClosure::columns;

/// Weights on the points x[0] .. x[9] of the first two derivatives at z.
/// @see Fornberg, Math. Comp. 51, 1988, pp. 699-706
std::array<std::array<long double, columns>, 3> fornberg(const std::array<long double, columns>& x, long double z) {
  std::array<std::array<long double, columns>, 3> c{};
  c[0][0] = 1.0L;
  long double before = 1.0L;
  for (std::size_t n = 1; n < columns; ++n) {
    long double product = 1.0L;
    for (std::size_t k = 0; k < n; ++k) {
      const long double distance = x[n] - x[k];
      product *= distance;
      if (k + 1 == n) {
        for (std::size_t m = 2; m > 0; --m) c[m][n] = before / product * (static_cast<long double>(m) * c[m - 1][k] - (x[k] - z) * c[m][k]);
        c[0][n] = -before / product * (x[k] - z) * c[0][k];
      }
      for (std::size_t m = 2; m > 0; --m) c[m][k] = ((x[n] - z) * c[m][k] - static_cast<long double>(m) * c[m - 1][k]) / distance;
      c[0][k] = (x[n] - z) * c[0][k] / distance;
    }
    before = product;
  }
  return c;
}

SubCellClosure make() {
  SubCellClosure closure{};
  std::array<long double, columns> x{};
  x[1] = 0.2L;
  static_assert(Grid::sub_cell_place == 0.2);
  for (std::size_t k = 2; k < columns; ++k) x[k] = static_cast<long double>(k) - 1.0L;
  for (std::size_t row = 1; row < SubCellClosure::rows; ++row) {
    const auto weights = fornberg(x, x[row]);
    for (std::size_t k = 0; k < columns; ++k) {
      closure.first[row - 1][k] = static_cast<double>(weights[1][k]);
      closure.second[row - 1][k] = static_cast<double>(weights[2][k]);
    }
  }
  // x_4 by the centred formula on x_0 .. x_8.
  closure.first[4] = {1.0 / 280.0, 0.0, -4.0 / 105.0, 0.2, -0.8, 0.0, 0.8, -0.2, 4.0 / 105.0, -1.0 / 280.0};
  closure.second[4] = {-1.0 / 560.0, 0.0, 8.0 / 315.0, -0.2, 1.6, -205.0 / 72.0, 1.6, -0.2, 8.0 / 315.0, -1.0 / 560.0};
  return closure;
}

}  // namespace

const SubCellClosure& SubCellClosure::get() {
  static const SubCellClosure closure = make();
  return closure;
}

}  // namespace stiffront
