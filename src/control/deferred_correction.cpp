// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/deferred_correction.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <span>
#include <utility>

#include "stiffront/control/absent_species.hpp"
#include "stiffront/control/deferred_correction_stability.hpp"
#include "stiffront/control/fixed_step.hpp"
#include "stiffront/core/error.hpp"
#include "stiffront/mesh/field_algebra.hpp"
#include "stiffront/model/reaction_modes.hpp"

namespace stiffront {
namespace {

// A correction of a fixed step that is not smaller than the first one shows divergence once it is so large, relative to the prediction.
constexpr double visible_divergence = 1e-3;

// A correction that changes the prediction by as much as this corrects nothing.
constexpr double worthless_correction = 0.5;

// Modes that oscillate leave the stable region before the ones that decay, but none at so small a |z|.
constexpr double stable_everywhere = 2.0;

/// Weights w with sum_j w_j f(c_j) = the coefficient of the Legendre polynomial of the given degree in the interpolant of f.
std::vector<double> legendre_coefficient(const CollocationNodes& nodes, int degree) {
  // The Radau rule integrates polynomials of degree 2 s - 2, the products of two of degree s - 1, without error.
  std::vector<double> weights;
  for (int j = 0; j < nodes.size(); ++j) {
    const auto k = static_cast<std::size_t>(j);
    weights.push_back((2.0 * degree + 1.0) * nodes.w[k] * std::legendre(static_cast<unsigned>(degree), 2.0 * nodes.c[k] - 1.0));
  }
  return weights;
}

double factorial(int n) { return std::tgamma(n + 1.0); }

/// What dt a_{s-1} (a_{s-1}/a_{s-2})^s is to be multiplied with for the error of Radau IIA, a_n the Legendre coefficients of F over the step:
/// exact for exponentials, where a_n = z^n n!/(2n)! and the error is z^(2s) s! (s-1)!/((2s-1)! (2s)!) to leading order.
double error_constant(int stages) {
  const double error = factorial(stages) * factorial(stages - 1) / (factorial(2 * stages - 1) * factorial(2 * stages));
  const double last = factorial(stages - 1) / factorial(2 * stages - 2);
  const double decay = 1.0 / (2.0 * (2.0 * stages - 3.0));
  return error / (last * std::pow(decay, stages));
}

}  // namespace

DeferredCorrection::DeferredCorrection(const Field& shape, CoupledRhs& rhs, ReactionFlow& reaction, Flow& diffusion,
                                       DeferredCorrectionOptions options)
    : comm_(&shape.comm()),
      rhs_(&rhs),
      reaction_(&reaction),
      flows_{&reaction, &diffusion},
      options_(std::move(options)),
      nodes_(collocation_nodes(NodeFamily::gauss_radau, options_.stages)),
      stability_limits_(deferred_correction_stability_limits(nodes_, std::max(options_.max_iterations, options_.iterations))),
      composition_(options_.strang ? strang(SplittingOrder::reaction_last) : lie(SplittingOrder::reaction_last)),
      norm_(shape.decomposition(), rhs.diffusion().boundary(), shape.n_species(), options_.species),
      control_(options_, stability_limits_),
      free_(rhs.free_box()),
      inner_steps_(static_cast<std::size_t>(nodes_.size())),
      diffusion_at_first_(diffusion.state()),
      quadrature_constant_(error_constant(nodes_.size())),
      last_(shape.similar()) {
  for (int i = 0; i < nodes_.size(); ++i) {
    v_.push_back(shape.similar());
    f_.push_back(shape.similar());
    s_.push_back(shape.similar());
  }
  for (int degree = nodes_.size() - 1; degree >= std::max(0, nodes_.size() - 3); --degree)
    modes_.push_back(legendre_coefficient(nodes_, degree));
}

double DeferredCorrection::first_step(double t, double t_end, Field& u) {
  rate_ = comm_->max(rhs_->reaction().jacobian_bound(t, u, free_));
  if (options_.fixed_step > 0.0) return options_.fixed_step;
  const double rate = rate_ + rhs_->diffusion().spectral_radius();
  const double tenth = 0.1 * (t_end - t);
  double first = rate * tenth > 1.0 ? 1.0 / rate : tenth;
  if (options_.initial_step > 0.0) first = std::min(options_.initial_step, t_end - t);
  norm_.set_floors(floors_of_absent_species(flows_, t, t_end, first, u, *comm_, work_ahead_));
  return first;
}

void DeferredCorrection::split(double t, double dt, Field& from, Field& to, Attempt& a) {
  flows_.diffusion->set_state(diffusion_at_first_);
  auto failure = stiffront::advance(flows_, composition_, t, dt, from, to, a.work);
  if (failure && !a.failure) a.failure = std::move(failure);
}

/// (15): v_i = S^{dt_i} v_{i-1}. The results are the "old" S v_{i-1} of the first correction.
void DeferredCorrection::predict(double t, double dt, Field& u, Attempt& a) {
  for (int i = 0; i < nodes_.size(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    inner_steps_[k] = reaction_->hints();
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
    // Every iteration begins with the same inner steps. Where their number changed from one to the next, S v^new - S v^old would hold
    // the tolerance of the inner solvers, and that is where the iteration would come to a halt.
    reaction_->hints() = inner_steps_[k];
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
  throw Error(
      ErrorKind::numerics,
      fmt::format(
          "method.step: {} corrections with the step {:.6g} diverge (t = {:.6g}): their limit of stability is |z| = {:.1f}, and here "
          "|z| = {:.3g}; use a step below {:.3g}, fewer iterations or method.tolerance",
          options_.iterations, dt, t, limit, rate * dt, limit / rate));
}

void DeferredCorrection::check_stability(double t, double dt, const Field& u) const {
  const double limit = stability_limit(options_.iterations);
  // The fastest mode of the diffusion is known exactly, and rounding alone excites it.
  if (const double rate = rhs_->diffusion().spectral_radius(); rate * dt > limit) refuse_step(t, dt, rate);
  if (!(rate_ * dt > limit)) return;
  // The bound is a few per cent too large: nobody is to be refused for that.
  double rate = 0.0;
  const std::int64_t everywhere = u.decomposition().grid().total_points();
  look_at_reaction_modes(rhs_->reaction(), t, u, free_, everywhere, [&](int, int, std::span<const std::complex<double>> modes) {
    if (modes.empty()) rate = std::numeric_limits<double>::infinity();
    for (const std::complex<double>& lambda : modes) rate = std::max(rate, std::abs(lambda));
    return true;
  });
  rate = comm_->max(rate);
  if (std::isfinite(rate) && rate * dt > limit) refuse_step(t, dt, rate);
}

Attempt DeferredCorrection::fixed(double t, double dt, Field& u, Field& u_new, std::uint64_t& flags) {
  Attempt a;
  if (options_.refuse_unstable) check_stability(t, dt, u);
  constexpr int first_correction = 0, last_correction = 1;
  Agreement& agreement = agreement_;
  norm_.prepare(2, agreement);
  predict(t, dt, u, a);
  for (int k = 1; k <= options_.iterations; ++k) {
    evaluate_right_hand_sides(t, dt, a);
    last_->copy_interior(v_.back());
    // Corrections are measured by the prediction: where they are worthless the result may be large.
    if (k == 1) norm_.add_scale(*last_, agreement);
    correct(t, dt, u, a);
    if (k == 1) norm_.add_difference(v_.back(), *last_, first_correction, agreement);
    if (k == options_.iterations) norm_.add_difference(v_.back(), *last_, last_correction, agreement);
  }
  swap(u_new, v_.back());
  if (options_.iterations == 0) norm_.add_scale(u_new, agreement);
  agreement.maxima.push_back(rhs_->reaction().jacobian_bound(t + dt, u_new, free_));
  agreement.flags = flags | inspect(u_new, free_);
  if (a.failure) agreement.flags |= step_flags::cell_failed;
  comm_->agree(agreement);
  flags = agreement.flags;
  rate_ = agreement.maxima.back();
  a.accepted = !refuses(a, flags, u, u_new, free_, t, dt);
  a.dt_next = a.accepted ? options_.fixed_step : 0.5 * dt;
  if (!options_.refuse_unstable || options_.iterations == 0) return a;
  const double limit = stability_limit(options_.iterations);
  const double rate = std::max(rate_, rhs_->diffusion().spectral_radius());
  if (!a.accepted && rate * dt > limit) refuse_step(t, dt, rate);
  const double last = norm_.value(last_correction, agreement);
  // One correction is stable with every step, which does not make it one.
  if (options_.iterations == 1 && last > worthless_correction && rate * dt > stable_everywhere) {
    throw Error(ErrorKind::numerics,
                fmt::format("method.step: the correction with the step {:.6g} (t = {:.6g}) is {:.2g} of the prediction: a single one has "
                            "no limit of stability, but "
                            "here, |z| = {:.3g}, it is far from improving anything; use a smaller step, no iterations or method.tolerance",
                            dt, t, last, rate * dt));
  }
  const bool grows = options_.iterations > 1 && last > visible_divergence &&
                     (last > worthless_correction || !(last < norm_.value(first_correction, agreement)));
  if ((grows || !a.accepted) && rate * dt > stable_everywhere) {
    throw Error(
        ErrorKind::numerics,
        fmt::format("method.step: {} corrections with the step {:.6g} diverge (t = {:.6g}): {}; their limit of stability is |z| = {:.1f} "
                    "where modes "
                    "decay and less where they oscillate, and here |z| = {:.3g}; use a smaller step, fewer iterations or method.tolerance",
                    options_.iterations, dt, t, a.accepted ? fmt::format("the last one is {:.2g} of the prediction", last) : a.reason,
                    limit, rate * dt));
  }
  return a;
}

/// The last Legendre coefficients of F over the step, for quadrature_error: slots from 2 on.
void DeferredCorrection::add_modes(double dt, Agreement& agreement) {
  for (std::size_t mode = 0; mode < modes_.size(); ++mode) {
    terms_.clear();
    for (std::size_t j = 0; j < f_.size(); ++j) terms_.push_back({dt * modes_[mode][j], &f_[j]});
    norm_.add_combination(terms_, 2 + static_cast<int>(mode), agreement);
  }
}

/// The residuals tell how far the iteration is from collocation, not how far collocation is from the solution. That is seen in how fast
/// the Legendre coefficients of F over the step fall off: the first that Radau's rule does not integrate is extrapolated.
double DeferredCorrection::quadrature_error(double dt, const Agreement& agreement) const {
  const double stages = nodes_.size();
  // No solution has derivatives that grow faster than this.
  const double fastest = (rate_ + rhs_->diffusion().spectral_radius()) * dt / (2.0 * (2.0 * stages - 3.0));
  double error = 0.0;
  for (int k = 0; k < norm_.n_controlled(); ++k) {
    const double last = norm_.value(2, k, agreement);
    double before = norm_.value(3, k, agreement);
    // In an oscillation every other coefficient may vanish.
    if (modes_.size() > 2) before = std::max(before, std::sqrt(last * norm_.value(4, k, agreement)));
    if (!(last > 0.0)) continue;
    const double decay = std::min(last / before, fastest);
    error = std::max(error, quadrature_constant_ * last * std::pow(decay, stages));
  }
  return error;
}

Attempt DeferredCorrection::adaptive(double t, double dt, Field& u, Field& u_new, std::uint64_t& flags) {
  using Verdict = DeferredCorrectionControl::Verdict;
  Attempt a;
  a.work = std::exchange(work_ahead_, Work{});
  const std::uint64_t asked = flags;
  const double diffusion_rate = rhs_->diffusion().spectral_radius();
  predict(t, dt, u, a);
  Field& prediction = *last_;
  prediction.copy_interior(v_.back());
  std::uint64_t flags_of_prediction = 0;
  control_.begin(dt, rate_ + diffusion_rate);

  for (Verdict verdict = Verdict::correct; verdict == Verdict::correct;) {
    const bool first = a.iterations == 0;
    evaluate_right_hand_sides(t, dt, a);
    quadrature_to_end(dt, u, u_new);
    Agreement& agreement = agreement_;
    norm_.prepare(2 + static_cast<int>(modes_.size()), agreement);
    norm_.add_difference(u_new, v_.back(), 0, agreement);
    norm_.add_difference(u_new, prediction, 1, agreement);
    if (!first) add_modes(dt, agreement);
    norm_.add_scale(v_.back(), agreement);
    agreement.maxima.push_back(first ? rhs_->reaction().jacobian_bound(t + dt, v_.back(), free_) : 0.0);
    agreement.flags = asked | inspect(v_.back(), free_);
    if (a.failure) agreement.flags |= step_flags::cell_failed;
    comm_->agree(agreement);
    flags = agreement.flags;
    if (first) {
      rate_ = agreement.maxima.back();
      flags_of_prediction = flags;
    }
    // An iterate may be negative where the result is not: it is the result that counts.
    if (refuses(a, flags & ~step_flags::refuse_negative, u, v_.back(), free_, t, dt)) {
      control_.refuse();
      verdict = Verdict::reject;
      break;
    }
    verdict = control_.judge({norm_.value(0, agreement), norm_.value(1, agreement), first ? 0.0 : quadrature_error(dt, agreement)});
    if (verdict == Verdict::correct) correct(t, dt, u, a);
    if (verdict == Verdict::accept_prediction) {
      swap(v_.back(), prediction);
      flags = flags_of_prediction;
    }
    if (verdict == Verdict::accept || verdict == Verdict::accept_prediction) {
      a.accepted = !refuses(a, flags, u, v_.back(), free_, t, dt);
      if (!a.accepted) control_.refuse();
    }
  }

  a.error = control_.error();
  a.dt_next = control_.dt_next();
  if (a.accepted) {
    swap(u_new, v_.back());
  } else if (a.reason.empty()) {
    a.reason = control_.reason();
  }
  return a;
}

std::vector<DeferredCorrection::Estimate> DeferredCorrection::estimates(double t, double dt, Field& u, int most) {
  Attempt a;
  Field quadrature = u.similar();
  std::vector<Estimate> result;
  predict(t, dt, u, a);
  last_->copy_interior(v_.back());
  for (int k = 0; k <= most; ++k) {
    if (k > 0) correct(t, dt, u, a);
    evaluate_right_hand_sides(t, dt, a);
    quadrature_to_end(dt, u, quadrature);
    Agreement& agreement = agreement_;
    norm_.prepare(2, agreement);
    norm_.add_difference(quadrature, v_.back(), 0, agreement);
    norm_.add_difference(quadrature, *last_, 1, agreement);
    norm_.add_scale(v_.back(), agreement);
    comm_->agree(agreement);
    Estimate e;
    e.residual = norm_.value(0, agreement);
    if (k == 0) {
      e.error = e.residual;
    } else {
      e.step_limit = dt * result.back().residual / e.residual;
      const double r = e.residual / result.front().residual;
      if (r < 1.0) e.error = r / (1.0 - r) * norm_.value(1, agreement);
    }
    result.push_back(e);
  }
  return result;
}

void DeferredCorrection::visit_state(StateVisitor& visitor) {
  visit_flows(visitor, *reaction_, *flows_.diffusion);
  visitor.numbers("scale_floors", norm_.floors());
  visitor.number("rate", rate_);
  DeferredCorrectionControl::Memory& memory = control_.memory();
  visitor.integer("hold", memory.hold);
  visitor.number("rejected_step", memory.rejected_step);
  visitor.integer("iterations", memory.iterations);
  visitor.number("accepted_step", memory.step);
  visitor.number("prediction_step", memory.prediction_step);
  visitor.number("prediction_error", memory.prediction_error);
  visitor.number("prediction_power", memory.prediction_power);
}

}  // namespace stiffront
