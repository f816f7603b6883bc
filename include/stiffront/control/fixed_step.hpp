// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "stiffront/control/method.hpp"
#include "stiffront/mesh/boundary.hpp"
#include "stiffront/splitting/composition.hpp"
#include "stiffront/splitting/reaction_flow.hpp"

namespace stiffront {

/// A splitting with a fixed step: methods `lie` and `strang`.
///
/// No error is estimated; an attempt whose state is not finite or in which a cell cannot be integrated is retried with half the step,
/// and the given size is taken up again afterwards.
class FixedStep final : public Method {
 public:
  /// @param composition of the reaction and the diffusion flow, which must outlive the method.
  FixedStep(const Decomposition& decomposition, const Boundary& boundary, ReactionFlow& reaction, Flow& diffusion, Composition composition,
            double step);

  double first_step(double t, double t_end, Field& u) override;
  Attempt attempt(double t, double dt, Field& u, Field& u_new, std::uint64_t& flags) override;
  void visit_state(StateVisitor& visitor) override;

 private:
  const Communicator* comm_;
  FreeBox free_;
  ReactionFlow* reaction_;
  Flow* diffusion_;
  Composition composition_;
  double step_;
};

/// The state of the two flows of a splitting, for checkpoints.
void visit_flows(StateVisitor& visitor, ReactionFlow& reaction, Flow& diffusion);

}  // namespace stiffront
