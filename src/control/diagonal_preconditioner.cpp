// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/diagonal_preconditioner.hpp"

#include <cmath>
#include <cstddef>
#include <utility>

#include "stiffront/core/error.hpp"

namespace stiffront {
namespace {

using Matrix = std::vector<std::vector<double>>;

/// Replaces a by factors, with row exchanges, and b by the solution. @return the determinant
double eliminate(Matrix a, std::vector<double>& b) {
  const std::size_t n = a.size();
  double determinant = 1.0;
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t pivot = k;
    for (std::size_t i = k + 1; i < n; ++i) {
      if (std::abs(a[i][k]) > std::abs(a[pivot][k])) pivot = i;
    }
    if (pivot != k) {
      std::swap(a[k], a[pivot]);
      std::swap(b[k], b[pivot]);
      determinant = -determinant;
    }
    determinant *= a[k][k];
    for (std::size_t i = k + 1; i < n; ++i) {
      const double factor = a[i][k] / a[k][k];
      for (std::size_t j = k; j < n; ++j) a[i][j] -= factor * a[k][j];
      b[i] -= factor * b[k];
    }
  }
  for (std::size_t k = n; k-- > 0;) {
    for (std::size_t j = k + 1; j < n; ++j) b[k] -= a[k][j] * b[j];
    b[k] /= a[k][k];
  }
  return determinant;
}

/// Principal minors of a, by the set of rows as bits.
std::vector<double> principal_minors(const Matrix& a) {
  const std::size_t n = a.size();
  std::vector<double> minors(std::size_t{1} << n, 1.0);
  for (std::size_t set = 1; set < minors.size(); ++set) {
    std::vector<std::size_t> rows;
    for (std::size_t i = 0; i < n; ++i) {
      if ((set >> i & 1U) != 0) rows.push_back(i);
    }
    Matrix part;
    for (std::size_t i : rows) {
      part.emplace_back();
      for (std::size_t j : rows) part.back().push_back(a[i][j]);
    }
    std::vector<double> unused(rows.size(), 0.0);
    minors[set] = eliminate(std::move(part), unused);
  }
  return minors;
}

/// The solution next to the guess, all positive.
std::vector<double> solve(const Matrix& s, const std::vector<double>& guess) {
  const std::size_t m = s.size();
  const std::vector<double> minors = principal_minors(s);
  std::vector<double> x;
  for (double d : guess) x.push_back(1.0 / d);
  std::vector<double> binomial(m + 1, 1.0);
  for (std::size_t k = 1; k <= m; ++k) binomial[k] = binomial[k - 1] * static_cast<double>(m + 1 - k) / static_cast<double>(k);
  for (int iteration = 0; iteration < 50; ++iteration) {
    std::vector<double> residual(m, -1.0);
    Matrix slope(m, std::vector<double>(m, 0.0));
    for (std::size_t set = 1; set < minors.size(); ++set) {
      std::size_t size = 0;
      for (std::size_t i = 0; i < m; ++i) size += set >> i & 1U;
      double value = minors[set] / binomial[size];
      for (std::size_t i = 0; i < m; ++i) {
        if ((set >> i & 1U) != 0) value *= x[i];
      }
      residual[size - 1] += value;
      for (std::size_t i = 0; i < m; ++i) {
        if ((set >> i & 1U) != 0) slope[size - 1][i] += value / x[i];
      }
    }
    eliminate(std::move(slope), residual);
    double step = 1.0;  // shortened to keep all unknowns positive
    for (std::size_t i = 0; i < m; ++i) {
      while (x[i] - step * residual[i] <= 0.0) step *= 0.5;
    }
    double change = 0.0;
    for (std::size_t i = 0; i < m; ++i) {
      change = std::max(change, std::abs(residual[i]) / x[i]);
      x[i] -= step * residual[i];
    }
    if (change < 1e-13) {
      for (double& value : x) value = 1.0 / value;
      return x;
    }
  }
  throw Error(ErrorKind::bug, "the coefficients of a diagonal preconditioner were not found");
}

}  // namespace

std::vector<double> min_sr_s(int m) {
  std::vector<double> d{1.0};
  std::vector<double> c{1.0};
  for (int n = 2; n <= m; ++n) {
    // d = alpha c^beta / n, fitted to the solution before.
    const double count = static_cast<double>(d.size());
    double mean_x = 0.0;
    double mean_y = 0.0;
    for (std::size_t i = 0; i < d.size(); ++i) {
      mean_x += std::log(c[i]) / count;
      mean_y += std::log(count * d[i]) / count;
    }
    double product = 0.0;
    double square = 0.0;
    for (std::size_t i = 0; i < d.size(); ++i) {
      product += (std::log(c[i]) - mean_x) * (std::log(count * d[i]) - mean_y);
      square += (std::log(c[i]) - mean_x) * (std::log(c[i]) - mean_x);
    }
    const double beta = square > 0.0 ? product / square : 1.0;
    const double alpha = std::exp(mean_y - beta * mean_x);
    const CollocationNodes nodes = collocation_nodes(NodeFamily::gauss_radau, n);
    std::vector<double> guess;
    for (double at : nodes.c) guess.push_back(alpha * std::pow(at, beta) / n);
    d = solve(nodes.s, guess);
    c = nodes.c;
  }
  return d;
}

}  // namespace stiffront
