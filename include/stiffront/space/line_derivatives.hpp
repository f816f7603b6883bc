// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "stiffront/mesh/boundary.hpp"
#include "stiffront/mesh/field.hpp"

namespace stiffront {

/// du/dx and d2u/dx2 of every species in one dimension, by centred differences of order 2, 4 or 8 with the boundaries of DiffusionOperator.
class LineDerivatives {
 public:
  LineDerivatives(const Grid& grid, int order) : order_(order), spacing_(grid.spacing(0)) {}

  /// At the points of the box. Halos of u must be up to date.
  void first(const Field& u, Field& u_x, const FreeBox& box) const;
  void second(const Field& u, Field& u_xx, const FreeBox& box) const;

 private:
  int order_;
  double spacing_;
};

}  // namespace stiffront
