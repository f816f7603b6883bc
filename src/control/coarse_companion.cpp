// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/coarse_companion.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace stiffront {
namespace {

constexpr double felt_from = 0.1;        // of the budget, or
constexpr double share_felt_from = 0.5;  // of the budget's share of the time so far; but
constexpr double early_felt_from = 0.4;  // of the budget, and no rate is believed,
constexpr double early = 0.002;          // of the time: profiles adjust to the splitting, which is not the beginning of a drift
constexpr double least_rest = 0.1;       // of the budget, or of the error if that is more: what is left to spend is never taken to be less
constexpr double least_time = 0.1;   // of the whole: the time left is never taken to be less, so that the end does not bring large steps
constexpr double mark_every = 0.1;   // of the time so far
constexpr double missed_from = 1.6;  // of the budget
// Of the limit, from one step of the companion to the next: before and after it was felt for the first time, and with the budget missed. A rate that
// dips must not undo what was saved.
constexpr double early_growth = 2.0;
constexpr double growth = 1.1;
constexpr double missed_growth = 1.0;
constexpr double least_ratio = 2.0;  // of the errors: below, the difference says little

constexpr double cube(double x) { return x * x * x; }

}  // namespace

CoarseCompanion::CoarseCompanion(ReactionFlow& reaction, Flow& diffusion, SplittingOrder order, const Field& shape, double budget)
    : reaction_(&reaction),
      diffusion_(&diffusion),
      composition_(strang(order)),
      budget_(budget),
      w_(shape.similar()),
      hints_(reaction.hints().size(), 0.0),
      diffusion_state_(diffusion.state()) {}

void CoarseCompanion::begin(double t, double t_end, const Field& u, double first_step) {
  if (begun_ && t >= t_) return;
  begun_ = true;
  given_up_ = lands_ = expects_ = limited_ = false;
  pending_ = 0;
  pending_cubes_ = fine_cubes_ = coarse_cubes_ = error_ = 0.0;
  marks_ = {};
  marked_at_ = t;
  limit_ = first_step;
  w_.copy_interior(u);
  t_ = t_begin_ = t;
  t_end_ = t_end;
}

bool CoarseCompanion::expect(double c0, double dt) {
  if (expects_ || !(c0 > 0.0)) return false;
  expects_ = true;
  limit_ = std::min(limit_, std::sqrt(budget_ / (t_end_ - t_begin_) / c0));
  return dt > 2.0 * limit_;
}

void CoarseCompanion::accepted(double dt) {
  ++pending_;
  pending_cubes_ += cube(dt);
}

bool CoarseCompanion::catch_up(double t, Work& work) {
  const double dt = t - t_;
  fine_cubes_ += pending_cubes_;
  coarse_cubes_ += cube(dt);
  pending_cubes_ = 0.0;
  pending_ = 0;
  lands_ = false;
  std::swap(hints_, reaction_->hints());
  diffusion_->exchange_state(diffusion_state_);
  const bool well = !stiffront::advance({reaction_, diffusion_}, composition_, t_, dt, w_, w_, work);
  diffusion_->exchange_state(diffusion_state_);
  std::swap(hints_, reaction_->hints());
  t_ = t;
  return well;
}

double CoarseCompanion::limit_from(double rate) const {
  const double whole = t_end_ - t_begin_;
  const double share = (t_ - t_begin_) / whole;
  const double felt = budget_ * (share < early ? early_felt_from : std::max(felt_from, share_felt_from * share));
  if (!(error_ > felt && rate > 0.0)) return std::numeric_limits<double>::infinity();
  const double rest = std::max(budget_ - error_, least_rest * std::max(budget_, error_));
  return std::sqrt(rest / std::max(t_end_ - t_, least_time * whole) / rate);
}

void CoarseCompanion::learn(double difference, bool all_well, double c0) {
  if (!all_well || !std::isfinite(difference)) {
    given_up_ = true;
    return;
  }
  error_ = difference / (std::max(coarse_cubes_ / fine_cubes_, least_ratio) - 1.0);
  const double growth_seen = (error_ - marks_[0].error) / (fine_cubes_ - marks_[0].cubes);
  // What grows faster than local errors can add up is old errors. The faster, the less the step has to do with it.
  const double limit = limit_from(c0 > 0.0 && growth_seen > c0 ? c0 * c0 / growth_seen : growth_seen);
  const double factor = !limited_ ? early_growth : error_ > missed_from * budget_ ? missed_growth : growth;
  const double reach = std::min(factor * limit_, t_end_ - t_begin_);
  if (limit < reach) limited_ = true;
  limit_ = std::min(limit, reach);
  if (t_ - marked_at_ >= mark_every * (t_ - t_begin_)) {
    marks_ = {marks_[1], Mark{fine_cubes_, error_}};
    marked_at_ = t_;
  }
}

void CoarseCompanion::visit_state(StateVisitor& visitor) {
  visitor.field("companion", w_);
  visitor.cells("companion_reaction_steps", hints_);
  visitor.numbers("companion_diffusion_flow", diffusion_state_);
  visitor.integer("companion_begun", begun_);
  visitor.integer("companion_given_up", given_up_);
  visitor.integer("companion_lands", lands_);
  visitor.integer("companion_pending", pending_);
  visitor.integer("companion_expects", expects_);
  visitor.integer("companion_limited", limited_);
  double* const numbers[] = {&t_,     &t_begin_,        &t_end_,          &pending_cubes_,  &fine_cubes_,     &coarse_cubes_, &error_,
                             &limit_, &marks_[0].cubes, &marks_[0].error, &marks_[1].cubes, &marks_[1].error, &marked_at_};
  std::vector<double> values;
  for (const double* x : numbers) values.push_back(*x);
  visitor.numbers("companion_numbers", values);
  for (std::size_t i = 0; i < std::size(numbers); ++i) *numbers[i] = values.at(i);
}

}  // namespace stiffront
