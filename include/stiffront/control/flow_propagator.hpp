// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <utility>

#include "stiffront/control/fixed_step.hpp"
#include "stiffront/control/spectral_deferred_correction.hpp"

namespace stiffront {

/// A composition of the flows of reaction and diffusion (Lie, Strang) as start and correction of SDC; Strang is what Hagstrom & Zhou
/// name in their conclusion. How far the corrections converge is up to the tolerances of the flows.
class FlowPropagator final : public StepPropagator {
 public:
  FlowPropagator(ReactionFlow& reaction, Flow& diffusion, Composition composition)
      : reaction_(&reaction), flows_{&reaction, &diffusion}, composition_(std::move(composition)) {}

  void advance(double t, double h, Field& from, Field& to, Attempt& a) override {
    auto failure = stiffront::advance(flows_, composition_, t, h, from, to, a.work);
    if (failure && !a.failure) a.failure = std::move(failure);
  }
  void visit_state(StateVisitor& visitor) override { visit_flows(visitor, *reaction_, *flows_.diffusion); }

 private:
  ReactionFlow* reaction_;
  SplitFlows flows_;
  Composition composition_;
};

}  // namespace stiffront
