// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "stiffront/app/options.hpp"
#include "stiffront/solvers/custom_model.hpp"

namespace stiffront::app {

/// A model written in the case file, as it is compiled.
CustomModel custom_model_of(const ModelOptions& options);

}  // namespace stiffront::app
