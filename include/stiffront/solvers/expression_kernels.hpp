// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>
#include <utility>

#include "stiffront/model/expression_model.hpp"
#include "stiffront/solvers/model_kernels.hpp"

namespace stiffront {

/// Everything compiled for an expression model of M species. One translation unit for each M, made by cmake/ExpressionModels.cmake.
template <int M>
std::unique_ptr<ModelKernels> expression_kernels(ExpressionModel<M> model, ModelDescription description);

}  // namespace stiffront
