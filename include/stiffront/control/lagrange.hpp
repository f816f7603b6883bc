// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <vector>

namespace stiffront {

/// Values at x of the Lagrange polynomials of distinct nodes: the weights that extrapolate from the nodes to x.
template <class Real>
std::vector<Real> lagrange(const std::vector<Real>& nodes, Real x) {
  std::vector<Real> values(nodes.size(), 1);
  for (std::size_t a = 0; a < nodes.size(); ++a) {
    for (std::size_t b = 0; b < nodes.size(); ++b) {
      if (b != a) values[a] *= (x - nodes[b]) / (nodes[a] - nodes[b]);
    }
  }
  return values;
}

}  // namespace stiffront
