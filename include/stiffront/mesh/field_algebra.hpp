// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <span>

#include "stiffront/mesh/field.hpp"

namespace stiffront {

/// A field times a number.
struct Term {
  double factor;
  const Field* field;
};

/// result = sum of factor * field over the interior, terms added in the order given; the result may be one of the terms.
/// @cost one pass
void combine(std::span<const Term> terms, Field& result);

}  // namespace stiffront
