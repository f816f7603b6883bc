// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/app/method_stack.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <variant>
#include <vector>

#include "cost_model.hpp"
#include "sdc_defaults.hpp"
#include "stiffront/control/adaptive_strang.hpp"
#include "stiffront/control/cvode.hpp"
#include "stiffront/control/deferred_correction.hpp"
#include "stiffront/control/fixed_step.hpp"
#include "stiffront/control/flow_propagator.hpp"
#include "stiffront/control/parallel_deferred_correction.hpp"
#include "stiffront/control/sbdf.hpp"
#include "stiffront/control/sbdf_tables.hpp"
#include "stiffront/control/spectral_deferred_correction.hpp"
#include "stiffront/core/error.hpp"
#include "stiffront/solvers/crank_nicolson.hpp"
#include "stiffront/solvers/cvode_cells.hpp"
#include "stiffront/solvers/rock4.hpp"
#include "stiffront/solvers/trapezoidal_cells.hpp"
#include "stiffront/splitting/timed_flow.hpp"

namespace stiffront::app {
namespace {

constexpr double no_bound = 1.0;  // on tolerances of inner solvers: what the case says
constexpr double least_inner_tolerance = 1e-14;

stiffront::SplittingOrder order_of(SplittingOrder o) {
  return o == SplittingOrder::reaction_last ? stiffront::SplittingOrder::reaction_last : stiffront::SplittingOrder::diffusion_last;
}

std::vector<int> species_indices(const std::vector<std::string>& names, const Problem& problem) {
  std::vector<int> indices;
  const std::vector<std::string>& all = problem.model->description().species;
  for (const std::string& name : names) indices.push_back(static_cast<int>(std::find(all.begin(), all.end(), name) - all.begin()));
  return indices;
}

/// Absolute tolerances of the inner solvers: the relative one times the scale of the species, but never above the relative one
/// itself, so that species with small numbers are resolved like those of order one.
std::vector<double> inner_absolute(double tolerance, const Problem& problem) {
  std::vector<double> a;
  for (double scale : problem.scales()) a.push_back(tolerance * std::min(1.0, scale));
  return a;
}

std::vector<double> per_species(const Tolerance& tolerance, const Problem& problem) {
  const std::vector<std::string>& names = problem.model->description().species;
  std::vector<double> a(names.size(), 0.0);
  if (const double* one = std::get_if<double>(&tolerance)) {
    std::fill(a.begin(), a.end(), *one);
  } else {
    for (const auto& [name, value] : std::get<NamedList<double>>(tolerance)) {
      a[static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin())] = value;
    }
  }
  return a;
}

}  // namespace

double MethodStack::make_flows(const Case& c, Problem& problem, double finest_reaction, double finest_diffusion) {
  const double reaction_tolerance = reaction_tolerance_ = std::min(c.reaction_solver.tolerance, finest_reaction);
  const double diffusion_tolerance = std::min(c.diffusion_solver.tolerance, finest_diffusion);
  CellTolerances cell{reaction_tolerance, inner_absolute(reaction_tolerance, problem)};
  std::unique_ptr<stiffront::ReactionSolver> solver;
  if (c.reaction_solver.name == ReactionSolver::radau5) {
    solver = problem.model->make_radau5(cell);
  } else if (c.reaction_solver.name == ReactionSolver::trapezoidal) {
    solver = make_trapezoidal_cells(*problem.model, cell);
  } else {
    solver = std::make_unique<CvodeCells>(*problem.model, cell);
  }
  reaction_ = std::make_unique<ReactionFlow>(problem.decomposition, problem.boundary, std::move(solver),
                                             c.reaction_solver.balance == Balance::automatic);
  if (c.diffusion_solver.name == DiffusionSolver::crank_nicolson) {
    untimed_diffusion_ = std::make_unique<CrankNicolson>(problem.state, problem.rhs, diffusion_tolerance);
  } else {
    untimed_diffusion_ = std::make_unique<Rock4>(problem.decomposition, problem.diffusion,
                                                 Rock4Tolerances{diffusion_tolerance, inner_absolute(diffusion_tolerance, problem)},
                                                 c.diffusion_solver.halo_depth);
  }
  diffusion_ = std::make_unique<TimedFlow>(*untimed_diffusion_, diffusion_seconds_);
  return std::max(reaction_tolerance, diffusion_tolerance);
}

MethodStack::MethodStack(const Case& c, Problem& problem, Purpose purpose) : purpose_(purpose) {
  if (c.space.quadrature_order.value_or(c.space.order) != c.space.order && !std::holds_alternative<DcsOptions>(c.method)) {
    throw Error(ErrorKind::input,
                fmt::format("{}: space.quadrature_order: only the method \"dcs\" has a quadrature; leave it out", c.file));
  }
  chosen_ = c.method;
  std::visit([&](const auto& options) { make(c, options, problem); }, c.method);
}

