// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "case_tree.hpp"
#include "stiffront/app/options.hpp"
#include "stiffront/model/model.hpp"

namespace stiffront::app {

/// Fills in the defaults that depend on other entries and checks what one key alone cannot tell.
/// @throws Error(input)
void complete(Case& c, const CaseTree& tree, const std::vector<ModelDescription>& models);

/// Fewest points of a direction whose differences have this order; dirichlet: whether there is a side of given values.
int fewest_points(int order, bool dirichlet);

}  // namespace stiffront::app
