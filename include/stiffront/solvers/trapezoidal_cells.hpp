// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>

#include "stiffront/model/reaction_term.hpp"
#include "stiffront/solvers/reaction_solver.hpp"

namespace stiffront {

/// Every cell by one step of the trapezoidal rule, solved by Newton's iteration to the relative and absolute tolerance: the reaction flow
/// of textbook splittings, of order two and with no error estimate.
/// @see Ropp, Shadid & Ober, J. Comput. Phys. 194, 2004
std::unique_ptr<ReactionSolver> make_trapezoidal_cells(const ReactionTerm& reaction, const CellTolerances& tolerances);

}  // namespace stiffront
