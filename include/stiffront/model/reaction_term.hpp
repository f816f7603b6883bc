// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "stiffront/mesh/boundary.hpp"
#include "stiffront/mesh/field.hpp"

namespace stiffront {

/// The reaction part of the equations, one virtual call for a whole box.
class ReactionTerm {
 public:
  virtual ~ReactionTerm() = default;
  virtual int n_species() const = 0;
  /// du += rates(t, x, y, u) at the points of the box; other points are left alone. Interior only, no communication.
  virtual void add_rates(double t, const Field& u, Field& du, const FreeBox& box) const = 0;
  /// product += J(t, x, y, u) direction at the points of the box, J the Jacobian of the rates.
  virtual void add_jacobian_product(double t, const Field& u, const Field& direction, Field& product, const FreeBox& box) const = 0;
  /// jacobian = J(t, x, y, u) at the points of the box: entry (r, c) in species r * n + c of a field of n^2 species. Other points are
  /// left alone.
  virtual void jacobian(double t, const Field& u, Field& jacobian, const FreeBox& box) const = 0;
  /// The same of the part of the rates that an IMEX splitting takes implicitly: all of them unless the model says otherwise.
  virtual void stiff_jacobian(double t, const Field& u, Field& result, const FreeBox& box) const { jacobian(t, u, result, box); }
  /// A bound on the modulus of the reaction Jacobian's eigenvalues over the box, some ten per cent above the largest modulus for
  /// kinetics as they are; infinity if something is not finite. This rank only.
  virtual double jacobian_bound(double t, const Field& u, const FreeBox& box) const = 0;
  /// One cell in plain doubles.
  virtual void rates_at(double t, double x, double y, const double* u, double* du) const = 0;
  /// jacobian[i*n + j] = d rates_i / d u_j.
  virtual void jacobian_at(double t, double x, double y, const double* u, double* jacobian) const = 0;
};

}  // namespace stiffront
