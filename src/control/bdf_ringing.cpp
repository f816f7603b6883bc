// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/bdf_ringing.hpp"

#include <algorithm>
#include <cstdint>
#include <span>

#include "stiffront/control/sbdf_stability.hpp"
#include "stiffront/model/reaction_modes.hpp"

namespace stiffront {

bool bdf_rings(int order, std::complex<double> step_lambda) {
  if (!(step_lambda.real() < 0.0)) return false;
  const auto weights = sbdf_stability::constant_step_weights(order);
  const std::complex<double> solved_exactly = 0.0;
  return !sbdf_stability::roots_within(sbdf_stability::recursion(weights, solved_exactly, -weights.gamma * step_lambda), 1.002);
}

int highest_quiet_order(int max_order, double t, double dt, const Field& u, const ReactionTerm& model, const FreeBox& box) {
  // An eigenvalue problem costs a hundred times what a sweep does at a point: on small grids not all points are asked.
  const std::int64_t at_most = std::clamp<std::int64_t>(u.decomposition().grid().total_points() / 4, 128, 1024);
  int quiet = max_order;
  look_at_reaction_modes(model, t, u, box, at_most, [&](int, int, std::span<const std::complex<double>> modes) {
    for (const std::complex<double>& lambda : modes) {
      if (!(lambda.imag() > 0.0)) continue;
      while (quiet > 2 && (bdf_rings(quiet, dt * lambda) || bdf_rings(quiet, 1.5 * dt * lambda))) --quiet;
    }
    return quiet > 2;
  });
  return quiet;
}

}  // namespace stiffront
