// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <vector>

#include "stiffront/app/command_line.hpp"
#include "stiffront/model/model.hpp"

namespace stiffront::app {

/// The table of a domain of stability of method sdc; with an output directory it goes to stability.json there, with the raster.
/// @throws Error(input) for a key that method sdc does not have, and for adaptive or accelerated steps, whose map is not linear
std::string measure_stability(const StabilityCommand& command, const std::vector<ModelDescription>& models);

}  // namespace stiffront::app
