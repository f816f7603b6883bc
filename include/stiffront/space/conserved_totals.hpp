// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <vector>

#include "stiffront/mesh/field.hpp"
#include "stiffront/model/conserved_sums.hpp"

namespace stiffront {

/// The integrals of conserved sums over the domain, by the trapezoidal rule: with it, differences of order 2 and 4 that mirror at
/// Neumann sides or wrap around conserve them exactly too, so that a total changes by rounding and by what the time integration
/// leaves unsolved.
/// @mpi collective on u.comm(); the same on every rank and for every number of ranks
std::vector<double> conserved_totals(const std::vector<ConservedSum>& sums, const Field& u);

}  // namespace stiffront
