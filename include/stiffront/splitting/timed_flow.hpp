// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "stiffront/core/timer.hpp"
#include "stiffront/solvers/flow.hpp"

namespace stiffront {

/// A flow whose time is added to a total.
class TimedFlow final : public Flow {
 public:
  TimedFlow(Flow& flow, double& seconds) : flow_(&flow), seconds_(&seconds) {}

  using Flow::advance;
  std::optional<CellFailure> advance(double t, double dt, std::span<const Transition> states, Work& work) override {
    const ScopedTimer timer(*seconds_);
    return flow_->advance(t, dt, states, work);
  }
  std::vector<double> state() const override { return flow_->state(); }
  void set_state(std::span<const double> numbers) override { flow_->set_state(numbers); }
  void exchange_state(std::span<double> numbers) override { flow_->exchange_state(numbers); }

 private:
  Flow* flow_;
  double* seconds_;
};

}  // namespace stiffront
