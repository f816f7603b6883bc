// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/parallel_deferred_correction.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "stiffront/control/bdf_history.hpp"
#include "stiffront/control/diagonal_preconditioner.hpp"
#include "stiffront/control/starting_weights.hpp"
#include "stiffront/core/error.hpp"

namespace stiffront {
namespace {

using Options = ParallelDeferredCorrectionOptions;

// Below this, in the relative norm, a change is round-off.
constexpr double round_off_floor = 1e-15;

Options checked(Options o) {
  const auto refuse = [](const std::string& message) { throw Error(ErrorKind::input, message); };
  if (o.node_count < 2 || o.node_count > max_parallel_nodes) {
    refuse(fmt::format("method.node_count: expected 2 to {} with splitting = \"diagonal\", got {}", max_parallel_nodes, o.node_count));
  }
  const int highest = std::min(o.node_count, static_cast<int>(bdf_max_points));
  if (o.starting_order < 1 || o.starting_order > highest) {
    refuse(fmt::format("method.starting_order: expected 1 to {} with {} nodes, got {}", highest, o.node_count, o.starting_order));
  }
  if (!(o.fixed_step > 0.0) && !(o.tolerance > 0.0)) refuse("method: missing: step, or tolerance for adaptive steps");
  if (const int least = o.fixed_step > 0.0 ? 0 : 1; o.corrections < least) {
    refuse(fmt::format("method.corrections: expected {} at least, got {}", least, o.corrections));
  }
  if (!(o.shift >= 0.0)) refuse(fmt::format("method.gamma_diffusion: expected a number not below 0, got {}", o.shift));
  return o;
}

}  // namespace

ParallelDeferredCorrection::ParallelDeferredCorrection(const Field& shape, CoupledRhs& rhs, const ModelKernels& model, Options options)
    : comm_(&shape.comm()),
      rhs_(&rhs),
      diffusion_(&rhs.diffusion()),
      model_(&model),
      options_(checked(options)),
      nodes_(collocation_nodes(NodeFamily::gauss_radau, options_.node_count)),
      start_kernel_(model.make_sbdf()),
      kernel_(model.make_node_sweep()),
      halo_(shape.decomposition(), diffusion_->boundary(), shape.n_species(), 1, diffusion_->halo_width(), diffusion_->diffusing_species()),
      node_halos_(shape.decomposition(), diffusion_->boundary(), shape.n_species(), options_.node_count, diffusion_->halo_width(),
                  diffusion_->diffusing_species()),
      norm_(shape.decomposition(), rhs.boundary(), shape.n_species(), {}),
      free_(rhs.free_box()) {
  const double rho = diffusion_->spectral_radius();
  longest_step_ = rho > 0.0 ? stable_z / rho : std::numeric_limits<double>::infinity();
  for (int i = 0; i < options_.node_count; ++i) {
    v_.push_back(shape.similar());
    next_.push_back(shape.similar());
  }
  for (int i = 1; i < options_.starting_order; ++i) history_.push_back(shape.similar());
  const std::vector<double> diagonal = min_sr_s(options_.node_count);
  sweep_.nodes = options_.node_count;
  sweep_.shift = options_.shift;
  sweep_.decomposition = &shape.decomposition();
  for (std::size_t i = 0; i < count(); ++i) {
    sweep_.c[i] = nodes_.c[i];
    sweep_.diagonal[i] = diagonal[i];
    std::copy(nodes_.s[i].begin(), nodes_.s[i].end(), sweep_.s[i].begin());
  }
}

double ParallelDeferredCorrection::first_step(double t, double t_end, Field& u) {
  if (options_.fixed_step > 0.0) return options_.fixed_step;
  if (options_.initial_step > 0.0) return std::min(options_.initial_step, t_end - t);
  const double tenth = std::min(0.1 * (t_end - t), longest_step_);
  const double rate = comm_->max(model_->jacobian_bound(t, u, free_));
  return rate * tenth > 1.0 ? 1.0 / rate : tenth;
}

void ParallelDeferredCorrection::start(double t, double dt, Field& u, Attempt& a) {
  const Boundary& boundary = diffusion_->boundary();
  Field& right = next_[0];
  Field& guess = next_[1];
  for (std::size_t i = 0; i < count(); ++i) {
    // The nodes before, the beginning of the step, and the nodes of the step before.
    std::array<double, bdf_max_points> times{};
    std::array<const Field*, bdf_max_points> states{};
    std::size_t known = 0;
    const auto add = [&](double time, const Field& v) {
      if (known == static_cast<std::size_t>(options_.starting_order)) return;
      times[known] = time;
      states[known++] = &v;
    };
    for (std::size_t k = i; k-- > 0;) add(nodes_.c[k] * dt, v_[k]);
    add(0.0, u);
    for (std::size_t k = 0; k < history_times_.size(); ++k) add(history_times_[k], history_[k]);

    const double target = nodes_.c[i] * dt;
    const StartingWeights w = starting_weights(target, std::span(times).first(known));
    BdfWeights extrapolation{};
    BdfWeights right_side{};
    for (std::size_t k = 0; k < known; ++k) {
      extrapolation[k] = w.extrapolation[k];
      right_side[k] = w.states[k] + w.extrapolation[k];
    }
    bdf_combine(std::span(states).first(known), extrapolation, right_side, rows_of(guess), rows_of(right), free_);
    boundary.impose(guess, t + target);
    boundary.impose(v_[i], t + target);
    halo_.exchange(guess);
    SbdfSweep step;
    step.t = t + target;
    step.gamma = w.h;
    step.decomposition = &u.decomposition();
    step.v = rows_of(std::as_const(guess));
    step.r = rows_of(std::as_const(right));
    step.out = rows_of(v_[i]);
    start_kernel_->sweep(*diffusion_, step, free_);
    ++a.work.halo_exchanges;
    ++a.work.sweeps;
  }
  // What no sweep writes.
  for (std::size_t i = 0; i < count(); ++i) boundary.impose(next_[i], t + nodes_.c[i] * dt);
}

void ParallelDeferredCorrection::sweep(double t, double dt, const Field& u, Attempt& a) {
  std::array<Field*, max_parallel_nodes> fields{};
  for (std::size_t i = 0; i < count(); ++i) fields[i] = &v_[i];
  node_halos_.exchange(std::span<Field* const>(fields).first(count()));
  sweep_.t = t;
  sweep_.dt = dt;
  sweep_.u = rows_of(u);
  for (std::size_t i = 0; i < count(); ++i) {
    sweep_.v[i] = rows_of(std::as_const(v_[i]));
    sweep_.out[i] = rows_of(next_[i]);
  }
  kernel_->sweep(*diffusion_, sweep_, free_);
  std::swap(v_, next_);
  const auto cells = static_cast<std::int64_t>(free_.i_end - free_.i_begin) * (free_.j_end - free_.j_begin);
  const auto all = static_cast<std::int64_t>(count());
  ++a.work.halo_exchanges;
  a.work.sweeps += all;
  a.work.reaction_rhs += all * cells;
  ++a.iterations;
}

Attempt ParallelDeferredCorrection::attempt(double t, double dt, Field& u, Field& u_new, std::uint64_t& flags) {
  attempted_dt_ = dt;
  Attempt a = options_.fixed_step > 0.0 ? fixed(t, dt, u, u_new, flags) : adaptive(t, dt, u, u_new, flags);
  const auto cells = static_cast<std::int64_t>(free_.i_end - free_.i_begin) * (free_.j_end - free_.j_begin);
  a.work.reaction_jacobians = cells * a.work.sweeps;
  a.work.reaction_rhs += cells * static_cast<std::int64_t>(count());
  return a;
}

Attempt ParallelDeferredCorrection::fixed(double t, double dt, Field& u, Field& u_new, std::uint64_t& flags) {
  Attempt a;
  const bool has_history = history_times_.size() == history_.size();
  start(t, dt, u, a);
  // The order of a start without history rises from 1 over the nodes.
  const int sweeps = options_.corrections + (has_history || options_.corrections == 0 ? 0 : options_.starting_order - 1);
  for (int l = 0; l < sweeps; ++l) sweep(t, dt, u, a);
  u_new.copy_interior(v_.back());
  Agreement agreement(0, 0);
  agreement.flags = flags | inspect(u_new, free_);
  comm_->agree(agreement);
  flags = agreement.flags;
  if ((flags & step_flags::not_finite) != 0) {
    throw Error(
        ErrorKind::numerics,
        fmt::format("method.step: the solution is not finite after the step of {:.6g} from t = {:.6g}: this step is not stable; use "
                    "a smaller one, or method.tolerance",
                    dt, t));
  }
  a.accepted = true;
  a.dt_next = options_.fixed_step;
  return a;
}

Attempt ParallelDeferredCorrection::adaptive(double t, double dt, Field& u, Field& u_new, std::uint64_t& flags) {
  Attempt a;
  start(t, dt, u, a);
  // Steps as long as diffusion allows may need fewer sweeps.
  const bool is_limited = dt > 0.99 * longest_step_;
  const int planned = options_.corrections;
  double before = std::numeric_limits<double>::infinity();
  while (true) {
    sweep(t, dt, u, a);
    if (a.iterations < planned && !is_limited) continue;
    Agreement agreement = norm_.agreement(1);
    norm_.add_difference(v_.back(), next_.back(), 0, agreement);
    norm_.add_scale(v_.back(), agreement);
    agreement.flags = flags | inspect(v_.back(), free_);
    comm_->agree(agreement);
    flags = agreement.flags;
    a.error = norm_.value(0, agreement);
    if ((flags & step_flags::not_finite) != 0 || !std::isfinite(a.error)) {
      a.reason = "the iterates are not finite";
      a.dt_next = 0.25 * dt;
      return a;
    }
    const double change = std::max(a.error, round_off_floor);
    if (a.iterations <= planned) {
      // The change by sweep l is the error before it and behaves like dT^(k + l).
      a.dt_next = options_.safety * dt * std::pow(options_.tolerance / change, 1.0 / (options_.starting_order + a.iterations));
    }
    if (change <= std::max(options_.tolerance, round_off_floor)) {
      a.accepted = true;
      break;
    }
    if (a.iterations > planned && change > 2.0 * before) {
      a.reason = "the corrections do not converge";
      break;
    }
    if (a.iterations >= 2 * planned) {
      a.reason = "the last correction changes more than the tolerance allows";
      break;
    }
    before = change;
  }
  if (a.accepted) {
    u_new.copy_interior(v_.back());
    ++accepted_;
    if (a.dt_next > longest_step_) ++limited_;
    a.dt_next = std::min({a.dt_next, options_.max_growth * dt, longest_step_});
  } else {
    a.dt_next = std::clamp(a.dt_next, 0.1 * dt, 0.5 * dt);
  }
  return a;
}

void ParallelDeferredCorrection::accept(Field& u, Field& u_new) {
  swap(u, u_new);
  // The nodes become history, from the end backwards; the end itself is the new state.
  history_times_.clear();
  std::size_t next = count() - 1;
  for (std::size_t k = 0; k < history_.size() && next > 0; ++k) {
    --next;
    swap(history_[k], v_[next]);
    history_times_.push_back((nodes_.c[next] - 1.0) * attempted_dt_);
  }
}

std::string ParallelDeferredCorrection::closing_note() const {
  if (10 * limited_ < accepted_ || limited_ == 0) return {};
  return fmt::format(
      "diffusion limited {} of {} steps: their nodes are not coupled to neighbours, which is stable up to dT = {:.3g}; for diffusion "
      "this stiff use method sbdf, or splitting = \"preconditioned\"",
      limited_, accepted_, longest_step_);
}

void ParallelDeferredCorrection::restart(double t) {
  static_cast<void>(t);
  history_times_.clear();
}

void ParallelDeferredCorrection::visit_state(StateVisitor& visitor) {
  visitor.numbers("history_times", history_times_);
  for (std::size_t k = 0; k < history_times_.size(); ++k) visitor.field(fmt::format("history-state-{}", k + 1), history_[k]);
}

}  // namespace stiffront
