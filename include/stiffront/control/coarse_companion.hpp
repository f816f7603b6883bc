// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <limits>
#include <vector>

#include "stiffront/control/method.hpp"
#include "stiffront/splitting/composition.hpp"
#include "stiffront/splitting/reaction_flow.hpp"

namespace stiffront {

/// A second solution made with Strang steps that each span `stride` steps of the first: what the errors of all steps have added up to.
///
/// A bound on the error of each step says little about the error at the end. What deforms a stable wave is forgotten, what shifts its front
/// is not. Both solutions make errors of the same kind, and where a step h makes an error c h^3 theirs are in the ratio
/// R = sum H^3 / sum h^3, so that the error of the first is |u - w| / (R - 1): Richardson's extrapolation over the whole run.
///
/// The limit for the step lets the error grow towards the budget but not beyond:
///  - It begins at the step with which local errors as large as the first would add up to the budget, and doubles with each step of the
///    companion until the error has been seen to grow: early errors may grow later, and no later step undoes them.
///  - Once the error is above a tenth of the budget (later: above half of the budget's share of the time), what is left of the budget must
///    suffice for the rest of the run at the rate, per sum of h^3, at which the error has grown lately. A rate B above C0, that of local
///    errors that all add up, is growth of old errors, which is not a matter of the step: C0^2/B is taken instead. Far above the budget the limit
///    does not grow any more.
///  - In the first 1/500 of the run the error has to be above two fifths of the budget for that. There profiles adjust to the splitting: an error
///    of stiff waves that depends on the step alone, is made within a few steps and then stays would be taken for the beginning of a drift.
class CoarseCompanion {
 public:
  /// @param budget final error to be kept, in the norm of the differences given to learn().
  CoarseCompanion(ReactionFlow& reaction, Flow& diffusion, SplittingOrder order, const Field& shape, double budget);

  /// Both solutions are u at t. Ignored if a run is under way, that is, if t is not before the companion's time: a restart changes nothing for
  /// the errors made so far.
  /// @param first_step where the limit begins.
  void begin(double t, double t_end, const Field& u, double first_step);
  /// The first estimate of the constant of the local errors c0 h^3. @return whether the first step was far too long for it.
  bool expect(double c0, double dt);
  /// A step of the first solution has been accepted.
  void accepted(double dt);
  /// The data jump here: the next step must not go across.
  void land() { lands_ = true; }
  /// Whether the companion should catch up before the next step.
  bool due() const { return !given_up_ && (pending_ >= stride || (lands_ && pending_ > 0)); }
  bool behind() const { return !given_up_ && pending_ > 0; }
  /// Advances the companion to t, where the first solution is. Inner solvers' memories are kept apart, so that the first solution has the
  /// same bits with and without a companion. @return false if a cell failed on this rank. @mpi collective.
  bool catch_up(double t, Work& work);
  Field& state() { return w_; }
  /// After catch_up: the norm of the difference, and c0 as in expect(), 0 if not known. If the difference is not finite, or not all ranks were
  /// well, the companion is given up.
  void learn(double difference, bool all_well, double c0);

  bool given_up() const { return given_up_; }
  /// Error of the first solution when last learnt; 0 before.
  double error() const { return error_; }
  /// Largest step that keeps the budget; infinity if there is no need.
  double step_limit() const { return given_up_ ? std::numeric_limits<double>::infinity() : limit_; }

  void visit_state(StateVisitor& visitor);

  static constexpr int stride = 4;

 private:
  /// The sum of h^3 and the error at some time.
  struct Mark {
    double cubes = 0.0;
    double error = 0.0;
  };
  double limit_from(double rate) const;

  ReactionFlow* reaction_;
  Flow* diffusion_;
  Composition composition_;
  double budget_;
  Field w_;
  std::vector<double> hints_;  // the reaction's, of the companion's own steps
  std::vector<double> diffusion_state_;
  bool begun_ = false;
  bool given_up_ = false;
  bool lands_ = false;
  int pending_ = 0;  // steps of the first solution since the companion's last
  double t_ = 0.0;   // where the companion is
  double t_begin_ = 0.0;
  double t_end_ = 0.0;
  double pending_cubes_ = 0.0;  // sum h^3 over them
  double fine_cubes_ = 0.0;     // sum h^3
  double coarse_cubes_ = 0.0;   // sum H^3
  double error_ = 0.0;
  std::array<Mark, 2> marks_{};  // the first from a tenth to a fifth of the time so far ago
  double marked_at_ = 0.0;
  bool expects_ = false;
  bool limited_ = false;  // whether the limit has been felt
  double limit_ = std::numeric_limits<double>::infinity();
};

}  // namespace stiffront
