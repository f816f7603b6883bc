// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/model/conserved_sums.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <utility>

namespace stiffront {
namespace {

using Rows = std::vector<std::vector<Rational>>;

/// Reduces the rows to echelon form, columns from the right, so that the free unknowns are on the left: what reactions make, which
/// people write last, is then expressed by what they consume, and conserved sums have few negative weights.
/// @return per column, the row with its pivot, or -1
std::vector<int> reduce(Rows& rows, std::size_t n_columns) {
  std::vector<int> pivot_row(n_columns, -1);
  std::size_t done = 0;
  for (std::size_t column = n_columns; column-- > 0 && done < rows.size();) {
    const auto found = std::find_if(rows.begin() + static_cast<std::ptrdiff_t>(done), rows.end(),
                                    [&](const std::vector<Rational>& row) { return row[column] != Rational(0); });
    if (found == rows.end()) continue;
    std::swap(rows[done], *found);
    const Rational pivot = rows[done][column];
    for (Rational& entry : rows[done]) entry = entry / pivot;
    for (std::size_t r = 0; r < rows.size(); ++r) {
      if (r == done || rows[r][column] == Rational(0)) continue;
      const Rational factor = rows[r][column];
      for (std::size_t c = 0; c < n_columns; ++c) rows[r][c] = rows[r][c] - factor * rows[done][c];
    }
    pivot_row[column] = static_cast<int>(done++);
  }
  return pivot_row;
}

/// The smallest integers in the same proportion.
std::vector<std::int64_t> integers(const std::vector<Rational>& weights) {
  Rational multiple(1);
  for (const Rational& w : weights) multiple = multiple * Rational((multiple * w).denominator());
  std::vector<std::int64_t> result;
  std::int64_t divisor = 0;
  for (const Rational& w : weights) {
    result.push_back((multiple * w).numerator());
    divisor = std::gcd(divisor, result.back());
  }
  for (std::int64_t& w : result) w /= divisor;
  return result;
}

ConservedSum named(const std::vector<std::string>& species, const std::vector<std::int64_t>& weights) {
  ConservedSum sum;
  for (std::size_t s = 0; s < species.size(); ++s) {
    const std::int64_t w = weights[s];
    sum.weights.push_back(static_cast<double>(w));
    if (w == 0) continue;
    const char* sign = sum.text.empty() ? (w < 0 ? "-" : "") : (w < 0 ? " - " : " + ");
    const std::int64_t size = w < 0 ? -w : w;
    sum.text += size == 1 ? fmt::format("{}{}", sign, species[s]) : fmt::format("{}{} {}", sign, size, species[s]);
  }
  return sum;
}

}  // namespace

std::vector<ConservedSum> conserved_sums(const std::vector<std::string>& species, const std::vector<std::vector<Rational>>& changes) {
  Rows rows = changes;
  const std::vector<int> pivot_row = reduce(rows, species.size());
  std::vector<ConservedSum> sums;
  for (std::size_t free = 0; free < species.size(); ++free) {
    if (pivot_row[free] >= 0) continue;
    std::vector<Rational> weights(species.size());
    weights[free] = Rational(1);
    for (std::size_t s = 0; s < species.size(); ++s) {
      if (pivot_row[s] >= 0) weights[s] = Rational(0) - rows[static_cast<std::size_t>(pivot_row[s])][free];
    }
    sums.push_back(named(species, integers(weights)));
  }
  return sums;
}

}  // namespace stiffront
