// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>

#include "stiffront/solvers/flow.hpp"
#include "stiffront/solvers/implicit_part.hpp"
#include "stiffront/space/coupled_rhs.hpp"

namespace stiffront {

/// X^t by one step of the trapezoidal rule, diffusion and transport together, in one dimension: the diffusion flow of textbook splittings,
/// and the only one for models with first derivatives.
///
/// The equation of the step is solved by the iteration that inverts the three-point part of the operator (make_block_tridiagonal_part), as
/// far as the tolerance says; each iteration gains a factor of three or more.
///
/// @mpi one halo exchange, what the line solver needs and one agreement per iteration
/// @cost of no order but two, and with no error estimate: the caller's step is the only one
/// @see Ropp, Shadid & Ober, J. Comput. Phys. 194, 2004
class CrankNicolson final : public Flow {
 public:
  /// @param tolerance of the iteration, relative to the largest value of each species
  /// @throws Error(input) in two dimensions
  CrankNicolson(const Field& shape, CoupledRhs& rhs, double tolerance);

  using Flow::advance;
  std::optional<CellFailure> advance(double t, double dt, std::span<const Transition> states, Work& work) override;

 private:
  bool solve(double t, double dt, Field& from, Field& to, Work& work);

  CoupledRhs* rhs_;
  double tolerance_;
  FreeBox free_;
  std::unique_ptr<ImplicitPart> part_;
  Field start_, base_, slope_, change_, next_;
};

}  // namespace stiffront
