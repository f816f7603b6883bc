// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>

#include "stiffront/app/options.hpp"
#include "stiffront/control/spectral_deferred_correction.hpp"

namespace stiffront::app {

/// Whether start and corrections are compositions of the flows of reaction and diffusion.
inline bool composes_flows(const SdcOptions& o) { return o.splitting == SdcSplitting::lie || o.splitting == SdcSplitting::strang; }

/// Fills in what depends on other keys.
inline void complete_sdc(SdcOptions& o, int space_order) {
  const int below_even = o.nodes == NodeFamily::gauss_legendre ? 0 : (o.nodes == NodeFamily::gauss_radau ? 1 : 2);
  if (!o.starting_order && composes_flows(o)) o.starting_order = o.splitting == SdcSplitting::lie ? 1 : 2;
  if (!o.starting_order) o.starting_order = std::clamp(o.node_count - 1, 1, o.splitting == SdcSplitting::diagonal ? 3 : 2);
  if (!o.corrections) o.corrections = std::max(0, 2 * o.node_count - below_even - *o.starting_order);
  if (!o.gamma_diffusion && o.splitting == SdcSplitting::diagonal) o.gamma_diffusion = 0.25;
  if (!o.gamma_diffusion) o.gamma_diffusion = space_order == 2 ? 1.0 : 2.0;
}

/// The parameters of the method from complete options.
inline SpectralDeferredCorrectionOptions sdc_parameters(const SdcOptions& o) {
  SpectralDeferredCorrectionOptions s;
  switch (o.nodes) {
    case NodeFamily::gauss_legendre:
      s.nodes = stiffront::NodeFamily::gauss_legendre;
      break;
    case NodeFamily::gauss_lobatto:
      s.nodes = stiffront::NodeFamily::gauss_lobatto;
      break;
    case NodeFamily::gauss_radau:
      s.nodes = stiffront::NodeFamily::gauss_radau;
      break;
  }
  s.node_count = o.node_count;
  s.fixed_step = o.step.value_or(0.0);
  s.tolerance = o.tolerance.value_or(0.0);
  s.initial_step = o.initial_step;
  s.starting_order = *o.starting_order;
  s.corrections = *o.corrections;
  s.consistent = o.consistent;
  s.accelerate = o.acceleration;
  using Correction = SpectralDeferredCorrectionOptions::Correction;
  s.correction = o.correction == SdcCorrection::standard ? Correction::standard : Correction::alternative;
  using FinalUpdate = SpectralDeferredCorrectionOptions::FinalUpdate;
  switch (o.final_update) {
    case SdcFinalUpdate::automatic:
      s.final_update = FinalUpdate::automatic;
      break;
    case SdcFinalUpdate::last_node:
      s.final_update = FinalUpdate::last_node;
      break;
    case SdcFinalUpdate::quadrature:
      s.final_update = FinalUpdate::quadrature;
      break;
    case SdcFinalUpdate::extrapolation:
      s.final_update = FinalUpdate::extrapolation;
      break;
  }
  return s;
}

}  // namespace stiffront::app
