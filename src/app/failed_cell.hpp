// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <vector>

#include "stiffront/app/problem.hpp"
#include "stiffront/solvers/flow.hpp"

namespace stiffront::app {

/// Of the failures in a row of rejected attempts, the first and so the longest of the cell that failed last: it begins farthest from
/// the trouble and shows most of the way into it. @pre not empty
const CellFailure& most_telling(const std::vector<CellFailure>& failures);

/// What is known of a failed cell in one sentence.
std::string describe(const CellFailure& failure, const std::vector<std::string>& species);

/// A case file, TOML, in which the cell is alone: its state and place, no diffusion, the sub-step in which it failed.
/// `stiffront run` of it fails in the same way if the reaction alone is to blame.
/// @param reaction_tolerance the one that was in use
std::string failed_cell_case(const Case& c, const CellFailure& failure, double reaction_tolerance);

}  // namespace stiffront::app
