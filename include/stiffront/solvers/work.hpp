// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>

namespace stiffront {

/// What has been done, in numbers that are the same on every machine. Reaction counts are this rank's; the others are global.
struct Work {
  std::int64_t diffusion_steps = 0;
  std::int64_t diffusion_rejections = 0;
  std::int64_t diffusion_stages = 0;  ///< evaluations of the Laplacian per advanced state
  std::int64_t reaction_steps = 0;    ///< accepted inner steps, summed over cells
  std::int64_t reaction_rejections = 0;
  std::int64_t reaction_newton_iterations = 0;
  std::int64_t reaction_rhs = 0;
  std::int64_t reaction_jacobians = 0;
  std::int64_t sweeps = 0;           ///< fused cell-local sweeps
  std::int64_t line_solves = 0;      ///< block-tridiagonal solves
  std::int64_t rhs_evaluations = 0;  ///< coupled right-hand sides
  std::int64_t linear_iterations = 0;
  std::int64_t halo_exchanges = 0;

  Work& operator+=(const Work& o) {
    diffusion_steps += o.diffusion_steps;
    diffusion_rejections += o.diffusion_rejections;
    diffusion_stages += o.diffusion_stages;
    reaction_steps += o.reaction_steps;
    reaction_rejections += o.reaction_rejections;
    reaction_newton_iterations += o.reaction_newton_iterations;
    reaction_rhs += o.reaction_rhs;
    reaction_jacobians += o.reaction_jacobians;
    sweeps += o.sweeps;
    line_solves += o.line_solves;
    rhs_evaluations += o.rhs_evaluations;
    linear_iterations += o.linear_iterations;
    halo_exchanges += o.halo_exchanges;
    return *this;
  }
};

}  // namespace stiffront
