// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/spectral_deferred_correction.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "stiffront/control/lagrange.hpp"
#include "stiffront/control/starting_weights.hpp"
#include "stiffront/core/error.hpp"

namespace stiffront {
namespace {

using Options = SpectralDeferredCorrectionOptions;

// Below this, in the relative norm, a residual is round-off.
constexpr double round_off_floor = 1e-15;

[[noreturn]] void refuse_alternative() {
  throw Error(
      ErrorKind::input,
      "method.correction: the alternative form converges to the collocation solution only where the starting method is the "
      "correction method; it needs starting_order = 1, consistent = true, a fixed step, no acceleration and no composition of flows");
}

Options checked(Options o) {
  const auto refuse = [](const std::string& message) { throw Error(ErrorKind::input, message); };
  if (o.node_count < 2 || o.node_count > 10) refuse(fmt::format("method.node_count: expected 2 to 10, got {}", o.node_count));
  // The stages of a step and its beginning, which the first stage of Lobatto and the last one of Radau is already.
  const int most = o.nodes == NodeFamily::gauss_lobatto ? o.node_count - 1 : o.node_count;
  if (o.starting_order < 1 || o.starting_order > most) {
    refuse(fmt::format("method.starting_order: expected 1 to {} with {} nodes, got {}", most, o.node_count, o.starting_order));
  }
  if (o.corrections < 0) refuse(fmt::format("method.corrections: expected a number not below 0, got {}", o.corrections));
  if (!(o.fixed_step > 0.0) && !(o.tolerance > 0.0)) refuse("method: missing: step, or tolerance for adaptive steps");
  if (!(o.fixed_step > 0.0) && o.corrections < 1) refuse("method.corrections: adaptive steps need one correction at least");
  if (o.final_update == Options::FinalUpdate::last_node && o.nodes == NodeFamily::gauss_legendre) {
    refuse("method.final_update: the last of the Legendre nodes is not the end of the step; use \"quadrature\" or \"extrapolation\"");
  }
  if (o.correction == Options::Correction::alternative &&
      (o.starting_order != 1 || !o.consistent || o.accelerate || !(o.fixed_step > 0.0))) {
    refuse_alternative();
  }
  return o;
}

}  // namespace

SpectralDeferredCorrection::SpectralDeferredCorrection(const Field& shape, RightHandSide& rhs, ImplicitPart& implicit,
                                                       const ReactionTerm* reaction, Options options)
    : SpectralDeferredCorrection(shape, rhs, &implicit, nullptr, reaction, options) {}

SpectralDeferredCorrection::SpectralDeferredCorrection(const Field& shape, RightHandSide& rhs, StepPropagator& propagator,
                                                       const ReactionTerm* reaction, Options options)
    : SpectralDeferredCorrection(shape, rhs, nullptr, &propagator, reaction, options) {}

SpectralDeferredCorrection::SpectralDeferredCorrection(const Field& shape, RightHandSide& rhs, ImplicitPart* implicit,
                                                       StepPropagator* propagator, const ReactionTerm* reaction, Options options)
    : comm_(&shape.comm()),
      rhs_(&rhs),
      implicit_(implicit),
      propagator_(propagator),
      reaction_(reaction),
      options_(checked(options)),
      nodes_(collocation_nodes(options_.nodes, options_.node_count)),
      norm_(shape.decomposition(), rhs.boundary(), shape.n_species(), {}),
      free_(rhs.boundary().free_box(shape.decomposition())),
      f0_(shape.similar()),
      work_(shape.similar()),
      delta_(shape.similar()) {
  if (options_.final_update == Options::FinalUpdate::automatic) {
    options_.final_update = nodes_.ends_at_one() ? Options::FinalUpdate::last_node : Options::FinalUpdate::quadrature;
  }
  if (options_.final_update == Options::FinalUpdate::extrapolation) {
    if (nodes_.ends_at_one()) {
      options_.final_update = Options::FinalUpdate::last_node;
    } else {
      std::vector<double> beginning_and_nodes{0.0};
      beginning_and_nodes.insert(beginning_and_nodes.end(), nodes_.c.begin(), nodes_.c.end());
      end_weights_ = lagrange(beginning_and_nodes, 1.0);
    }
  }
  for (std::size_t i = 0; i < count(); ++i) {
    v_.push_back(shape.similar());
    f_.push_back(shape.similar());
    rho_.push_back(shape.similar());
    if (options_.correction == Options::Correction::alternative) provisional_.push_back(shape.similar());
    if (options_.accelerate) before_.push_back(shape.similar());
  }
  if (propagator_ != nullptr) {
    if (options_.correction == Options::Correction::alternative) refuse_alternative();
    for (std::size_t i = 0; i < count(); ++i) propagated_.push_back(shape.similar());
  }
  for (int i = 1; i < options_.starting_order && propagator_ == nullptr; ++i) {
    history_v_.push_back(shape.similar());
    history_f_.push_back(shape.similar());
  }
  if (options_.accelerate) {
    acceleration_.emplace(shape, free_, count(), static_cast<std::size_t>(options_.corrections + options_.starting_order));
  }
}

double SpectralDeferredCorrection::first_step(double t, double t_end, Field& u) {
  if (options_.fixed_step > 0.0) return options_.fixed_step;
  if (options_.initial_step > 0.0) return std::min(options_.initial_step, t_end - t);
  const double tenth = 0.1 * (t_end - t);
  const double rate = reaction_ == nullptr ? 0.0 : comm_->max(reaction_->jacobian_bound(t, u, free_));
  return rate * tenth > 1.0 ? 1.0 / rate : tenth;
}

void SpectralDeferredCorrection::evaluate(double t, Field& u, Field& f, Attempt& a) {
  rhs_->evaluate(t, u, f);
  ++evaluations_;
  ++a.work.rhs_evaluations;
  ++a.work.halo_exchanges;
}

void SpectralDeferredCorrection::ensure_slope(double t, Field& u, Attempt& a) {
  if (!has_slope_) evaluate(t, u, f0_, a);
  has_slope_ = true;
}

/// Dirichlet points are no unknowns.
void SpectralDeferredCorrection::zero_fixed_points(Field& f) const {
  if (!rhs_->boundary().has_dirichlet()) return;
  for (int s = 0; s < f.n_species(); ++s) {
    for (int j = 0; j < f.n_y(); ++j) {
      double* row = f.row(s, j);
      const bool whole_row = j < free_.j_begin || j >= free_.j_end;
      std::fill(row, row + (whole_row ? f.n_x() : free_.i_begin), 0.0);
      std::fill(row + (whole_row ? f.n_x() : free_.i_end), row + f.n_x(), 0.0);
    }
  }
}

/// (2-4) for node i, from the nodes before it, the beginning of the step and the stages of the step before.
void SpectralDeferredCorrection::start_node(std::size_t i, double t, double dt, Field& u, Attempt& a) {
  const auto order = static_cast<std::size_t>(options_.starting_order);
  std::vector<double> times;
  std::vector<const Field*> states;
  std::vector<const Field*> slopes;
  const auto add = [&](double time, const Field& v, const Field& f) {
    if (times.size() == order) return;
    times.push_back(time);
    states.push_back(&v);
    slopes.push_back(&f);
  };
  for (std::size_t k = i; k-- > first_moving();) add(node(k) * dt, v_[k], f_[k]);
  add(0.0, u, f0_);
  for (std::size_t k = 0; k < history_times_.size(); ++k) add(history_times_[k], history_v_[k], history_f_[k]);

  const double target = node(i) * dt;
  const StartingWeights w = starting_weights(target, times);
  std::vector<Term> guess;
  std::vector<Term> right;
  for (std::size_t k = 0; k < times.size(); ++k) {
    guess.push_back({w.extrapolation[k], states[k]});
    if (w.states[k] != 0.0) right.push_back({w.states[k], states[k]});
    right.push_back({w.h * w.extrapolation[k], slopes[k]});
  }
  combine(guess, work_);
  combine(right, delta_);
  const Boundary& boundary = rhs_->boundary();
  if (boundary.has_dirichlet()) {
    // There the change is known.
    zero_fixed_points(delta_);
    v_[i].copy_interior(work_);
    boundary.impose(v_[i], t + target);
    for (int s = 0; s < u.n_species(); ++s) {
      for (int j = 0; j < u.n_y(); ++j) {
        const double* extrapolated = work_.row(s, j);
        const double* imposed = v_[i].row(s, j);
        double* change = delta_.row(s, j);
        for (int x = 0; x < u.n_x(); ++x) change[x] += imposed[x] - extrapolated[x];  // zero at all other points
      }
    }
  }
  implicit_->solve(t + target, w.h, *states[0], delta_, a.work);
  const std::array<Term, 2> sum{Term{1.0, &work_}, Term{1.0, &delta_}};
  combine(sum, v_[i]);
  boundary.impose(v_[i], t + target);
  evaluate(t + target, v_[i], f_[i], a);
}

void SpectralDeferredCorrection::start(double t, double dt, Field& u, Attempt& a) {
  ensure_slope(t, u, a);
  if (nodes_.starts_at_zero()) {
    v_[0].copy_interior(u);
    f_[0].copy_interior(f0_);
  }
  if (propagator_ != nullptr) return start_by_propagation(t, dt, u, a);
  for (std::size_t i = first_moving(); i < count(); ++i) start_node(i, t, dt, u, a);
}

/// propagated_[i] = S^h of the left neighbour of node i.
void SpectralDeferredCorrection::propagate(std::size_t i, double t, double dt, Field& u, Attempt& a) {
  const double h = nodes_.interval(static_cast<int>(i)) * dt;
  propagator_->advance(t + node(i) * dt - h, h, i == 0 ? u : v_[i - 1], propagated_[i], a);
}

void SpectralDeferredCorrection::start_by_propagation(double t, double dt, Field& u, Attempt& a) {
  for (std::size_t i = first_moving(); i < count(); ++i) {
    propagate(i, t, dt, u, a);
    v_[i].copy_interior(propagated_[i]);
    rhs_->boundary().impose(v_[i], t + node(i) * dt);
    evaluate(t + node(i) * dt, v_[i], f_[i], a);
  }
}

/// A sweep with the propagator from the residual increments: v_i^new = S v_{i-1}^new - S v_{i-1} + v_i + rho_i.
void SpectralDeferredCorrection::propagated_sweep(double t, double dt, Field& u, Attempt& a) {
  for (std::size_t i = first_moving(); i < count(); ++i) {
    // The first node's left neighbour is the same in all sweeps.
    if (i > first_moving()) {
      const std::array<Term, 2> without{Term{1.0, &rho_[i]}, Term{-1.0, &propagated_[i]}};
      combine(without, rho_[i]);
      propagate(i, t, dt, u, a);
      const std::array<Term, 2> with{Term{1.0, &rho_[i]}, Term{1.0, &propagated_[i]}};
      combine(with, rho_[i]);
    }
    const std::array<Term, 2> next{Term{1.0, &v_[i]}, Term{1.0, &rho_[i]}};
    combine(next, v_[i]);
    rhs_->boundary().impose(v_[i], t + node(i) * dt);
    evaluate(t + node(i) * dt, v_[i], f_[i], a);
  }
  ++a.iterations;
}

/// rho_i = dT sum_a (S_i - S_{i-1})_a F(v_a) - (v_i - v_{i-1}): what the residual (2-10) grows by from node to node.
void SpectralDeferredCorrection::residual_increments(double dt, const Field& u) {
  for (std::size_t i = first_moving(); i < count(); ++i) {
    std::vector<Term> terms{{1.0, i == 0 ? &u : &v_[i - 1]}, {-1.0, &v_[i]}};
    for (std::size_t k = 0; k < count(); ++k) terms.push_back({dt * nodes_.between(static_cast<int>(i), static_cast<int>(k)), &f_[k]});
    combine(terms, rho_[i]);
    zero_fixed_points(rho_[i]);
  }
}

/// (2-12)-(2-14) from the residual increments. @param last whether the right-hand sides of the new iterate are of no use
void SpectralDeferredCorrection::sweep(double t, double dt, Field& u, bool last, Attempt& a) {
  if (propagator_ != nullptr) return propagated_sweep(t, dt, u, a);
  for (std::size_t i = first_moving(); i < count(); ++i) {
    const double h = nodes_.interval(static_cast<int>(i)) * dt;
    const bool follows = i > first_moving();
    const Field& left = i == 0 ? u : v_[i - 1];
    // work_ holds the change of the left node's right-hand side, delta_ that of its state.
    if (follows && options_.consistent) {
      const std::array<Term, 2> terms{Term{1.0, &rho_[i]}, Term{h, &work_}};
      combine(terms, rho_[i]);
    } else if (follows) {
      const std::array<Term, 2> terms{Term{1.0, &rho_[i]}, Term{1.0, &delta_}};
      combine(terms, rho_[i]);
    }
    implicit_->solve(t + node(i) * dt, h, left, rho_[i], a.work);
    if (follows && options_.consistent) {
      const std::array<Term, 2> terms{Term{1.0, &delta_}, Term{1.0, &rho_[i]}};
      combine(terms, delta_);
    } else {
      delta_.copy_interior(rho_[i]);
    }
    const std::array<Term, 2> terms{Term{1.0, &v_[i]}, Term{1.0, &delta_}};
    combine(terms, v_[i]);
    const bool at_end = i + 1 == count();
    if (last && (at_end || !options_.consistent)) continue;
    if (options_.consistent && !at_end) work_.copy_interior(f_[i]);
    evaluate(t + node(i) * dt, v_[i], f_[i], a);
    if (options_.consistent && !at_end) {
      const std::array<Term, 2> change{Term{1.0, &f_[i]}, Term{-1.0, &work_}};
      combine(change, work_);
    }
  }
  ++a.iterations;
}

/// (2-16)-(2-18), with delta_ and work_ for the barred value at the left node and its right-hand side.
void SpectralDeferredCorrection::alternative_sweep(double t, double dt, Field& u, Attempt& a) {
  delta_.copy_interior(u);
  work_.copy_interior(f0_);
  for (std::size_t i = first_moving(); i < count(); ++i) {
    const double h = nodes_.interval(static_cast<int>(i)) * dt;
    const std::array<Term, 2> right{Term{h, &work_}, Term{-1.0, &rho_[i]}};
    combine(right, rho_[i]);
    zero_fixed_points(rho_[i]);
    implicit_->solve(t + node(i) * dt, h, delta_, rho_[i], a.work);
    const std::array<Term, 2> barred{Term{1.0, &delta_}, Term{1.0, &rho_[i]}};
    combine(barred, delta_);
    rhs_->boundary().impose(delta_, t + node(i) * dt);
    const std::array<Term, 3> next{Term{1.0, &provisional_[i]}, Term{1.0, &v_[i]}, Term{-1.0, &delta_}};
    combine(next, v_[i]);
    rhs_->boundary().impose(v_[i], t + node(i) * dt);
    if (i + 1 < count()) evaluate(t + node(i) * dt, delta_, work_, a);
  }
  for (std::size_t i = first_moving(); i < count(); ++i) evaluate(t + node(i) * dt, v_[i], f_[i], a);
  ++a.iterations;
}

void SpectralDeferredCorrection::accelerated_sweep(double t, double dt, Field& u, Attempt& a) {
  for (std::size_t i = 0; i < count(); ++i) before_[i].copy_interior(v_[i]);
  sweep(t, dt, u, true, a);
  for (std::size_t i = 0; i < count(); ++i) {
    const std::array<Term, 2> change{Term{1.0, &v_[i]}, Term{-1.0, &before_[i]}};
    combine(change, rho_[i]);
    swap(v_[i], before_[i]);
  }
  acceleration_->next(v_, rho_);
  for (std::size_t i = first_moving(); i < count(); ++i) evaluate(t + node(i) * dt, v_[i], f_[i], a);
}

/// result = u + dT sum weights_a F(v_a).
void SpectralDeferredCorrection::integrate(const std::vector<double>& weights, double dt, const Field& u, Field& result) const {
  std::vector<Term> terms{{1.0, &u}};
  for (std::size_t k = 0; k < count(); ++k) terms.push_back({dt * weights[k], &f_[k]});
  combine(terms, result);
}

void SpectralDeferredCorrection::finish(double t, double dt, const Field& u, Field& u_new) {
  switch (options_.final_update) {
    case Options::FinalUpdate::automatic:
    case Options::FinalUpdate::last_node:
      u_new.copy_interior(v_.back());
      break;
    case Options::FinalUpdate::quadrature:
      integrate(nodes_.w, dt, u, u_new);
      break;
    case Options::FinalUpdate::extrapolation: {
      std::vector<Term> terms{{end_weights_[0], &u}};
      for (std::size_t k = 0; k < count(); ++k) terms.push_back({end_weights_[k + 1], &v_[k]});
      combine(terms, u_new);
      break;
    }
  }
  rhs_->boundary().impose(u_new, t + dt);
  has_end_slope_ = options_.final_update == Options::FinalUpdate::last_node;
}

Attempt SpectralDeferredCorrection::attempt(double t, double dt, Field& u, Field& u_new, std::uint64_t& flags) {
  attempted_dt_ = dt;
  return options_.fixed_step > 0.0 ? fixed(t, dt, u, u_new, flags) : adaptive(t, dt, u, u_new, flags);
}

Attempt SpectralDeferredCorrection::fixed(double t, double dt, Field& u, Field& u_new, std::uint64_t& flags) {
  Attempt a;
  const bool has_history = propagator_ != nullptr || history_times_.size() + 1 >= static_cast<std::size_t>(options_.starting_order);
  const int sweeps = options_.corrections + (has_history || options_.corrections == 0 ? 0 : options_.starting_order - 1);
  start(t, dt, u, a);
  for (std::size_t i = 0; i < provisional_.size(); ++i) provisional_[i].copy_interior(v_[i]);
  if (acceleration_) {
    Agreement scales = norm_.agreement(0);
    norm_.add_scale(u, scales);
    comm_->agree(scales);
    acceleration_->reset(scales.maxima);
  }
  for (int l = 0; l < sweeps; ++l) {
    residual_increments(dt, u);
    if (options_.correction == Options::Correction::alternative) {
      alternative_sweep(t, dt, u, a);
    } else if (acceleration_) {
      accelerated_sweep(t, dt, u, a);
    } else {
      sweep(t, dt, u, false, a);
    }
  }
  finish(t, dt, u, u_new);
  Agreement agreement(0, 0);
  agreement.flags = flags | inspect(u_new, free_) | (a.failure ? step_flags::cell_failed : 0);
  comm_->agree(agreement);
  flags = agreement.flags;
  if ((flags & step_flags::cell_failed) != 0) {
    a.reason = "a cell could not be integrated";
    a.dt_next = 0.5 * dt;
    return a;
  }
  if ((flags & step_flags::not_finite) != 0) {
    throw Error(
        ErrorKind::numerics,
        fmt::format("method.step: the solution is not finite after the step of {:.6g} from t = {:.6g}: this step is not stable; use "
                    "a smaller one, a smaller method.starting_order, a larger method.gamma_diffusion, or method.tolerance",
                    dt, t));
  }
  a.accepted = true;
  a.dt_next = options_.fixed_step;
  return a;
}

/// The step for the number of sweeps that goes farthest for its cost, from the residuals before each sweep and after the last.
double SpectralDeferredCorrection::proposed_step(double dt, const std::vector<double>& residuals) const {
  const std::size_t done = residuals.size() - 1;
  const double last = std::max(residuals.back(), round_off_floor);
  const double contraction = done == 0 ? 0.1 : std::clamp(last / std::max(residuals[done - 1], round_off_floor), 1e-3, 1.0);
  double best = 0.0;
  double best_value = 0.0;
  double expected = last;
  for (int l = 1; l <= options_.corrections; ++l) {
    const auto k = static_cast<std::size_t>(l);
    if (k > done) expected = std::max(expected * contraction, round_off_floor);
    const double residual = k <= done ? std::max(residuals[k], round_off_floor) : expected;
    // The residual after l sweeps behaves like dT^(k + l + 1).
    const double step = dt * std::pow(options_.tolerance / residual, 1.0 / (options_.starting_order + l + 1.0));
    const double value = step / (1.0 + l);
    if (value > best_value) {
      best_value = value;
      best = step;
    }
  }
  return options_.safety * best;
}

Attempt SpectralDeferredCorrection::adaptive(double t, double dt, Field& u, Field& u_new, std::uint64_t& flags) {
  Attempt a;
  const std::vector<double>& to_last_node = nodes_.s.back();
  start(t, dt, u, a);
  std::vector<double> residuals;
  for (int l = 0;; ++l) {
    integrate(to_last_node, dt, u, u_new);
    rhs_->boundary().impose(u_new, t + node(count() - 1) * dt);
    Agreement agreement = norm_.agreement(1);
    norm_.add_difference(u_new, v_.back(), 0, agreement);
    norm_.add_scale(v_.back(), agreement);
    agreement.flags = flags | inspect(v_.back(), free_) | (a.failure ? step_flags::cell_failed : 0);
    comm_->agree(agreement);
    flags = agreement.flags;
    const double residual = norm_.value(0, agreement);
    a.error = residual;
    if ((flags & step_flags::cell_failed) != 0) {
      a.reason = "a cell could not be integrated";
      a.dt_next = 0.25 * dt;
      return a;
    }
    if ((flags & step_flags::not_finite) != 0 || !std::isfinite(residual)) {
      a.reason = "the iterates are not finite";
      a.dt_next = 0.25 * dt;
      return a;
    }
    residuals.push_back(residual);
    // Without a correction nothing is known of the next one.
    if (residual <= options_.tolerance && l >= 1) {
      a.accepted = true;
      break;
    }
    if (l >= 2 && residual > residuals[residuals.size() - 2] && residual > round_off_floor) {
      a.reason = "the corrections do not converge";
      a.dt_next = 0.5 * dt;
      return a;
    }
    if (l >= options_.corrections) {
      a.reason = "the residual exceeds the tolerance after all corrections";
      break;
    }
    if (acceleration_) {
      if (l == 0) acceleration_->reset(agreement.maxima);
      residual_increments(dt, u);
      accelerated_sweep(t, dt, u, a);
    } else {
      residual_increments(dt, u);
      sweep(t, dt, u, false, a);
    }
  }
  a.dt_next = proposed_step(dt, residuals);
  if (a.accepted) {
    finish(t, dt, u, u_new);
    a.dt_next = std::min(a.dt_next, options_.max_growth * dt);
  } else {
    a.dt_next = std::clamp(a.dt_next, 0.1 * dt, 0.8 * dt);
  }
  return a;
}

void SpectralDeferredCorrection::accept(Field& u, Field& u_new) {
  swap(u, u_new);
  // The stages become history, from the end backwards; the end itself is the new state.
  history_times_.clear();
  std::size_t next = count();
  if (nodes_.ends_at_one()) --next;
  for (std::size_t k = 0; k < history_v_.size() && next > first_moving(); ++k) {
    --next;
    swap(history_v_[k], v_[next]);
    swap(history_f_[k], f_[next]);
    history_times_.push_back((node(next) - 1.0) * attempted_dt_);
  }
  if (has_end_slope_) swap(f0_, f_.back());
  has_slope_ = has_end_slope_;
}

void SpectralDeferredCorrection::restart(double t) {
  static_cast<void>(t);
  history_times_.clear();
  has_slope_ = false;
}

void SpectralDeferredCorrection::visit_state(StateVisitor& visitor) {
  if (propagator_ != nullptr) propagator_->visit_state(visitor);
  visitor.numbers("history_times", history_times_);
  visitor.integer("has_slope", has_slope_);
  if (has_slope_) visitor.field("slope", f0_);
  for (std::size_t k = 0; k < history_times_.size(); ++k) {
    visitor.field(fmt::format("history-state-{}", k + 1), history_v_[k]);
    visitor.field(fmt::format("history-slope-{}", k + 1), history_f_[k]);
  }
}

}  // namespace stiffront
