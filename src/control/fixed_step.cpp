// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/fixed_step.hpp"

#include <utility>

#include "stiffront/control/state_norm.hpp"

namespace stiffront {

FixedStep::FixedStep(const Decomposition& decomposition, const Boundary& boundary, ReactionFlow& reaction, Flow& diffusion,
                     Composition composition, double step)
    : comm_(&decomposition.comm()),
      free_(boundary.free_box(decomposition)),
      reaction_(&reaction),
      diffusion_(&diffusion),
      composition_(std::move(composition)),
      step_(step) {}

double FixedStep::first_step(double, double, Field&) { return step_; }

Attempt FixedStep::attempt(double t, double dt, Field& u, Field& u_new, std::uint64_t& flags) {
  Attempt a;
  a.failure = advance({reaction_, diffusion_}, composition_, t, dt, u, u_new, a.work);
  Agreement agreement(0, 0);
  agreement.flags = flags | inspect(u_new, free_);
  if (a.failure) agreement.flags |= step_flags::cell_failed;
  comm_->agree(agreement);
  flags = agreement.flags;
  a.accepted = !refuses(a, flags, u, u_new, free_, t, dt);
  a.dt_next = a.accepted ? step_ : 0.5 * dt;
  return a;
}

void visit_flows(StateVisitor& visitor, ReactionFlow& reaction, Flow& diffusion) {
  visitor.cells("reaction_steps", reaction.hints());
  std::vector<double> numbers = diffusion.state();
  visitor.numbers("diffusion_flow", numbers);
  diffusion.set_state(numbers);
}

void FixedStep::visit_state(StateVisitor& visitor) { visit_flows(visitor, *reaction_, *diffusion_); }

}  // namespace stiffront