void MethodStack::make(const Case& c, const LieOptions& o, Problem& problem) {
  make_flows(c, problem, no_bound, no_bound);
  method_ = std::make_unique<FixedStep>(problem.decomposition, problem.boundary, *reaction_, *diffusion_, lie(order_of(o.order)), o.step);
}

void MethodStack::make(const Case& c, const StrangOptions& o, Problem& problem) {
  make_flows(c, problem, no_bound, no_bound);
  method_ =
      std::make_unique<FixedStep>(problem.decomposition, problem.boundary, *reaction_, *diffusion_, strang(order_of(o.order)), o.step);
}

void MethodStack::make(const Case& c, const AdaptiveStrangOptions& o, Problem& problem) {
  stiffront::AdaptiveStrangOptions a;
  a.inner_tolerance = make_flows(c, problem, 0.01 * o.tolerance, 0.01 * o.tolerance);
  a.tolerance = o.tolerance;
  a.initial_step = o.initial_step;
  a.epsilon = o.epsilon;
  a.epsilon_max = o.epsilon_max;
  a.critical_step = o.critical_step;
  a.period = o.period;
  a.safety = o.safety;
  a.critical_safety = o.critical_safety;
  a.beta = o.beta;
  a.gamma = o.gamma;
  a.theta = o.theta;
  a.max_growth = o.max_growth;
  a.final_error = o.final_error.value();
  a.order = order_of(o.order);
  a.species = species_indices(o.species, problem);
  method_ = std::make_unique<AdaptiveStrang>(problem.state, problem.boundary, *problem.model, *reaction_, *diffusion_, std::move(a));
}

void MethodStack::make(const Case& c, const DcsOptions& o, Problem& problem) {
  CoupledRhs* rhs = &problem.rhs;
  if (const int order = c.space.quadrature_order.value_or(c.space.order); order != c.space.order) {
    // The hybrid of section 6.1. Its iterates differ from the quadrature by the error in space, which no step makes small.
    if (o.tolerance) {
      throw Error(ErrorKind::input,
                  fmt::format("{}: space.quadrature_order: the error estimate of dcs would measure the difference between orders {} and {} "
                              "in space, which no step makes small; use a fixed method.step, or the same order for both",
                              c.file, c.space.order, order));
    }
    quadrature_diffusion_ = std::make_unique<DiffusionOperator>(problem.grid, problem.boundary, diffusion_coefficients(c), order);
    quadrature_rhs_ = std::make_unique<CoupledRhs>(problem.decomposition, *quadrature_diffusion_, *problem.model);
    rhs = quadrature_rhs_.get();
  }
  // The right-hand side multiplies what the diffusion's solver leaves in the fastest modes with their rates.
  const auto within = [&](double part) { return o.tolerance ? std::max(part * *o.tolerance, least_inner_tolerance) : no_bound; };
  make_flows(c, problem, within(0.01), within(1e-4));
  DeferredCorrectionOptions d;
  d.tolerance = o.tolerance.value_or(0.0);
  d.fixed_step = o.step.value_or(0.0);
  d.iterations = o.iterations.value_or(0);
  d.stages = o.stages;
  d.max_iterations = o.max_iterations.value_or(4);
  d.strang = o.splitting == Splitting::strang;
  switch (o.step_rule) {
    case StepRule::k:
      d.step_rule = DeferredCorrectionOptions::StepRule::k;
      break;
    case StepRule::kmax:
      d.step_rule = DeferredCorrectionOptions::StepRule::kmax;
      break;
    case StepRule::min:
      d.step_rule = DeferredCorrectionOptions::StepRule::min;
      break;
  }
  d.exponent =
      o.exponent == StepExponent::observed ? DeferredCorrectionOptions::Exponent::observed : DeferredCorrectionOptions::Exponent::published;
  d.safety = o.safety;
  d.predict = o.predict;
  d.initial_step = o.initial_step;
  d.refuse_unstable = purpose_ == Purpose::run;
  auto corrected = std::make_unique<DeferredCorrection>(problem.state, *rhs, *reaction_, *diffusion_, std::move(d));
  deferred_correction_ = corrected.get();
  method_ = std::move(corrected);
}

