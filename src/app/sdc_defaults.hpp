// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>

#include "stiffront/app/options.hpp"

namespace stiffront::app {

/// Fills in what depends on other keys.
inline void complete_sdc(SdcOptions& o, int space_order) {
  const int below_even = o.nodes == NodeFamily::gauss_legendre ? 0 : (o.nodes == NodeFamily::gauss_radau ? 1 : 2);
  if (!o.starting_order) o.starting_order = std::clamp(o.node_count - 1, 1, 2);
  if (!o.corrections) o.corrections = std::max(0, 2 * o.node_count - below_even - *o.starting_order);
  if (!o.gamma_diffusion) o.gamma_diffusion = space_order == 2 ? 1.0 : 2.0;
}

}  // namespace stiffront::app
