// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/sbdf.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <utility>

#include "stiffront/control/bdf_ringing.hpp"
#include "stiffront/control/sbdf_stability.hpp"
#include "stiffront/control/sbdf_tables.hpp"
#include "stiffront/core/error.hpp"

namespace stiffront {
namespace {

/// Parts of the diffusion in the matrices of the Newton iterations on a line. The fourth-order operator is 1 to 4/3
/// times the second-order one, and these leave at most 1/45 of the predictor's error in any mode: less than BDF5 bears.
std::span<const double> line_factors(int space_order) {
  static constexpr std::array<double, 2> factors{1.0, 1.25};
  return std::span<const double>(factors).first(space_order == 2 ? 1 : 2);
}

SbdfOptions checked(SbdfOptions o, int n_species) {
  if (!(o.relative_tolerance > 0.0)) {
    throw Error(ErrorKind::input, fmt::format("method.relative_tolerance: expected a positive number, got {}", o.relative_tolerance));
  }
  if (o.absolute_tolerance.size() == 1) o.absolute_tolerance.resize(static_cast<std::size_t>(n_species), o.absolute_tolerance[0]);
  if (!o.absolute_tolerance.empty() && o.absolute_tolerance.size() != static_cast<std::size_t>(n_species)) {
    throw Error(ErrorKind::input,
                fmt::format("method.absolute_tolerance: expected 1 or {} numbers, got {}", n_species, o.absolute_tolerance.size()));
  }
  for (double a : o.absolute_tolerance) {
    if (!(a > 0.0)) throw Error(ErrorKind::input, fmt::format("method.absolute_tolerance: expected positive numbers, got {}", a));
  }
  if (o.max_order < 1 || o.max_order > sbdf_max_order) {
    throw Error(ErrorKind::input, fmt::format("method.max_order: expected 1 to {}, got {}", sbdf_max_order, o.max_order));
  }
  if (o.max_sweeps < 1 || o.max_sweeps > sbdf_max_sweeps) {
    throw Error(ErrorKind::input, fmt::format("method.max_sweeps: expected 1 to {}, got {}", sbdf_max_sweeps, o.max_sweeps));
  }
  if (!(o.initial_step >= 0.0)) {
    throw Error(ErrorKind::input, fmt::format("method.initial_step: expected a number >= 0, got {}", o.initial_step));
  }
  const double of_step = sbdf_step_tolerance(o.relative_tolerance);
  for (double& a : o.absolute_tolerance) a *= of_step / o.relative_tolerance;
  o.relative_tolerance = of_step;
  return o;
}

}  // namespace

double sbdf_line_cost(int n_species) { return std::min(3.0 + 10.0 * n_species, 35.0); }

double sbdf_plane_cost(int n_species) {
  return n_species <= plane_correction_species ? 25.0 + 5.0 * n_species : std::numeric_limits<double>::infinity();
}

double sbdf_step_tolerance(double relative_tolerance) {
  constexpr double loosest = 3e-3;
  constexpr double loosest_scaled = 1e-3;
  return std::min(relative_tolerance, loosest) * std::min(1.0, std::pow(relative_tolerance / loosest_scaled, 0.2));
}

Sbdf::Sbdf(const Field& shape, CoupledRhs& rhs, const ModelKernels& model, SbdfOptions options)
    : rhs_(&rhs),
      diffusion_(&rhs.diffusion()),
      comm_(&shape.comm()),
      options_(checked(std::move(options), shape.n_species())),
      model_(&model),
      kernel_(model.make_sbdf()),
      halo_(shape.decomposition(), diffusion_->boundary(), shape.n_species(), 1, diffusion_->halo_width(), diffusion_->diffusing_species()),
      free_(rhs.free_box()),
      interior_(free_),
      has_neighbours_(false),
      cells_(static_cast<double>(diffusion_->boundary().free_points(shape.decomposition().grid()))),
      control_(options_.max_order),
      extremes_(2 * static_cast<std::size_t>(shape.n_species()), 0.0),
      absolute_(options_.absolute_tolerance),
      predictor_(shape.similar()),
      right_side_(shape.similar()),
      work_(shape.similar()),
      agreement_(3, 2 * shape.n_species() + 1) {
  if (SbdfWavefront::serves(shape.decomposition()))
    wavefront_.emplace(shape, *diffusion_, *kernel_, options_.max_sweeps, options_.wavefront_depth, options_.wavefront_steps);
  const double rho = diffusion_->spectral_radius();
  economic_steps_.fill(std::numeric_limits<double>::infinity());
  for (int order = 1; order <= sbdf_max_order; ++order) {
    for (std::size_t i = 0; i < sbdf_sweep_counts.size(); ++i) {
      const double z = sbdf_z_safety(order) * sbdf_z_limit(order, sbdf_sweep_counts[i]);
      longest_steps_[static_cast<std::size_t>(order)][i] = z / rho;
    }
    economic_steps_[static_cast<std::size_t>(order)] = cap_step(order, std::numeric_limits<double>::infinity());
  }
  if (wavefront_ && wavefront_->halo() > shape.halo()) {
    predictor_ = Field(shape.decomposition(), shape.n_species(), wavefront_->halo());
    right_side_ = predictor_.similar();
  }
  for (Made& made : made_) made.extremes.resize(2 * static_cast<std::size_t>(shape.n_species()));
  if (wavefront_) {
    for (int k = 1; k < wavefront_->steps_together(1); ++k) ahead_.push_back(shape.similar());
  }
  absolute_.resize(static_cast<std::size_t>(shape.n_species()), 0.0);
  const Decomposition& decomposition = shape.decomposition();
  for (int i = 0; i < options_.max_order; ++i) history_.push_back(shape.similar());

  // What needs no halo can be swept while messages travel. Columns at the sides come in whole packs.
  const int w = diffusion_->halo_width();
  const auto is_neighbour = [&](int dx, int dy) { return decomposition.neighbour(dx, dy) != MPI_PROC_NULL; };
  has_neighbours_ = is_neighbour(-1, 0) || is_neighbour(1, 0) || is_neighbour(0, -1) || is_neighbour(0, 1);
  if (has_neighbours_) {
    const int columns = std::min(pack_size, std::max(w, (free_.i_end - free_.i_begin) / 2));
    const int rows = decomposition.grid().dimension == 2 ? w : 0;
    interior_.i_begin = std::min(free_.i_begin + columns, free_.i_end);
    interior_.i_end = std::max(interior_.i_begin, free_.i_end - columns);
    interior_.j_begin = std::min(free_.j_begin + rows, free_.j_end);
    interior_.j_end = std::max(interior_.j_begin, free_.j_end - rows);
    edges_ = {{free_.i_begin, free_.i_end, free_.j_begin, interior_.j_begin},
              {free_.i_begin, free_.i_end, interior_.j_end, free_.j_end},
              {free_.i_begin, interior_.i_begin, interior_.j_begin, interior_.j_end},
              {interior_.i_end, free_.i_end, interior_.j_begin, interior_.j_end}};
    std::erase_if(edges_, [](const FreeBox& b) { return b.i_begin >= b.i_end || b.j_begin >= b.j_end; });
  }
}

Sbdf::Treatment Sbdf::treatment(int order, double dt) const {
  Treatment best;
  double longest = 0.0;
  for (std::size_t i = 0; i < sbdf_sweep_counts.size() && sbdf_sweep_counts[i] <= options_.max_sweeps && longest < dt; ++i) {
    best = {sbdf_sweep_counts[i], static_cast<double>(sbdf_sweep_counts[i])};
    longest = longest_steps_[static_cast<std::size_t>(order)][i];
  }
  if (diffusion_->dimension() == 1) {
    const double passes = static_cast<double>(line_factors(diffusion_->order()).size());
    const double cost = passes * sbdf_line_cost(diffusion_->n_species());
    if (cost < best.cost || longest < dt) best = {0, cost};
  } else {
    const double cost = sbdf_plane_cost(diffusion_->n_species());
    if (cost < best.cost || (longest < dt && std::isfinite(cost))) best = {0, cost};
  }
  return best;
}

double Sbdf::cap_step(int order, double dt) const {
  const double economic = economic_steps_[static_cast<std::size_t>(order)];
  if (dt > economic) return economic;
  // Largest step per cost; a step costs its sweeps and the work on the history.
  const double overhead = 1.5 + 0.35 * order;
  double best = 0.0;
  double best_dt = 0.0;
  const auto consider = [&](double h, double cost) {
    const double rate = h / (cost + overhead);
    if (rate > best) {
      best = rate;
      best_dt = h;
    }
  };
  double longest = 0.0;
  for (std::size_t i = 0; i < sbdf_sweep_counts.size() && sbdf_sweep_counts[i] <= options_.max_sweeps && longest < dt; ++i) {
    longest = longest_steps_[static_cast<std::size_t>(order)][i];
    consider(std::min(dt, longest), sbdf_sweep_counts[i]);
  }
  const Treatment whole = treatment(order, dt);
  if (whole.sweeps == 0) consider(dt, whole.cost);
  return best_dt;
}

Sbdf::Step Sbdf::plan(double dt, int ahead) const {
  Step step;
  const std::size_t states = std::min(states_ + static_cast<std::size_t>(ahead), history_.size() + 1);
  step.order = control_.order();
  step.sweeps = treatment(step.order, dt).sweeps;
  if (states == 1) {
    // u + dt F(u): the error of the first implicit Euler step is half of its difference to the explicit one.
    step.points = 2;
    step.gamma = dt;
    step.error_factor = 0.5;
    step.predictor = {1.0, dt};
    step.history = {1.0};
    return step;
  }
  const auto k = static_cast<std::size_t>(step.order);
  step.points = k + 1;
  std::array<double, bdf_max_points + 1> steps{};
  double back = dt;
  const auto same = static_cast<std::size_t>(ahead) + 1;
  for (std::size_t i = 0; i < states && i < steps.size(); ++i) steps[i] = i < same ? dt : steps_[i - same];
  for (std::size_t i = 1; i <= k; ++i) back += steps[i];
  const auto weights = sbdf_stability::step_weights(step.order, steps);
  step.gamma = weights.gamma * dt;
  step.error_factor = step.gamma / back;
  std::copy(weights.predictor.begin(), weights.predictor.end(), step.predictor.begin());
  std::copy(weights.history.begin(), weights.history.end(), step.history.begin());
  step.tests_order = control_.wants_order_test(ahead);
  if (step.tests_order) {
    if (step.order > 1) {
      const auto lower = sbdf_stability::step_weights(step.order - 1, steps);
      std::copy(lower.predictor.begin(), lower.predictor.end(), step.lower.begin());
      step.lower_factor = lower.gamma * dt / (back - steps[k]);
    }
    if (control_.wants_second_order()) {
      const auto second = sbdf_stability::step_weights(2, steps);
      std::copy(second.predictor.begin(), second.predictor.end(), step.upper.begin());
      step.second_factor = second.gamma * dt / (steps[0] + steps[1] + steps[2]);
    } else if (step.order < control_.highest_order() && states >= k + 2) {
      const auto upper = sbdf_stability::step_weights(step.order + 1, steps);
      std::copy(upper.predictor.begin(), upper.predictor.end(), step.upper.begin());
      step.upper_factor = upper.gamma * dt / (back + steps[k + 1]);
    }
  }
  return step;
}

void Sbdf::update_tolerances(std::span<const double> extremes) {
  if (!options_.absolute_tolerance.empty()) return;
  const std::size_t m = absolute_.size();
  double top = 0.0;
  for (std::size_t s = 0; s < 2 * m; ++s) {
    extremes_[s] = std::max(extremes_[s], extremes[s]);
    top = std::max(top, extremes_[s]);
  }
  if (top == 0.0) top = 1.0;
  for (std::size_t s = 0; s < m; ++s) {
    const double larger = std::max(extremes_[s], extremes_[m + s]);
    const double smaller = std::min(extremes_[s], extremes_[m + s]);
    absolute_[s] = options_.relative_tolerance * std::max({1e-3 * larger, 0.1 * smaller, 1e-6 * top});
  }
}

double Sbdf::norm(const ReproducibleSum& sum) const {
  const double n_species = static_cast<double>(absolute_.size());
  return std::pow(sum.value() / (cells_ * n_species * n_species), 0.25);
}

void Sbdf::ensure_slope(double t, Field& u) {
  if (has_slope_) return;
  rhs_->evaluate(t, u, ring(0));
  has_slope_ = true;
}

double Sbdf::scaled_norm(const Field& u, std::span<const Field* const> states, const BdfWeights& weights) {
  bdf_combine(states, weights, weights, rows_of(predictor_), rows_of(work_), free_);
  Agreement a(1, 0);
  const std::array references{rows_of(std::as_const(work_))};
  std::vector<Pack> extremes(extremes_.size(), Pack(0.0));
  bdf_add_differences(u, references, {options_.relative_tolerance, absolute_}, free_, a.sums, extremes);
  comm_->agree(a);
  return norm(a.sums[0]);
}

double Sbdf::first_step(double t, double t_end, Field& u) {
  ensure_slope(t, u);
  const Field& f = ring(0);
  const auto m = static_cast<std::size_t>(u.n_species());
  Agreement a(0, 2 * u.n_species());
  for (std::size_t s = 0; s < m; ++s) {
    double largest = 0.0;
    double smallest = 0.0;
    for (int j = free_.j_begin; j < free_.j_end; ++j) {
      const double* const row = u.row(static_cast<int>(s), j);
      for (int i = free_.i_begin; i < free_.i_end; ++i) {
        largest = std::max(largest, row[i]);
        smallest = std::min(smallest, row[i]);
      }
    }
    a.maxima[s] = largest;
    a.maxima[m + s] = -smallest;
  }
  comm_->agree(a);
  update_tolerances(a.maxima);
  if (options_.initial_step > 0.0) return std::min(options_.initial_step, t_end - t);
  // Species that begin at zero may change by far more than their tolerance in any step, though not by more than the step can
  // follow: such a speed must not keep the step below what time resolves.
  const double shortest = 100.0 * std::numeric_limits<double>::epsilon() * std::max(std::abs(t), t_end - t);
  const double span = t_end - t;
  const double speed = scaled_norm(u, std::array{&std::as_const(u), &f}, {1.0, span}) / span;
  if (!(speed > 0.0)) return cap_step(1, 1e-3 * span);
  const double short_step = std::max(0.5 / speed, shortest);
  // An explicit Euler step of half a tolerance shows the second derivative, and that the error of a step at order 1.
  const BdfWeights euler{1.0, short_step};
  bdf_combine(std::array{&std::as_const(u), &f}, euler, euler, rows_of(predictor_), rows_of(work_), free_);
  rhs_->evaluate(t + short_step, work_, right_side_);
  const double bend =
      scaled_norm(u, std::array{&std::as_const(u), &std::as_const(right_side_), &f}, {1.0, span, -span}) / (span * short_step);
  // At the edge of where the rates are defined the explicit step may leave it.
  const double h = std::isfinite(bend) ? std::min(std::sqrt(BdfControl::aim_of_start() / bend), 1000.0 * short_step) : short_step;
  return cap_step(1, std::min(h, span));
}

void Sbdf::sweep(const Step& step, double t_new, const Field& v, Field& out, double shift) {
  SbdfSweep sweep;
  sweep.t = t_new;
  sweep.gamma = step.gamma;
  sweep.shift = shift;
  sweep.decomposition = &v.decomposition();
  sweep.v = rows_of(v);
  sweep.r = rows_of(std::as_const(right_side_));
  sweep.out = rows_of(out);
  if (!has_neighbours_) {
    halo_.finish();
    kernel_->sweep(*diffusion_, sweep, free_);
    return;
  }
  kernel_->sweep(*diffusion_, sweep, interior_);
  halo_.finish();
  for (const FreeBox& edge : edges_) kernel_->sweep(*diffusion_, sweep, edge);
}

void Sbdf::iterate_line(const Step& step, double t_new, const Field& v, Field& out, double c) {
  if (!line_) line_ = model_->make_sbdf_line(v.decomposition());
  SbdfSweep sweep;
  sweep.t = t_new;
  sweep.gamma = step.gamma;
  sweep.decomposition = &v.decomposition();
  sweep.v = rows_of(v);
  sweep.r = rows_of(std::as_const(right_side_));
  sweep.out = rows_of(out);
  halo_.finish();
  line_->iterate(*diffusion_, sweep, c, free_);
}

void Sbdf::correct_plane(const Step& step, double t_new, Field& v, bool is_first) {
  SbdfSweep sweep;
  sweep.t = t_new;
  sweep.gamma = step.gamma;
  sweep.decomposition = &v.decomposition();
  sweep.v = rows_of(std::as_const(v));
  sweep.r = rows_of(std::as_const(right_side_));
  halo_.exchange(v);
  if (is_first) plane_->prepare(*equations_, sweep);
  plane_->correct(*equations_, sweep, v);
}

std::span<const double> Sbdf::shifts_of(const Step& step) const {
  return step.sweeps == 0 ? line_factors(diffusion_->order()) : sbdf_shifts(step.order, step.sweeps);
}

void Sbdf::add_errors(Made& made, const Field& u_new, const BdfPredictors& predictors, bool tested, const FreeBox& box) {
  std::array<ConstRows, 3> references{predictors.same, predictors.lower, predictors.upper};
  std::size_t count = 1;
  if (made.step.tests_order) {
    if (!tested) return;
    count = made.step.upper_factor > 0.0 || made.step.second_factor > 0.0 ? 3 : 2;
  }
  bdf_add_differences(u_new, std::span(references).first(count), {options_.relative_tolerance, absolute_}, box, made.sums, made.extremes);
}

void Sbdf::make_by_sweeps(const Made& made, std::span<const Field* const> states, Field& u_new) {
  const double t_new = made.t + made.dt;
  const Step& step = made.step;
  bdf_combine(states, step.predictor, step.history, rows_of(predictor_), rows_of(right_side_), free_);
  const bool corrects = step.sweeps == 0 && diffusion_->dimension() == 2;
  if (corrects && !plane_) {
    equations_ = model_->make_sbdf_equations();
    plane_ = make_plane_correction(u_new, *diffusion_);
  }
  const std::size_t groups = corrects ? PlaneCorrection::groups : 1;
  const auto shifts_of_group = [&](std::size_t g) { return corrects ? plane_->shifts(g) : shifts_of(step); };
  std::size_t passes = 0;
  for (std::size_t g = 0; g < groups; ++g) passes += shifts_of_group(g).size();
  const Boundary& boundary = diffusion_->boundary();
  if (boundary.has_dirichlet()) {
    boundary.impose(predictor_, t_new);
    boundary.impose(u_new, t_new);
    if (passes > 1) boundary.impose(work_, t_new);
  }
  Field* v = &predictor_;
  for (std::size_t g = 0; g < groups; ++g) {
    if (g > 0) correct_plane(step, t_new, *v, g == 1);
    for (double shift : shifts_of_group(g)) {
      --passes;
      Field* out = passes % 2 == 0 ? &u_new : &work_;
      Field* const exchanged = v;
      halo_.begin(std::span<Field* const>(&exchanged, 1));
      step.sweeps == 0 && !corrects ? iterate_line(step, t_new, *v, *out, shift) : sweep(step, t_new, *v, *out, shift);
      v = out;
    }
  }
}

bool Sbdf::take_made(double t, double dt, const Step& step, Field& u_new) {
  if (next_made_ >= made_count_) return false;
  const Made& made = made_[next_made_];
  if (made.t != t || made.dt != dt || !(made.step == step)) return false;
  swap(u_new, ahead_[next_made_ - 1]);
  ++next_made_;
  return true;
}

void Sbdf::make_steps(double t, double dt, const Step& step, const Field& u, Field& u_new) {
  const bool in_wavefront = is_in_wavefront(step);
  made_count_ = 1;
  if (in_wavefront && !ahead_.empty()) {
    made_count_ = static_cast<std::size_t>(std::min(control_.likely_alike(), wavefront_->steps_together(step.sweeps)));
  }
  next_made_ = 1;
  double t_made = t;
  for (std::size_t k = 0; k < made_count_; ++k) {
    Made& made = made_[k];
    made.t = t_made;
    made.dt = dt;
    made.step = k == 0 ? step : plan(dt, static_cast<int>(k));
    for (ReproducibleSum& sum : made.sums) sum.reset();
    std::fill(made.extremes.begin(), made.extremes.end(), Pack(0.0));
    t_made += dt;
  }
  // The states from the newest that any of the steps starts from.
  std::array<const Field*, bdf_max_points + SbdfWavefront::max_steps> states{};
  std::size_t known = 0;
  for (std::size_t k = made_count_ - 1; k > 0; --k) states[known++] = k == 1 ? &u_new : &ahead_[k - 2];
  states[known++] = &u;
  for (std::size_t i = 0; i < history_.size(); ++i) states[known++] = &ring(i);
  const auto states_of = [&](std::size_t k, std::size_t count) {
    return std::span<const Field* const>(states).subspan(made_count_ - 1 - k, count);
  };
  const auto tested_states = [&](std::size_t k) {
    const Step& s = made_[k].step;
    return states_of(k, s.tests_order ? std::min({states_ + k, s.points + 1, history_.size() + 1}) : s.points);
  };

  if (in_wavefront) {
    std::array<SbdfWavefront::Step, SbdfWavefront::max_steps> steps;
    for (std::size_t k = 0; k < made_count_; ++k) {
      const Step& s = made_[k].step;
      steps[k] = {made_[k].t + dt, s.gamma, tested_states(k), static_cast<int>(s.points),      s.predictor, s.history, s.tests_order,
                  s.lower,         s.upper, shifts_of(s),     k == 0 ? &u_new : &ahead_[k - 1]};
    }
    // One reference is all the callback holds, so that it is made without an allocation.
    const auto add = [&, this](std::size_t k, const FreeBox& box, const BdfPredictors& predictors, bool tested) {
      add_errors(made_[k], *steps[k].u_new, predictors, tested, box);
    };
    wavefront_->run(std::span(steps).first(made_count_), predictor_, right_side_, work_, std::cref(add));
    if (!step.tests_order || wavefront_->tests_on_the_way(step.sweeps)) return;
  } else {
    make_by_sweeps(made_[0], states_of(0, step.points), u_new);
  }
  // Sweeps are over: their fields serve the predictors of other orders.
  BdfPredictors predictors{rows_of(std::as_const(predictor_)), {}, {}};
  if (step.tests_order) {
    bdf_combine(tested_states(0), step.lower, step.upper, rows_of(work_), rows_of(right_side_), free_);
    predictors.lower = rows_of(std::as_const(work_));
    predictors.upper = rows_of(std::as_const(right_side_));
  }
  add_errors(made_[0], u_new, predictors, step.tests_order, free_);
}

void Sbdf::count_work(const Step& step, Work& work) const {
  const auto cells = static_cast<std::int64_t>(free_.i_end - free_.i_begin) * (free_.j_end - free_.j_begin);
  if (step.sweeps == 0 && diffusion_->dimension() == 2) {
    constexpr auto corrections = static_cast<std::int64_t>(PlaneCorrection::groups) - 1;
    for (std::size_t g = 0; g < PlaneCorrection::groups; ++g) work.sweeps += static_cast<std::int64_t>(plane_->shifts(g).size());
    work.linear_iterations = corrections;
    work.halo_exchanges = work.sweeps + corrections;
    work.reaction_rhs = cells * (work.sweeps + corrections);
    work.reaction_jacobians = cells * work.sweeps;
    return;
  }
  const auto passes = static_cast<std::int64_t>(shifts_of(step).size());
  (step.sweeps == 0 ? work.line_solves : work.sweeps) = passes;
  work.halo_exchanges = is_in_wavefront(step) && wavefront_->has_neighbours() ? 1 : passes;
  work.reaction_rhs = work.reaction_jacobians = cells * passes;
}

Attempt Sbdf::attempt(double t, double dt, Field& u, Field& u_new, std::uint64_t& flags) {
  Attempt attempt;
  attempt.iterations = control_.order();
  if (states_ == 1) ensure_slope(t, u);
  if (absolute_[0] == 0.0) update_tolerances(extremes_);
  const Step step = plan(dt);
  const double t_new = t + dt;

  if (!take_made(t, dt, step, u_new)) make_steps(t, dt, step, u, u_new);
  const Made& made = made_[next_made_ - 1];
  // What ranks tell each other takes time: most steps need one sum.
  agreement_.sums.resize(step.tests_order ? made.sums.size() : 1);
  agreement_.maxima.assign(step.tests_order ? made.extremes.size() + 1 : 0, 0.0);
  std::copy_n(made.sums.begin(), agreement_.sums.size(), agreement_.sums.begin());
  count_work(step, attempt.work);

  BdfErrors errors;
  agreement_.flags = flags;
  if (step.tests_order) {
    for (std::size_t s = 0; s < made.extremes.size(); ++s) agreement_.maxima[s] = max_lane(made.extremes[s]);
    if (control_.wants_quiet_order()) {
      agreement_.maxima.back() =
          options_.max_order - highest_quiet_order(options_.max_order, t_new, control_.suspected_dt(), u_new, *model_, free_);
    }
  }
  const auto is_positive = [](const Pack& x) { return max_lane(x) > 0.0; };
  if (std::any_of(made.extremes.begin() + u.n_species(), made.extremes.end(), is_positive)) agreement_.flags |= step_flags::negative;
  comm_->agree(agreement_);
  if (step.lower_factor > 0.0) errors.lower = step.lower_factor * norm(agreement_.sums[1]);
  if (step.upper_factor > 0.0) errors.upper = step.upper_factor * norm(agreement_.sums[2]);
  if (step.second_factor > 0.0) errors.second = step.second_factor * norm(agreement_.sums[2]);
  if (step.tests_order && control_.wants_quiet_order()) {
    errors.quiet_order = options_.max_order - static_cast<int>(agreement_.maxima.back());
  }
  errors.same = step.error_factor * norm(agreement_.sums[0]);
  flags = agreement_.flags;

  if (!std::isfinite(errors.same)) flags |= step_flags::not_finite;
  const bool refused = refuses(attempt, flags, u, u_new, free_, t, dt);
  attempt.error = errors.same;
  attempt.accepted = errors.same <= control_.largest_error() && !refused;
  attempted_dt_ = dt;
  if (!attempt.accepted) {
    made_count_ = 0;
    attempt.dt_next = control_.rejected(dt, errors.same);
    attempt.dt_next = std::min(attempt.dt_next, cap_step(control_.order(), attempt.dt_next));
    if (refused) {
      attempt.dt_next = std::min(attempt.dt_next, 0.5 * dt);
    } else {
      attempt.reason = fmt::format("the error estimate at order {} is {:.3g} times the tolerance", step.order, errors.same);
    }
    return attempt;
  }
  if (step.tests_order) update_tolerances(agreement_.maxima);
  bool is_limited = false;
  const bool avoided_ringing = control_.avoids_ringing();
  const auto limit = [&](int order, double wanted) {
    const double cap = cap_step(order, wanted);
    if (std::isfinite(wanted)) is_limited |= cap < 0.7 * wanted && cap < 1.2 * dt;
    return cap;
  };
  attempt.dt_next = control_.accepted(dt, errors, std::ref(limit));  // a reference needs no memory of its own
  ++accepted_;
  if (is_limited) ++limited_;
  if (control_.avoids_ringing()) {
    ++low_order_;
    if (!avoided_ringing) {
      attempt.reason = "high orders are given up for a while: a fast damped oscillation makes them unstable at this step";
    }
  }
  return attempt;
}

void Sbdf::accept(Field& u, Field& u_new) {
  newest_ = (newest_ + history_.size() - 1) % history_.size();
  swap(history_[newest_], u);  // the oldest state's storage now is in u
  swap(u, u_new);
  for (std::size_t i = steps_.size() - 1; i > 0; --i) steps_[i] = steps_[i - 1];
  steps_[0] = attempted_dt_;
  states_ = std::min(states_ + 1, history_.size() + 1);
  has_slope_ = false;
}

void Sbdf::restart(double t) {
  static_cast<void>(t);
  made_count_ = 0;
  states_ = 1;
  has_slope_ = false;
  control_.restart();
}

std::string Sbdf::closing_note() const {
  std::string note;
  if (10 * limited_ >= accepted_ && limited_ > 0) {
    note = fmt::format(
        "diffusion limited {} of {} steps: the tolerance would allow longer ones, but the sweeps they need would cost more "
        "than they save{}",
        limited_, accepted_,
        options_.max_sweeps < sbdf_max_sweeps ? fmt::format(" or are more than method.max_sweeps = {}", options_.max_sweeps)
                                              : std::string("; a coarser grid, if it resolves the solution, is the remedy"));
  }
  if (low_order_ > 0) {
    note += fmt::format("{}{} of {} steps were made at low order since a fast damped oscillation makes higher ones unstable",
                        note.empty() ? "" : "; ", low_order_, accepted_);
  }
  return note;
}

void Sbdf::visit_state(StateVisitor& visitor) {
  made_count_ = 0;
  std::vector<double> control = control_.state();
  visitor.numbers("control", control);
  control_.set_state(control);
  visitor.numbers("extremes", extremes_);
  visitor.numbers("absolute", absolute_);
  visitor.integer("states", states_);
  std::vector<double> steps(steps_.begin(), steps_.end());
  visitor.numbers("steps", steps);
  std::copy(steps.begin(), steps.end(), steps_.begin());
  for (std::size_t i = 0; i + 1 < states_; ++i) visitor.field(fmt::format("history-{}", i + 1), ring(i));
}

}  // namespace stiffront
