// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>

#include "stiffront/mesh/boundary.hpp"
#include "stiffront/mesh/decomposition.hpp"

namespace stiffront {

/// The most stages per exchange that halos `stencil` wide per stage allow: what is sent must lie within a box, and
/// Dirichlet values of a neighbour's far side that change with time must not. 1 where there is nobody to exchange with.
int largest_halo_depth(const Decomposition& d, const Boundary& boundary, int stencil);

/// Seconds that an exchange of a few bytes with all neighbours takes, the largest over the ranks of the least of a few
/// trials.
/// @mpi collective
double measure_exchange(const Decomposition& d);

/// What the stages of an explicit method cost on the largest box, by the number of stages per exchange of halos.
///
/// Each exchange costs its messages, as far as work on points that need no halo does not hide them; each stage but the
/// last after an exchange costs the points it computes in the neighbours' place. A large box is brought from memory once per exchange.
/// @see docs/scaling.md
class HaloCost {
 public:
  /// @param exchange seconds, see measure_exchange
  HaloCost(const Decomposition& d, int stencil, double exchange);

  /// Seconds of so many stages of a state of so many variables per point with `depth` stages per exchange.
  double seconds(int depth, int stages, int variables) const;
  /// The depth up to `largest` with the least of them.
  int best_depth(int largest, int stages, int variables) const;

 private:
  std::array<double, 2> points_{1.0, 1.0};      ///< of the box
  std::array<double, 2> neighbours_{0.0, 0.0};  ///< per direction: 0, 1 or 2 of this rank's sides
  double stencil_;
  double exchange_;
};

}  // namespace stiffront
