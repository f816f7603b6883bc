// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/adaptive_strang.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "stiffront/control/absent_species.hpp"
#include "stiffront/control/fixed_step.hpp"

namespace stiffront {
namespace {

// Two estimators of the Strang error, eq. (5.8): a step of length a_j is compared with steps of b_j and c_j, b_j + c_j = a_j.
// With a_2 = c_1 the two share a Strang step.
constexpr double a1 = 1.0, b1 = 0.5, c1 = 0.5;
constexpr double a2 = 0.5, b2 = 0.4, c2 = 0.1;
static_assert(a2 == c1 && b1 + c1 == a1);

constexpr double cube(double x) { return x * x * x; }

// Below this the difference of two states is round-off.
constexpr double round_off_floor = 1e-13;

}  // namespace

double default_final_error(double tolerance) { return std::max(3.0, 2.0 * std::cbrt(1e-6 / tolerance)); }

AdaptiveStrang::AdaptiveStrang(const Field& shape, const Boundary& boundary, const ReactionTerm& model, ReactionFlow& reaction,
                               Flow& diffusion, AdaptiveStrangOptions options)
    : comm_(&shape.comm()),
      model_(&model),
      free_(boundary.free_box(shape.decomposition())),
      flows_{&reaction, &diffusion},
      reaction_(&reaction),
      options_(std::move(options)),
      norm_(shape.decomposition(), boundary, model.n_species(), options_.species),
      strang_(strang(options_.order)),
      embedded_(shape.similar()),
      epsilon_(options_.epsilon) {
  if (options_.critical_step) two_steps_ = shape.similar();
  if (options_.critical_step && options_.final_error > 0.0) {
    companion_.emplace(reaction, diffusion, options_.order, shape, options_.final_error * options_.tolerance);
  }
}

double AdaptiveStrang::first_step(double t, double t_end, Field& u) {
  const double first = trial_step(t, t_end, u);
  norm_.set_floors(floors_of_absent_species(flows_, t, t_end, first, u, *comm_, work_ahead_));
  if (!companion_) return first;
  companion_->begin(t, t_end, u, first);
  return std::min(first, companion_->step_limit());
}

double AdaptiveStrang::trial_step(double t, double t_end, const Field& u) const {
  if (options_.initial_step > 0.0) return std::min(options_.initial_step, t_end - t);
  // The fastest time scale of the reaction: too small rather than too large, and growth makes up for it in a few steps.
  const double fastest = comm_->max(model_->jacobian_bound(t, u, free_));
  const double tenth = 0.1 * (t_end - t);
  const double first = fastest * tenth > 1.0 ? 1.0 / fastest : tenth;
  return companion_ ? first / CoarseCompanion::stride : first;
}

void AdaptiveStrang::note(std::optional<CellFailure> failure, Attempt& a) const {
  if (failure && !a.failure) a.failure = std::move(failure);
}

/// Step 1: A = S^{b2 dt} S^{c2 dt} u, B = S^{c1 dt} u, E2 = |B - A|, then B = S^{b1 dt} B for E1 = |v - B|.
void AdaptiveStrang::estimate_strang_error(double t, double dt, Field& u, Attempt& a, Agreement& agreement) {
  const Composition& s = strang_;
  Field& A = embedded_;  // not needed before step 2
  Field& B = *two_steps_;
  note(stiffront::advance(flows_, s, t, c2 * dt, u, A, a.work), a);
  note(stiffront::advance(flows_, s, t + c2 * dt, b2 * dt, A, A, a.work), a);
  note(stiffront::advance(flows_, s, t, c1 * dt, u, B, a.work), a);
  norm_.add_difference(B, A, half, agreement);
  note(stiffront::advance(flows_, s, t + c1 * dt, b1 * dt, B, B, a.work), a);
}

/// Step 2: v = S^{dt} u and w = S_epsilon^{dt} u with the first half step shared and the middle flow of both in one sweep.
void AdaptiveStrang::strang_and_embedded(double t, double dt, Field& u, Field& v, Attempt& a) {
  Flow& outer = flows_.of(strang_[0].process);
  Flow& inner = flows_.of(strang_[1].process);
  Field& w = embedded_;
  note(outer.advance(t, 0.5 * dt, u, v, a.work), a);
  note(outer.advance(t + 0.5 * dt, epsilon_ * dt, v, w, a.work), a);
  const Transition both[] = {{&v, &v}, {&w, &w}};
  note(inner.advance(t, dt, both, a.work), a);
  note(outer.advance(t + (0.5 + epsilon_) * dt, (0.5 - epsilon_) * dt, w, w, a.work), a);
  note(outer.advance(t + 0.5 * dt, 0.5 * dt, v, v, a.work), a);
}

/// Step 3: the constants of the two errors, the critical step dt* = zeta epsilon C_epsilon / C_0, and epsilon.
///
/// K is the Strang error over the whole step from eq. (5.10), which allows for a lost order by an unknown omega; where the two
/// equations contradict each other it is the step-doubling estimate E1 / (1 - 1/4) instead.
///
/// Differences that the inner solvers may have made tell nothing about the constants: divided by dt^3 they would give a C_0 that
/// grows as the step shrinks, a smaller critical step, a smaller step, and so on. They do tell that the Strang error is far below
/// the tolerance, so that the critical step is no reason yet not to grow. The next estimate is due when the step has doubled.
///
/// Unless both estimators see the same cubic error: that is no noise, however small it is. It may lower C_0 for the limit of the companion, which
/// would hold the step where a large C_0 of the past has put it, so that no later one could be measured.
void AdaptiveStrang::update_critical_step(double dt, double error_whole, double error_half, double& error) {
  const double floor = std::max(round_off_floor, options_.inner_tolerance);
  constexpr double whole_of_cubic = cube(a1) - cube(b1) - cube(c1), half_of_cubic = cube(a2) - cube(b2) - cube(c2);
  const double doubled = error_whole / whole_of_cubic;
  if (!(error_whole > floor && error > floor)) {
    const double ratio = error_half / half_of_cubic / doubled;
    if (error_whole > 10.0 * round_off_floor && ratio > 0.5 && ratio < 2.0) c0_ = std::min(c0_, doubled / cube(dt));
    refused_dt_ = dt;
    critical_dt_ = std::max(critical_dt_, options_.max_growth * dt);
    return;
  }
  refused_dt_ = 0.0;
  const double alpha1 = cube(a1) - cube(b1), gamma1 = cube(c1);
  const double alpha2 = cube(a2) - cube(b2), gamma2 = cube(c2);
  double strang_error = (gamma1 * error_half - gamma2 * error_whole) / (alpha2 * gamma1 - alpha1 * gamma2);
  if (!(strang_error >= 0.2 * doubled && strang_error <= 5.0 * doubled)) strang_error = doubled;
  c0_ = strang_error / cube(dt);
  c_epsilon_ = error / (epsilon_ * dt * dt);
  critical_dt_ = options_.critical_safety * epsilon_ * c_epsilon_ / c0_;
  if (accepted_ > 0 && (dt < options_.beta * critical_dt_ || dt > options_.gamma * critical_dt_)) {
    const double epsilon = std::min(options_.theta * c0_ * dt / c_epsilon_, options_.epsilon_max);
    error *= epsilon / epsilon_;  // the distance to the embedded scheme is proportional to epsilon
    epsilon_ = epsilon;
    critical_dt_ = options_.critical_safety * epsilon_ * c_epsilon_ / c0_;
  }
}

Attempt AdaptiveStrang::attempt(double t, double dt, Field& u, Field& u_new, std::uint64_t& flags) {
  Attempt a;
  a.work = std::exchange(work_ahead_, Work{});
  const bool due = (accepted_ % options_.period == 0 && estimated_at_ != accepted_) || (refused_dt_ > 0.0 && dt >= 2.0 * refused_dt_);
  const bool estimates = options_.critical_step && (estimate_asked_ || due);
  Agreement& agreement = agreement_;
  norm_.prepare(estimates ? 4 : 2, agreement);
  attempted_dt_ = dt;

  const bool catches_up = companion_ && companion_->due();
  bool companion_is_well = true;
  if (catches_up) {
    companion_is_well = companion_->catch_up(t, a.work);
    norm_.add_difference(u, companion_->state(), companion, agreement);
  }

  // Step 1.
  if (estimates) estimate_strang_error(t, dt, u, a, agreement);

  // Step 2.
  strang_and_embedded(t, dt, u, u_new, a);
  norm_.add_difference(u_new, embedded_, embedded, agreement);
  if (estimates) norm_.add_difference(u_new, *two_steps_, whole, agreement);
  norm_.add_scale(u_new, agreement);
  agreement.flags = flags | inspect(u_new, free_);
  if (a.failure) agreement.flags |= step_flags::cell_failed;
  if (!companion_is_well) agreement.flags |= step_flags::companion_failed;
  comm_->agree(agreement);
  flags = agreement.flags & ~step_flags::companion_failed;
  if (catches_up) companion_->learn(norm_.value(companion, agreement), flags == agreement.flags, c0_);
  double error = norm_.value(embedded, agreement);
  if (refuses(a, flags, u, u_new, free_, t, dt) || !std::isfinite(error)) {
    if (a.reason.empty()) a.reason = "the error estimate is not finite";
    a.error = error;
    a.dt_next = 0.5 * dt;
    a.epsilon = epsilon_;
    return a;
  }

  // Step 3.
  bool begins_too_far = false;
  if (estimates) {
    update_critical_step(dt, norm_.value(whole, agreement), norm_.value(half, agreement), error);
    estimated_at_ = accepted_;
    estimate_asked_ = false;
    begins_too_far = companion_ && !(options_.initial_step > 0.0) && companion_->expect(c0_, dt);
  }

  // Step 4: the new step from eq. (2.11), and whether the critical step has to be known better.
  const double factor = error > 0.0 ? options_.safety * std::sqrt(options_.tolerance / error) : options_.max_growth;
  const double dt_new = dt * std::clamp(factor, 0.05, options_.max_growth);
  if (options_.critical_step && dt_new > critical_dt_ && epsilon_ < options_.epsilon_max) estimate_asked_ = true;

  // Step 5.
  a.accepted = error <= options_.tolerance && !(dt > critical_dt_) && !begins_too_far;
  a.error = error;
  a.dt_next = options_.critical_step ? std::min(dt_new, critical_dt_) : dt_new;
  if (companion_) a.dt_next = std::min(a.dt_next, companion_->step_limit());
  a.epsilon = epsilon_;
  a.critical_dt = options_.critical_step ? critical_dt_ : 0.0;
  if (!a.accepted) {
    a.reason = error > options_.tolerance ? "the error estimate exceeds the tolerance"
               : dt > critical_dt_        ? "the step exceeds the critical splitting step"
                                          : "steps like the first would spend what the error at the end may be";
    a.dt_next = std::min(a.dt_next, 0.95 * dt);
  }
  return a;
}

void AdaptiveStrang::accept(Field& u, Field& u_new) {
  swap(u, u_new);
  ++accepted_;
  if (companion_) companion_->accepted(attempted_dt_);
}

void AdaptiveStrang::restart(double) {
  epsilon_ = options_.epsilon;
  critical_dt_ = std::numeric_limits<double>::infinity();
  c0_ = c_epsilon_ = 0.0;
  accepted_ = 0;
  estimated_at_ = -1;
  estimate_asked_ = false;
  refused_dt_ = 0.0;
  if (companion_) companion_->land();
}

std::optional<double> AdaptiveStrang::final_error(double t, Field& u, Work& work) {
  if (!companion_) return std::nullopt;
  if (companion_->behind()) {
    const bool well = companion_->catch_up(t, work);
    norm_.prepare(2, agreement_);
    norm_.add_difference(u, companion_->state(), companion, agreement_);
    norm_.add_scale(u, agreement_);
    agreement_.flags = well ? 0 : step_flags::companion_failed;
    comm_->agree(agreement_);
    companion_->learn(norm_.value(companion, agreement_), agreement_.flags == 0, c0_);
  }
  if (companion_->given_up()) return std::nullopt;
  return companion_->error();
}

std::string AdaptiveStrang::closing_note() const {
  if (companion_ && companion_->given_up())
    return "the error at the end is not known: a second solution with larger steps could not be followed";
  return {};
}

void AdaptiveStrang::visit_state(StateVisitor& visitor) {
  visit_flows(visitor, *reaction_, *flows_.diffusion);
  visitor.numbers("scale_floors", norm_.floors());
  visitor.number("epsilon", epsilon_);
  visitor.number("critical_dt", critical_dt_);
  visitor.number("c0", c0_);
  visitor.number("c_epsilon", c_epsilon_);
  visitor.integer("accepted", accepted_);
  visitor.integer("estimated_at", estimated_at_);
  visitor.integer("estimate_asked", estimate_asked_);
  visitor.number("refused_dt", refused_dt_);
  if (companion_) companion_->visit_state(visitor);
}

}  // namespace stiffront
