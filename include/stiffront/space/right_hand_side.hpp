// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "stiffront/mesh/boundary.hpp"
#include "stiffront/mesh/field.hpp"

namespace stiffront {

/// The right-hand side of u' = F(t, u), for methods that take it as a whole.
class RightHandSide {
 public:
  virtual ~RightHandSide() = default;
  /// du = F(t, u). Dirichlet points get du = 0. The halo of u is brought up to date. @mpi collective.
  virtual void evaluate(double t, Field& u, Field& du) = 0;
  virtual const Boundary& boundary() const = 0;
};

}  // namespace stiffront
