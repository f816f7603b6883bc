// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "stiffront/mesh/boundary.hpp"
#include "stiffront/mesh/field.hpp"

namespace stiffront {

/// What a model in one dimension has beyond diffusion with constant coefficients and rates: terms with first derivatives (advection,
/// coordinates of cylinders and spheres, chemotaxis) and second derivatives of other species or with coefficients that vary,
///
///     u_t = D u_xx + transport(t, x, u, u_x, u_xx) + rates(t, x, u)
///
/// @see Hagstrom & Zhou, Commun. Appl. Math. Comput. Sci. 1(1), 2006, eq. (6-1)
class TransportTerm {
 public:
  virtual ~TransportTerm() = default;
  /// du += transport at the points of the box; other points are left alone. No communication.
  virtual void add(double t, const Field& u, const Field& u_x, const Field& u_xx, Field& du, const FreeBox& box) const = 0;
  /// a = the derivative of each species' transport with respect to its own first derivative, at the points of the box: minus its velocity.
  virtual void advection(double t, const Field& u, const Field& u_x, Field& a, const FreeBox& box) const = 0;
};

}  // namespace stiffront
