// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <memory>
#include <span>

#include "stiffront/solvers/sbdf_equations.hpp"

namespace stiffront {

/// Corrections on coarser grids of an iterate v of the BDF equation v = r + gamma (rates(t, v) + D Laplacian(v)) in two dimensions.
///
/// The sweeps of the finest grid (solvers/sbdf_kernel.hpp) come in three groups with a correction after the first and the second; they
/// damp what a coarser grid cannot hold, and the corrections all the rest:
///
///     (1 - gamma J - gamma D Laplacian_2) c = means of r - v + gamma (rates(t, v) + D Laplacian(v)),    v += c interpolated,
///
/// by a V-cycle with damped cell-Jacobi steps, J the reaction Jacobian at the points of the coarser grid, means of it on the next ones.
/// All of it together leaves at most 1/39 of the error of v in any mode, whatever gamma and for both orders of the differences.
///
/// Which points a grid has does not depend on the ranks, and all is computed point by point: the bits do not depend on them either.
/// @cost   per correction one evaluation of the rates and about 2 m^2 + 6 m numbers read per point; memory: 1/3 (2 m^2 + 3 m) + m fields
/// @see    Trottenberg, Oosterlee & Schueller, Multigrid, 2001, sections 2 and 5
class PlaneCorrection {
 public:
  static constexpr std::size_t groups = 3;

  virtual ~PlaneCorrection() = default;
  /// The shifts of the sweeps of a group.
  virtual std::span<const double> shifts(std::size_t group) const = 0;
  /// Makes the matrices of the coarser grids. @param sweep of the iterate; its output is not used. @mpi collective
  virtual void prepare(const SbdfEquations& equations, const SbdfSweep& sweep) = 0;
  /// @param sweep of the iterate, its halo up to date; its output is not used. @pre prepare() has been called with its gamma
  /// @param v the iterate. @mpi collective
  virtual void correct(const SbdfEquations& equations, const SbdfSweep& sweep, Field& v) = 0;
};

/// @param shape a field of the shape of the states, with 1 to 8 species in two dimensions
/// @throws Error(input) for another number of species
std::unique_ptr<PlaneCorrection> make_plane_correction(const Field& shape, const DiffusionOperator& diffusion);

/// The most species there is a correction for.
inline constexpr int plane_correction_species = 8;

}  // namespace stiffront
