// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <vector>

namespace stiffront {

enum class NodeFamily { gauss_legendre, gauss_lobatto, gauss_radau };

/// Collocation nodes on [0, 1] and the matrices of spectral integration over them.
///
/// Order of the quadrature: 2m (Legendre), 2m - 1 (Radau, right end included), 2m - 2 (Lobatto, both ends included).
/// Radau nodes and integration are the tableau of Radau IIA.
/// @see Hagstrom & Zhou, CAMCoS 1(1), 2006, section 2; Hairer & Wanner, Solving ODEs II, section IV.5
struct CollocationNodes {
  std::vector<double> c;               ///< nodes, ascending
  std::vector<std::vector<double>> s;  ///< s[k][a] = integral over [0, c_k] of the Lagrange polynomial of node a
  std::vector<double> w;               ///< w[a] = integral over [0, 1]
  std::vector<double> end;             ///< values of the Lagrange polynomials at 1: extrapolation to the end
  int quadrature_order = 0;

  int size() const { return static_cast<int>(c.size()); }
  bool starts_at_zero() const { return c.front() == 0.0; }
  bool ends_at_one() const { return c.back() == 1.0; }
  /// Integral over [c_{k-1}, c_k] (over [0, c_0] for k = 0) of the Lagrange polynomial of node a.
  double between(int k, int a) const {
    const auto i = static_cast<std::size_t>(k);
    const auto j = static_cast<std::size_t>(a);
    return k == 0 ? s[0][j] : s[i][j] - s[i - 1][j];
  }
  double interval(int k) const { return k == 0 ? c[0] : c[static_cast<std::size_t>(k)] - c[static_cast<std::size_t>(k) - 1]; }
};

/// Nodes and matrices, correct to a unit in the last place. @param m number of nodes, 1 (2 for Lobatto) .. 16.
/// @throws Error(input) for another m
CollocationNodes collocation_nodes(NodeFamily family, int m);

}  // namespace stiffront