void MethodStack::make(const Case& c, const SdcOptions& given, Problem& problem) {
  SdcOptions o = given;
  complete_sdc(o, c.space.order);
  if (o.splitting == SdcSplitting::diagonal) {
    ParallelDeferredCorrectionOptions p;
    p.node_count = o.node_count;
    p.fixed_step = o.step.value_or(0.0);
    p.tolerance = o.tolerance.value_or(0.0);
    p.starting_order = *o.starting_order;
    p.corrections = *o.corrections;
    p.shift = *o.gamma_diffusion;
    p.initial_step = o.initial_step;
    method_ = std::make_unique<ParallelDeferredCorrection>(problem.state, problem.rhs, *problem.model, p);
    return;
  }
  if (composes_flows(o)) {
    const double finest = o.tolerance ? 0.01 * *o.tolerance : no_bound;
    make_flows(c, problem, finest, finest);
    propagator_ = std::make_unique<FlowPropagator>(*reaction_, *diffusion_,
                                                   o.splitting == SdcSplitting::lie ? lie(stiffront::SplittingOrder::reaction_last)
                                                                                    : strang(stiffront::SplittingOrder::reaction_last));
    method_ =
        std::make_unique<SpectralDeferredCorrection>(problem.state, problem.rhs, *propagator_, problem.model.get(), sdc_parameters(o));
    return;
  }
  ImplicitTerms terms;
  terms.gamma_diffusion = *o.gamma_diffusion;
  terms.gamma_advection = o.gamma_advection;
  if (o.splitting == SdcSplitting::imex && o.implicit == SdcImplicit::diffusion) terms.reaction = false;
  if (o.splitting == SdcSplitting::imex && o.implicit == SdcImplicit::reaction) {
    terms.gamma_diffusion = 0.0;
    terms.stiff_rates_only = true;
  }
  SdcSolver solver = o.implicit_solver;
  if (solver == SdcSolver::automatic) {
    solver = c.grid.dimension() == 1 ? SdcSolver::block_tridiagonal : SdcSolver::multigrid;
    if (!(terms.gamma_diffusion > 0.0 || terms.gamma_advection > 0.0)) solver = SdcSolver::cell_local;
  }
  switch (solver) {
    case SdcSolver::block_tridiagonal:
      implicit_part_ = make_block_tridiagonal_part(problem.state, problem.diffusion, *problem.model, terms, problem.transport.get());
      break;
    case SdcSolver::multigrid:
      implicit_part_ = make_multigrid_part(problem.state, problem.diffusion, *problem.model, terms, o.linear_tolerance);
      break;
    case SdcSolver::automatic:
    case SdcSolver::cell_local:
      implicit_part_ = make_cell_local_part(problem.state, problem.diffusion, *problem.model, terms);
      break;
  }

  method_ =
      std::make_unique<SpectralDeferredCorrection>(problem.state, problem.rhs, *implicit_part_, problem.model.get(), sdc_parameters(o));
}

void MethodStack::make(const Case&, const SbdfOptions& o, Problem& problem) {
  stiffront::SbdfOptions k;
  k.relative_tolerance = o.relative_tolerance;
  if (o.absolute_tolerance) k.absolute_tolerance = per_species(*o.absolute_tolerance, problem);
  k.max_order = o.max_order;
  k.max_sweeps = o.max_sweeps;
  k.initial_step = o.initial_step;
  method_ = std::make_unique<Sbdf>(problem.state, problem.rhs, *problem.model, std::move(k));
}

void MethodStack::make(const Case&, const CvodeOptions& o, Problem& problem) {
  stiffront::CvodeOptions k;
  k.relative_tolerance = o.relative_tolerance;
  k.absolute_tolerance = per_species(o.absolute_tolerance ? *o.absolute_tolerance : Tolerance{0.01 * o.relative_tolerance}, problem);
  k.linear_solver =
      o.linear_solver == LinearSolver::band ? stiffront::CvodeOptions::LinearSolver::band : stiffront::CvodeOptions::LinearSolver::gmres;
  method_ = std::make_unique<Cvode>(problem.state, problem.rhs, std::move(k));
}

void MethodStack::make(const Case& c, const AutoOptions& o, Problem& problem) {
  AutoChoice choice;
  if (c.space.order == 8 || problem.transport) {
    // sbdf and sdc with parallel nodes have no differences of that order, and no first derivatives.
    CvodeOptions cvode;
    cvode.relative_tolerance = 0.01 * o.tolerance;  // of a step: the run accumulates them
    cvode.linear_solver = LinearSolver::gmres;
    choice.reason = fmt::format("method auto: cvode with relative_tolerance = {:.3g}: the others have no {}", cvode.relative_tolerance,
                                problem.transport ? "first derivatives" : "differences of order 8");
    choice.method = std::move(cvode);
  } else {
    choice = choose_method(
        {o.tolerance, c.time.end - c.time.start, problem.diffusion.spectral_radius(), c.grid.dimension(), problem.model->n_species()});
  }
  choice_ = std::move(choice.reason);
  chosen_ = std::move(choice.method);
  std::visit([&](const auto& options) { make(c, options, problem); }, chosen_);
}

void MethodStack::add_seconds(PhaseSeconds& phases) const {
  phases.diffusion += diffusion_seconds_;
  if (reaction_) phases.reaction += reaction_->seconds();
}

}  // namespace stiffront::app
