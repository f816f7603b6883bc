// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/deferred_correction.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "stiffront/control/absent_species.hpp"
#include "stiffront/control/fixed_step.hpp"
#include "stiffront/core/error.hpp"
#include "stiffront/mesh/field_algebra.hpp"

namespace stiffront {
namespace {

// Below this, in the relative norm, differences of iterates are round-off: the iteration has converged as far as it can.
constexpr double round_off_floor = 2e-14;

// After a rejection the number of iterations is not raised for so many steps: where one more almost pays, trying it in every step would
// be rejected in every second.
constexpr int steps_held_after_rejection = 20;

}  // namespace

double DeferredCorrection::stability_limit(int k) {
  // With exact sub-flows, s = 3, on the negative real axis (our computation; docs/dcs.md). |R_k| grows like |z|^(k-1) beyond.
  static constexpr std::array<double, 7> limits{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(),
                                                54.4, 11.5, 7.8, 6.7, 6.0};
  return limits[static_cast<std::size_t>(std::min(k, 6))];
}

DeferredCorrection::DeferredCorrection(const Field& shape, CoupledRhs& rhs, ReactionFlow& reaction, Flow& diffusion,
                                       DeferredCorrectionOptions options)
    : comm_(&shape.comm()),
      rhs_(&rhs),
      reaction_(&reaction),
      flows_{&reaction, &diffusion},
      options_(std::move(options)),
      nodes_(collocation_nodes(NodeFamily::gauss_radau, options_.stages)),
      composition_(options_.strang ? strang(SplittingOrder::reaction_last) : lie(SplittingOrder::reaction_last)),
      order_(options_.strang ? 2 : 1),
      norm_(shape.decomposition(), rhs.diffusion().boundary(), shape.n_species(), options_.species),
      free_(rhs.free_box()) {
  for (int i = 0; i < nodes_.size(); ++i) {
    v_.push_back(shape.similar());
    f_.push_back(shape.similar());
    s_.push_back(shape.similar());
  }
  if (options_.fixed_step == 0.0) predicted_ = shape.similar();
  error_estimates_.reserve(static_cast<std::size_t>(options_.max_iterations) + 1);
  step_limits_.reserve(static_cast<std::size_t>(options_.max_iterations) + 1);
}

double DeferredCorrection::first_step(double t, double t_end, Field& u) {
  rate_ = std::max(comm_->max(rhs_->reaction().jacobian_bound(t, u, free_)), rhs_->diffusion().spectral_radius());
  if (options_.fixed_step > 0.0) return options_.fixed_step;
  const double tenth = 0.1 * (t_end - t);
  double first = rate_ * tenth > 1.0 ? 1.0 / rate_ : tenth;
  if (options_.initial_step > 0.0) first = std::min(options_.initial_step, t_end - t);
  norm_.set_floors(floors_of_absent_species(flows_, t, t_end, first, u, *comm_, work_ahead_));
  return first;
}

void DeferredCorrection::split(double t, double dt, Field& from, Field& to, Attempt& a) {
  auto failure = stiffront::advance(flows_, composition_, t, dt, from, to, a.work);
  if (failure && !a.failure) a.failure = std::move(failure);
}

/// (15): v_i = S^{dt_i} v_{i-1}. The results are the "old" S v_{i-1} of the first correction.
void DeferredCorrection::predict(double t, double dt, Field& u, Attempt& a) {
  for (int i = 0; i < nodes_.size(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    Field& left = i == 0 ? u : v_[k - 1];
    split(t + (i == 0 ? 0.0 : nodes_.c[k - 1]) * dt, nodes_.interval(i) * dt, left, s_[k], a);
    v_[k].copy_interior(s_[k]);
  }
}

void DeferredCorrection::evaluate_right_hand_sides(double t, double dt, Attempt& a) {
  for (std::size_t i = 0; i < v_.size(); ++i) rhs_->evaluate(t + nodes_.c[i] * dt, v_[i], f_[i]);
  a.work.rhs_evaluations += nodes_.size();
  a.work.halo_exchanges += nodes_.size();
}

/// result = u + dt sum w_j f_j.
void DeferredCorrection::quadrature_to_end(double dt, const Field& u, Field& result) {
  std::vector<Term>& terms = terms_;
  terms.assign(1, {1.0, &u});
  for (std::size_t j = 0; j < f_.size(); ++j) terms.push_back({dt * nodes_.w[j], &f_[j]});
  combine(terms, result);
}

/// (16), from the right-hand sides of the present iterate.
void DeferredCorrection::correct(double t, double dt, const Field& u, Attempt& a) {
  const int m = nodes_.size();
  // What does not need new values, from the last node to the first since each takes its left neighbour's old value.
  for (int i = m - 1; i >= 0; --i) {
    const auto k = static_cast<std::size_t>(i);
    std::vector<Term>& terms = terms_;
    terms.assign(1, {1.0, i == 0 ? &u : &v_[k - 1]});
    for (int j = 0; j < m; ++j) terms.push_back({dt * nodes_.between(i, j), &f_[static_cast<std::size_t>(j)]});
    if (i > 0) terms.push_back({-1.0, &s_[k]});
    combine(terms, v_[k]);
  }
  for (int i = 1; i < m; ++i) {
    const auto k = static_cast<std::size_t>(i);
    split(t + nodes_.c[k - 1] * dt, nodes_.interval(i) * dt, v_[k - 1], s_[k], a);
    const Term terms[] = {{1.0, &s_[k]}, {1.0, &v_[k]}};
    combine(terms, v_[k]);
  }
  for (std::size_t k = 0; k < v_.size(); ++k) rhs_->diffusion().boundary().impose(v_[k], t + nodes_.c[k] * dt);
  ++a.iterations;
}

Attempt DeferredCorrection::attempt(double t, double dt, Field& u, Field& u_new, std::uint64_t& flags) {
  return options_.fixed_step > 0.0 ? fixed(t, dt, u, u_new, flags) : adaptive(t, dt, u, u_new, flags);
}

void DeferredCorrection::refuse_step(double t, double dt, double rate) const {
  const double limit = stability_limit(options_.iterations);
  throw Error(ErrorKind::numerics,
              fmt::format("method.step: {} corrections with the step {:.6g} diverge (t = {:.6g}): the iteration is stable for |z| <= {:.3g} and here "
                          "|z| = {:.3g}; use a step below {:.3g}, fewer iterations or method.tolerance",
                          options_.iterations, dt, t, limit, rate * dt, limit / rate));
}

Attempt DeferredCorrection::fixed(double t, double dt, Field& u, Field& u_new, std::uint64_t& flags) {
  Attempt a;
  // The fastest mode of the diffusion is known exactly, and rounding alone excites it.
  const double diffusion_rate = rhs_->diffusion().spectral_radius();
  if (diffusion_rate * dt > stability_limit(options_.iterations)) refuse_step(t, dt, diffusion_rate);
  predict(t, dt, u, a);
  for (int k = 1; k <= options_.iterations; ++k) {
    evaluate_right_hand_sides(t, dt, a);
    correct(t, dt, u, a);
  }
  swap(u_new, v_.back());
  Agreement& agreement = agreement_;
  agreement.sums.clear();
  agreement.maxima.assign(1, 0.0);
  agreement.maxima[0] = rhs_->reaction().jacobian_bound(t, u, free_);
  agreement.flags = flags | inspect(u_new, free_);
  if (a.failure) agreement.flags |= step_flags::cell_failed;
  comm_->agree(agreement);
  flags = agreement.flags;
  a.accepted = !refuses(a, flags, u, u_new, free_, t, dt);
  a.dt_next = a.accepted ? options_.fixed_step : 0.5 * dt;
  const double rate = std::max(agreement.maxima[0], diffusion_rate);
  if (!a.accepted && rate * dt > stability_limit(options_.iterations)) refuse_step(t, dt, rate);
  return a;
}

int DeferredCorrection::allowed_iterations(double dt) const {
  int k = options_.max_iterations;
  while (k > 1 && rate_ * dt > stability_limit(k)) --k;
  return k;
}

/// The step after k corrections, before the safety factor: (47), (44), (46), or the best value for its cost.
double DeferredCorrection::proposed_step(int k, double dt, double error, double contraction, double zeta, double residual) const {
  const double eta = options_.tolerance;
  const double p = order_;
  const double e = std::max(error, round_off_floor);
  if (k == 0) return dt * std::pow(eta / e, 1.0 / (p + 1.0));
  const double convergent = residual >= round_off_floor ? 1.0 / zeta : std::numeric_limits<double>::infinity();
  const double bracket = eta / ((1.0 - contraction) * e + contraction * eta);
  const double all = options_.max_iterations;
  if (options_.exponent == DeferredCorrectionOptions::Exponent::published || options_.step_rule != DeferredCorrectionOptions::StepRule::k) {
    const bool published = options_.exponent == DeferredCorrectionOptions::Exponent::published;
    const double by_k = dt * std::pow(bracket, 1.0 / (published ? k : k + p + 1.0));
    const double by_kmax = std::pow(bracket, 1.0 / (published ? all : all + p + 1.0)) * std::pow(zeta * dt, -(all - k) / all) * dt;
    switch (options_.step_rule) {
      case DeferredCorrectionOptions::StepRule::k: return std::min(by_k, convergent);
      case DeferredCorrectionOptions::StepRule::kmax: return std::min(by_kmax, convergent);
      case DeferredCorrectionOptions::StepRule::min: return std::min({by_k, by_kmax, convergent});
    }
  }
  // The powers the errors really have: err_j ~ dt^(j + p + 1), and a further correction multiplies by zeta dt. Of one iteration
  // less, as many, and one more, the number that goes farthest for its splitting steps.
  double best = 0.0;
  double best_value = -1.0;
  const int most = hold_ > 0 ? k : std::min(k + 1, options_.max_iterations);
  for (int j = std::max(1, k - 1); j <= most; ++j) {
    double step = 0.0;
    if (j == k) {
      step = dt * std::pow(bracket, 1.0 / (k + p + 1.0));
    } else if (j < k) {
      step = dt * std::pow(eta / std::max(error_estimates_[static_cast<std::size_t>(j)], round_off_floor), 1.0 / (j + p + 1.0));
    } else {
      step = dt * std::pow(eta / std::max(e * zeta * dt, round_off_floor), 1.0 / (j + p + 1.0));
    }
    step = std::min({step, convergent, stability_limit(j) / rate_});
    const double splitting_steps = nodes_.size() + j * (nodes_.size() - 1);
    if (step / splitting_steps > best_value) {
      best_value = step / splitting_steps;
      best = step;
    }
  }
  return best;
}

Attempt DeferredCorrection::adaptive(double t, double dt, Field& u, Field& u_new, std::uint64_t& flags) {
  Attempt a;
  a.work = std::exchange(work_ahead_, Work{});
  const double eta = options_.tolerance;
  const int k_max = allowed_iterations(dt);
  error_estimates_.clear();
  step_limits_.clear();
  predict(t, dt, u, a);
  predicted_->copy_interior(v_.back());

  double first_residual = 0.0, last_residual = 0.0, zeta = 0.0;
  double dt_new = 0.5 * dt;
  for (int k = 0;; ++k) {
    evaluate_right_hand_sides(t, dt, a);
    quadrature_to_end(dt, u, u_new);
    Agreement& agreement = agreement_;
    norm_.prepare(2, agreement);
    agreement.maxima.push_back(k == 0 ? rhs_->reaction().jacobian_bound(t + dt, v_.back(), free_) : 0.0);
    norm_.add_difference(u_new, v_.back(), 0, agreement);
    norm_.add_difference(u_new, *predicted_, 1, agreement);
    norm_.add_scale(v_.back(), agreement);
    agreement.flags = flags | inspect(v_.back(), free_);
    if (a.failure) agreement.flags |= step_flags::cell_failed;
    comm_->agree(agreement);
    flags = agreement.flags;
    if (k == 0) rate_ = std::max(agreement.maxima.back(), rhs_->diffusion().spectral_radius());
    const double residual = norm_.value(0, agreement);   // e_k
    const double distance = norm_.value(1, agreement);   // |ubar^k - v_s^0|
    // An iterate may be negative where the result is not: it is the result that counts.
    if (refuses(a, flags & ~step_flags::refuse_negative, u, v_.back(), free_, t, dt) || !std::isfinite(residual) ||
        !std::isfinite(distance)) {
      if (a.reason.empty()) a.reason = "the iterates are not finite";
      dt_new = 0.5 * dt;
      break;
    }

    double error = residual;  // (43) for k = 0
    double contraction = 0.0; // r = sigma_k dt^k
    if (k == 0) {
      first_residual = residual;
    } else {
      const bool at_floor = residual < round_off_floor;
      zeta = residual / (last_residual * dt);
      step_limits_.push_back(1.0 / zeta);
      contraction = residual / first_residual;
      if (!at_floor && (zeta * dt >= 1.0 || contraction >= 1.0)) {
        a.reason = "the corrections do not converge";
        dt_new = 0.5 * std::min(dt, 1.0 / zeta);
        break;
      }
      error = at_floor ? residual : contraction / (1.0 - contraction) * distance;
    }
    last_residual = residual;
    a.error = error;
    error_estimates_.push_back(error);

    dt_new = options_.safety * proposed_step(k, dt, error, contraction, zeta, residual);

    // Without a correction nothing is known of the next one, and the step would stay that of the splitting alone.
    if (error <= eta && k >= 1) {
      a.accepted = !refuses(a, flags, u, v_.back(), free_, t, dt);
      if (!a.accepted) dt_new = 0.5 * dt;
      break;
    }
    if (k >= k_max) {
      a.reason = "the error estimate exceeds the tolerance after all iterations";
      break;
    }
    // Section 5.1: what the remaining iterations can still bring.
    if (options_.predict && k > 0) {
      const double expected = std::pow(zeta * dt, k_max - k) * error;
      if (expected > eta) {
        a.reason = "the remaining iterations are not expected to reach the tolerance";
        break;
      }
    }
    correct(t, dt, u, a);
  }

  // Residuals that are 0 or nearly overflow have no quotient to go by.
  if (std::isnan(dt_new)) dt_new = a.accepted ? dt : 0.5 * dt;
  a.dt_next = std::min(dt_new, options_.max_growth * dt);
  if (a.accepted) {
    swap(u_new, v_.back());
    if (hold_ > 0) --hold_;
  } else {
    hold_ = steps_held_after_rejection;
    a.dt_next = std::clamp(a.dt_next, 0.05 * dt, 0.9 * dt);
  }
  return a;
}

void DeferredCorrection::visit_state(StateVisitor& visitor) {
  visit_flows(visitor, *reaction_, *flows_.diffusion);
  visitor.numbers("scale_floors", norm_.floors());
  visitor.number("rate", rate_);
  visitor.integer("hold", hold_);
}

}  // namespace stiffront
