// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <vector>

#include "stiffront/model/expression.hpp"

namespace stiffront {

/// The same quantities in fewer and cheaper operations, for rates that are evaluated billions of times: division by a constant
/// becomes multiplication by its reciprocal, constant factors and signs are gathered, and a product that is used once, in a sum,
/// becomes one multiply_add. Values change by rounding errors of the operations concerned, never more; nothing is reordered
/// across a sum.
///
/// Whatever is needed for `kept` stays as it is, bit by bit: the rates of a model have the same values with and without their
/// derivatives.
///
/// Expressions in which a comparison may be decided by the last bit (initial data with edges) should be left as written.
std::vector<ExpressionGraph::Node> contract(ExpressionGraph& graph, const std::vector<ExpressionGraph::Node>& roots,
                                            const std::vector<ExpressionGraph::Node>& kept = {});

}  // namespace stiffront
