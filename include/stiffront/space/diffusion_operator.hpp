// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <vector>

#include "stiffront/mesh/boundary.hpp"
#include "stiffront/mesh/field.hpp"
#include "stiffront/space/laplacian.hpp"

namespace stiffront {

/// The diffusion part of the equations: D_s Laplacian(u_s) with one constant coefficient per species, by centred differences of
/// order 2, 4 or 8. Those of order 8 have a closure of their own next to Dirichlet sides (space/sub_cell_closure.hpp), for which the grid must
/// have sub-cells.
class DiffusionOperator {
 public:
  /// @param coefficients D_s >= 0, one per species, in units of length^2/time.
  /// @throws Error(input) for another order, a negative coefficient, or Dirichlet sides and sub-cells that do not go together.
  DiffusionOperator(const Grid& grid, const Boundary& boundary, std::vector<double> coefficients, int order);

  int order() const { return order_; }
  int dimension() const { return dimension_; }
  int n_species() const { return static_cast<int>(coefficients_.size()); }
  int halo_width() const { return order_ / 2; }
  const Boundary& boundary() const { return *boundary_; }
  double coefficient(int species) const { return coefficients_[static_cast<std::size_t>(species)]; }
  /// Species with D > 0: the only ones that need halos and stages.
  const std::vector<int>& diffusing_species() const { return diffusing_; }
  /// D_s/dx^2 and D_s/dy^2 (0 in one dimension).
  double k_x(int species) const { return coefficient(species) * inverse_dx2_[0]; }
  double k_y(int species) const { return coefficient(species) * inverse_dx2_[1]; }
  /// (dx/dy)^2: k_y over k_x, the same for all species (0 in one dimension).
  double anisotropy() const { return inverse_dx2_[1] / inverse_dx2_[0]; }
  /// Largest eigenvalue of -D_s Laplacian: exact bound, never below.
  double spectral_radius(int species) const;
  /// The largest over all species.
  double spectral_radius() const;

  /// The stencil of a species on fields of the given shape, for fused kernels. Order and Dimension must be those of the operator.
  template <int Order, int Dimension>
  Laplacian<Order, Dimension> stencil(int species, const Field& u) const {
    return {k_x(species), k_y(species), u.row_stride()};
  }
  /// Calls f.template operator()<Order, Dimension>() with the operator's own. @pre order 2 or 4: only for them there are fused kernels
  template <class F>
  decltype(auto) dispatch(F&& f) const {
    if (order_ == 2) return dimension_ == 1 ? f.template operator()<2, 1>() : f.template operator()<2, 2>();
    return dimension_ == 1 ? f.template operator()<4, 1>() : f.template operator()<4, 2>();
  }

  /// du = D Laplacian(u) at the points of the box. Halos of u must be up to date.
  void apply(const Field& u, Field& du, const FreeBox& box) const;
  /// The same for one species. @pre order 8
  void apply_of_order_8(const Field& u, Field& du, int species, const FreeBox& box) const;
  /// Points a row of the operator's matrix reaches in either direction: more than the halo next to a sub-cell.
  int reach() const;
  /// The diagonal coefficient of -Laplacian in units of 1/dx^2 or 1/dy^2, away from the sides.
  double diagonal() const;

 private:
  int order_;
  int dimension_;
  const Boundary* boundary_;
  std::vector<double> coefficients_;
  std::vector<int> diffusing_;
  double inverse_dx2_[2];
  double radius_[2];  // of the second difference in either direction
};

}  // namespace stiffront
