// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/solvers/crank_nicolson.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "stiffront/core/mpi.hpp"
#include "stiffront/mesh/field_algebra.hpp"

namespace stiffront {
namespace {

constexpr int most_iterations = 100;

/// The factor on the three-point operators that puts the eigenvalues of the quotient evenly around 1: they go from 1 to 1, 4/3 and 2.134.
double balanced_factor(int order) { return order == 2 ? 1.0 : (order == 4 ? 7.0 / 6.0 : 1.567); }

ImplicitTerms terms(int order, bool transport) {
  ImplicitTerms t;
  t.reaction = false;
  t.gamma_diffusion = balanced_factor(order);
  t.gamma_advection = transport ? balanced_factor(order) : 0.0;
  return t;
}

}  // namespace

CrankNicolson::CrankNicolson(const Field& shape, CoupledRhs& rhs, double tolerance)
    : rhs_(&rhs),
      tolerance_(tolerance),
      free_(rhs.free_box()),
      part_(make_block_tridiagonal_part(shape, rhs.diffusion(), rhs.reaction(), terms(rhs.diffusion().order(), rhs.transport() != nullptr),
                                        rhs.transport())),
      start_(shape.similar()),
      base_(shape.similar()),
      slope_(shape.similar()),
      change_(shape.similar()),
      next_(shape.similar()) {}

bool CrankNicolson::solve(double t, double dt, Field& from, Field& to, Work& work) {
  const Boundary& boundary = rhs_->boundary();
  const int m = from.n_species();
  start_.copy_interior(from);
  boundary.impose(start_, t);  // in a splitting the boundary has run ahead with the other process
  rhs_->evaluate_without_rates(t, start_, slope_);
  const std::array<Term, 2> half_step{Term{1.0, &start_}, Term{0.5 * dt, &slope_}};
  combine(half_step, base_);
  next_.copy_interior(start_);
  boundary.impose(next_, t + dt);
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    rhs_->evaluate_without_rates(t + dt, next_, slope_);
    const std::array<Term, 3> residual{Term{1.0, &base_}, Term{0.5 * dt, &slope_}, Term{-1.0, &next_}};
    combine(residual, change_);
    for (int s = 0; s < m; ++s) {
      std::fill(change_.row(s, 0), change_.row(s, 0) + free_.i_begin, 0.0);
      std::fill(change_.row(s, 0) + free_.i_end, change_.row(s, 0) + change_.n_x(), 0.0);
    }
    part_->solve(t + dt, 0.5 * dt, start_, change_, work);
    const std::array<Term, 2> sum{Term{1.0, &next_}, Term{1.0, &change_}};
    combine(sum, next_);
    boundary.impose(next_, t + dt);
    work.halo_exchanges += 1;
    work.diffusion_stages += 1;

    Agreement largest(0, 2 * m);
    for (int s = 0; s < m; ++s) {
      double& change = largest.maxima[static_cast<std::size_t>(2 * s)];
      double& scale = largest.maxima[static_cast<std::size_t>(2 * s + 1)];
      for (int i = free_.i_begin; i < free_.i_end; ++i) {
        // Not a maximum of std::max, which loses what is not a number.
        const double moved = std::abs(change_.at(s, i));
        change = moved <= change ? change : moved;
        scale = std::max(scale, std::abs(next_.at(s, i)));
      }
      if (!std::isfinite(change)) change = std::numeric_limits<double>::infinity();
    }
    to.comm().agree(largest);
    bool done = true;
    for (int s = 0; s < m; ++s) {
      const double change = largest.maxima[static_cast<std::size_t>(2 * s)];
      if (!std::isfinite(change)) return false;
      done = done && change <= tolerance_ * largest.maxima[static_cast<std::size_t>(2 * s + 1)];
    }
    if (done) {
      to.copy_interior(next_);
      ++work.diffusion_steps;
      return true;
    }
  }
  return false;
}

std::optional<CellFailure> CrankNicolson::advance(double t, double dt, std::span<const Transition> states, Work& work) {
  std::optional<CellFailure> failure;
  for (const Transition& state : states) {
    if (solve(t, dt, *state.from, *state.to, work)) continue;
    if (state.from != state.to) state.to->copy_interior(*state.from);
    if (failure) continue;
    failure.emplace();
    failure->i = state.from->decomposition().offset_x();
    failure->x = state.from->decomposition().grid().position(0, failure->i);
    failure->begin = failure->t = t;
    failure->interval = dt;
    for (int s = 0; s < state.from->n_species(); ++s) failure->state.push_back(state.from->at(s, 0));
    failure->reason = "the iteration of the Crank-Nicolson step does not converge";
  }
  return failure;
}

}  // namespace stiffront
