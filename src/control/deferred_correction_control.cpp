// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/deferred_correction_control.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace stiffront {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

// After a rejection neither the number of iterations is raised nor the rejected step tried again for so many accepted steps. Where the
// errors do not follow their powers of the step, every second attempt would be rejected otherwise.
constexpr int steps_held_after_rejection = 16;
constexpr double below_rejected_step = 0.95;

// The quotient of residuals grows with the step faster than it should where a mode is about to become unstable.
constexpr double growth_with_another_iteration = 1.5;

// Numbers of iterations that are worth the same would take turns otherwise, with steps too short for the one and too long for the other.
constexpr double gain_worth_a_change = 1.05;

// The estimate for the quadrature is an extrapolation, and 1/(2 s) is a small power.
constexpr double safety_of_quadrature = 0.5;

}  // namespace

DeferredCorrectionControl::DeferredCorrectionControl(const DeferredCorrectionOptions& options, std::vector<double> stability_limits)
    : options_(options),
      limits_(std::move(stability_limits)),
      eta_(std::max(options.tolerance, least_tolerance)),
      p_(options.strang ? 2.0 : 1.0) {
  estimates_.reserve(static_cast<std::size_t>(options_.max_iterations) + 1);
}

void DeferredCorrectionControl::begin(double dt, double rate) {
  dt_ = dt;
  rate_ = rate;
  k_ = -1;
  k_allowed_ = options_.max_iterations;
  while (k_allowed_ > 1 && rate * dt > limits_[static_cast<std::size_t>(k_allowed_)]) --k_allowed_;
  reason_ = "";
  estimates_.clear();
}

DeferredCorrectionControl::Verdict DeferredCorrectionControl::finish(Verdict verdict, double dt_new) {
  const bool accepted = verdict != Verdict::reject;
  // Residuals that are 0 or nearly overflow have no quotient to go by.
  if (std::isnan(dt_new)) dt_new = accepted ? dt_ : 0.5 * dt_;
  if (accepted) {
    dt_next_ = std::min(dt_new, options_.max_growth * dt_);
    memory_.iterations = verdict == Verdict::accept ? k_ : 0;
    memory_.step = dt_;
    if (memory_.hold > 0) {
      --memory_.hold;
      dt_next_ = std::min(dt_next_, below_rejected_step * memory_.rejected_step);
    }
  } else {
    dt_next_ = std::clamp(dt_new, 0.05 * dt_, 0.9 * dt_);
    memory_.hold = steps_held_after_rejection;
    memory_.rejected_step = dt_;
  }
  return verdict;
}

/// Where a splitting commits next to no error, in layers that one of the processes makes alone, the residual of the prediction is the error
/// of the quadrature, and grows with a power up to 2 s instead of p + 1.
void DeferredCorrectionControl::observe_power() {
  const double ratio = std::log(dt_ / memory_.prediction_step);
  if (memory_.prediction_error > round_off_floor && error_ > round_off_floor) {
    if (std::abs(ratio) < 0.1) return;
    memory_.prediction_power = std::clamp(std::log(error_ / memory_.prediction_error) / ratio, p_ + 1.0, 2.0 * options_.stages);
  }
  memory_.prediction_step = dt_;
  memory_.prediction_error = error_;
}

/// (47).
double DeferredCorrectionControl::after_prediction() const {
  const double aim = options_.exponent == DeferredCorrectionOptions::Exponent::published ? eta_ * std::pow(options_.safety, p_ + 1.0)
                                                                                         : options_.safety * eta_;
  return dt_ * std::pow(aim / std::max(estimates_.front(), round_off_floor), 1.0 / std::max(memory_.prediction_power, p_ + 1.0));
}

double DeferredCorrectionControl::by_quadrature(double quadrature) const {
  if (!(quadrature > 0.0)) return infinity;
  return dt_ * std::pow(safety_of_quadrature * eta_ / quadrature, 0.5 / options_.stages);
}

