// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/splitting/composition.hpp"

namespace stiffront {
namespace {

Process last_of(SplittingOrder order) { return order == SplittingOrder::reaction_last ? Process::reaction : Process::diffusion; }
Process other(Process p) { return p == Process::reaction ? Process::diffusion : Process::reaction; }

}  // namespace

Composition lie(SplittingOrder order) {
  const Process last = last_of(order);
  return {{other(last), 1.0}, {last, 1.0}};
}

Composition strang(SplittingOrder order) { return shifted_strang(order, 0.0); }

Composition shifted_strang(SplittingOrder order, double epsilon) {
  const Process last = last_of(order);
  return {{last, 0.5 + epsilon}, {other(last), 1.0}, {last, 0.5 - epsilon}};
}

std::optional<CellFailure> advance(const SplitFlows& flows, const Composition& composition, double t, double dt, Field& from, Field& to,
                                   Work& work) {
  std::optional<CellFailure> first;
  double consumed[2] = {0.0, 0.0};
  Field* current = &from;
  for (const Substep& substep : composition) {
    double& clock = consumed[substep.process == Process::reaction ? 0 : 1];
    auto failure = flows.of(substep.process).advance(t + clock * dt, substep.fraction * dt, *current, to, work);
    if (failure && !first) first = std::move(failure);
    clock += substep.fraction;
    current = &to;
  }
  return first;
}

}  // namespace stiffront
