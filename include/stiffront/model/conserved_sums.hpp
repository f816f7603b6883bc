// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <vector>

#include "stiffront/model/rational.hpp"

namespace stiffront {

/// A weighted sum of species that no reaction changes: Σ weights[s] u_s. Where nothing flows across the boundary, its integral
/// over the domain is constant.
struct ConservedSum {
  std::string text;             ///< "A + 2 C"
  std::vector<double> weights;  ///< one per species, integers
};

/// A basis of all conserved sums: the left null space of the stoichiometric matrix, by exact elimination.
/// @param changes per reaction, the change of each species
/// @throws Error(input) if the coefficients are too large for exact arithmetic
std::vector<ConservedSum> conserved_sums(const std::vector<std::string>& species, const std::vector<std::vector<Rational>>& changes);

}  // namespace stiffront
