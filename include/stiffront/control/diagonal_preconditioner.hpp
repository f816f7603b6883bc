// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <vector>

#include "stiffront/control/collocation.hpp"

namespace stiffront {

/// Coefficients d_1 .. d_m of diagonal deferred corrections on m Radau nodes, each node by itself, whose iteration matrix I - diag(1/d) S is
/// nilpotent: in the stiff limit m sweeps reach collocation (MIN-SR-S).
///
/// The characteristic polynomial of diag(1/d) S must be (lambda - 1)^m, so the sums of its principal minors must be binomial coefficients: m
/// equations, each linear in every 1/d_i, solved by Newton's method. It starts from the solution for m - 1 nodes, carried over by a power
/// law of the nodes.
///
/// @param m 1 .. 8
/// @throws Error(bug) if Newton's method does not converge
/// @see Caklovic, Lunet, Goetschel, Ruprecht, "Improving parallelism across the method with spectral deferred corrections", SIAM J. Sci.
///      Comput. 47(1), 2025
std::vector<double> min_sr_s(int m);

}  // namespace stiffront
