// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <span>
#include <vector>

#include "stiffront/mesh/boundary.hpp"
#include "stiffront/mesh/field.hpp"

namespace stiffront {

/// Nonlinear GMRES for a fixed-point iteration v -> G(v) on a set of fields: of all combinations of the iterates so far, the one whose
/// residual G(v) - v is least for linear G, mapped once more by G. For linear G the iterates are those of GMRES, preconditioned by the
/// iteration itself, followed by one iteration.
///
/// Inner products are reproducible sums over the free points, each species divided by its scale.
/// @see Huang, Jia & Minion, J. Comput. Phys. 214, 2006, 633-656 (GMRES for spectral deferred correction); Walker & Ni, SIAM J. Numer.
///      Anal. 49(4), 2011, 1715-1735 (the nonlinear form, Anderson's, and its equality to GMRES)
/// @cost 2 sets of fields per iteration kept; two reductions per iteration
class SweepAcceleration {
 public:
  /// @param n_fields in a set; @param depth differences kept at most
  SweepAcceleration(const Field& shape, const FreeBox& free, std::size_t n_fields, std::size_t depth);

  /// Forgets all iterates. @param scales of the species
  void reset(std::span<const double> scales);
  /// From v and its residual G(v) - v to the next iterate, in v. @mpi collective.
  void next(std::span<Field> v, std::span<const Field> residual);

 private:
  /// Scaled inner products of x with several sets.
  std::vector<double> products(std::span<const std::span<const Field>> sets, std::span<const Field> x) const;

  FreeBox free_;
  std::size_t n_fields_;
  const Communicator* comm_;
  std::vector<double> inverse_scales_;
  std::size_t known_ = 0;  // orthonormal differences of residuals
  bool has_last_ = false;
  std::vector<std::vector<Field>> q_;  // orthonormal
  std::vector<std::vector<Field>> w_;  // the differences of iterates that belong to them
  std::vector<Field> last_v_;
  std::vector<Field> last_residual_;
};

}  // namespace stiffront
