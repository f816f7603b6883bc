// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <complex>
#include <cstdint>
#include <functional>
#include <span>

#include "stiffront/mesh/boundary.hpp"
#include "stiffront/mesh/field.hpp"
#include "stiffront/model/reaction_term.hpp"

namespace stiffront {

/// The eigenvalues of the reaction Jacobian (in units of 1/time) at some points of the grid.
///
/// Calls f(i, j, eigenvalues) for local indices i, j in the box, until f returns false; no eigenvalues are passed where
/// the Jacobian is not finite. The points are chosen by global index, so that all ranks together look at the same ones.
/// @param at_most about how many points of the whole grid are looked at. No communication.
void look_at_reaction_modes(const ReactionTerm& model, double t, const Field& u, const FreeBox& box, std::int64_t at_most,
                            const std::function<bool(int, int, std::span<const std::complex<double>>)>& f);

}  // namespace stiffront