DeferredCorrectionControl::Verdict DeferredCorrectionControl::judge(const Iterate& iterate) {
  ++k_;
  if (!std::isfinite(iterate.residual) || !std::isfinite(iterate.distance) || !std::isfinite(iterate.quadrature)) {
    reason_ = "the iterates are not finite";
    return finish(Verdict::reject, 0.5 * dt_);
  }
  if (k_ == 0) {
    first_residual_ = last_residual_ = iterate.residual;
    error_ = iterate.residual;  // (42)
    estimates_.push_back(error_);
    observe_power();
    if (options_.max_iterations == 0) {
      if (error_ > eta_) reason_ = "the splitting error exceeds the tolerance, and no correction is allowed";
      return finish(error_ > eta_ ? Verdict::reject : Verdict::accept, after_prediction());
    }
    // Without a correction nothing is known of the next one, and the step would stay that of the splitting alone.
    return Verdict::correct;
  }
  const bool at_floor = iterate.residual < round_off_floor;
  zeta_ = at_floor ? 0.0 : iterate.residual / (last_residual_ * dt_);
  contraction_ = at_floor ? 0.0 : iterate.residual / first_residual_;
  last_residual_ = iterate.residual;
  const bool converges = contraction_ < 1.0;
  error_ = at_floor ? iterate.residual : (converges ? contraction_ / (1.0 - contraction_) * iterate.distance : infinity);  // (43)
  estimates_.push_back(error_);

  if (error_ <= eta_) {
    if (iterate.quadrature > eta_) {
      error_ = iterate.quadrature;
      reason_ = "the quadrature does not resolve the step";
      return finish(Verdict::reject, by_quadrature(iterate.quadrature));
    }
    return finish(Verdict::accept, proposed_step(iterate));
  }
  // Corrections that do not converge say nothing against a prediction which is good enough: the splitting is stable for every step.
  if (estimates_.front() <= eta_) {
    error_ = estimates_.front();
    return finish(Verdict::accept_prediction, after_prediction());
  }
  if (!converges || zeta_ * dt_ >= 1.0) {
    if (!converges) error_ = iterate.residual;
    reason_ = "the corrections do not converge";
    // A step whose prediction is good enough may be the longer one.
    const bool published = options_.exponent == DeferredCorrectionOptions::Exponent::published;
    return finish(Verdict::reject, std::max(0.5 * std::min(dt_, 1.0 / zeta_), published ? 0.0 : after_prediction()));
  }
  if (k_ >= k_allowed_) {
    reason_ = "the error estimate exceeds the tolerance after all iterations";
    return finish(Verdict::reject, proposed_step(iterate));
  }
  // Section 5.1: what the remaining iterations can still bring. As published the factor 1/(1 - r) of this iterate would stay, though r falls.
  const double final_contraction = std::pow(zeta_ * dt_, k_allowed_ - k_) * contraction_;
  const double r = options_.exponent == DeferredCorrectionOptions::Exponent::published ? contraction_ : final_contraction;
  if (options_.predict && final_contraction / (1.0 - r) * iterate.distance > eta_) {
    reason_ = "the remaining iterations are not expected to reach the tolerance";
    return finish(Verdict::reject, proposed_step(iterate));
  }
  return Verdict::correct;
}

/// (44) or (46) as published, or with the powers the errors really have, err_j ~ dt^(j + p + 1).
double DeferredCorrectionControl::proposed_step(const Iterate& iterate) const {
  using Rule = DeferredCorrectionOptions::StepRule;
  const bool published = options_.exponent == DeferredCorrectionOptions::Exponent::published;
  const double k = k_;
  const double all = options_.max_iterations;
  const double nu = options_.safety;
  const double aim = published ? eta_ : nu * eta_;
  const double bracket = aim / ((1.0 - contraction_) * std::max(error_, round_off_floor) + contraction_ * aim);
  const double convergent = zeta_ > 0.0 ? nu / zeta_ : infinity;
  double step = 0.0;
  if (!published && options_.step_rule == Rule::k) {
    step = by_best_iterations(aim, bracket, convergent);
  } else {
    const double extra = published ? 0.0 : p_ + 1.0;
    const double by_k = dt_ * std::pow(bracket, 1.0 / (k + extra));
    const double by_kmax = dt_ * std::pow(bracket * std::pow(std::max(zeta_ * dt_, round_off_floor), k - all), 1.0 / (all + extra));
    step = options_.step_rule == Rule::k ? by_k : (options_.step_rule == Rule::kmax ? by_kmax : std::min(by_k, by_kmax));
    step = std::min((published ? nu : 1.0) * step, convergent);
  }
  return std::min(step, by_quadrature(iterate.quadrature));
}

/// Of one iteration less, as many, and one more, the number that goes farthest for its splitting steps.
double DeferredCorrectionControl::by_best_iterations(double aim, double bracket, double convergent) const {
  double best = 0.0;
  double best_value = -1.0;
  // After a rejection the number with which the last step was good enough is the one to go back to.
  const int more = memory_.hold > 0 ? k_ : k_ + 1;
  const int most = std::min(error_ > eta_ ? std::max(more, memory_.iterations) : more, options_.max_iterations);
  for (int j = std::max(0, k_ - 1); j <= most; ++j) {
    double step = 0.0;
    if (j == 0) {
      step = after_prediction();
    } else {
      const double error =
          j == k_ ? aim / bracket : (j < k_ ? estimates_[static_cast<std::size_t>(j)] : error_ * std::pow(zeta_ * dt_, j - k_));
      step = dt_ * std::pow(aim / std::max(error, round_off_floor), 1.0 / (j + p_ + 1.0));
      if (j > k_) step = std::min(step, error_ > eta_ ? memory_.step : growth_with_another_iteration * dt_);
      step = std::min({step, convergent, limits_[static_cast<std::size_t>(j)] / rate_});
    }
    const double splitting_steps = options_.stages + std::max(j, 1) * (options_.stages - 1);
    const double value = step / splitting_steps * (j == k_ ? gain_worth_a_change : 1.0);
    if (value > best_value) {
      best_value = value;
      best = step;
    }
  }
  return best;
}

}  // namespace stiffront
