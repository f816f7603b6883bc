// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <complex>

#include "stiffront/mesh/boundary.hpp"
#include "stiffront/mesh/field.hpp"
#include "stiffront/model/reaction_term.hpp"

namespace stiffront {

/// Whether BDF(order) with equal steps lets a decaying mode grow by a factor of more than 1.002 a step. That happens
/// for oscillations near the imaginary axis: order 3 beyond an angle of 86.0 degrees from the negative real axis, order
/// 4 beyond 73.3, order 5 beyond 51.8, in a range of the step around one radian.
/// @param step_lambda the mode's eigenvalue times the step; nothing rings unless its real part is negative
bool bdf_rings(int order, std::complex<double> step_lambda);

/// The highest order up to which no decaying reaction mode rings at this step or one and a half times it, at least 2: a
/// control that is kept at the edge of the range sits just below it.
///
/// Looks at the eigenvalues of the reaction Jacobian in a quarter of the points of the whole grid, at least 128 and at
/// most some 1000, chosen by global index. This rank's points only; no communication.
int highest_quiet_order(int max_order, double t, double dt, const Field& u, const ReactionTerm& model, const FreeBox& box);

}  // namespace stiffront
