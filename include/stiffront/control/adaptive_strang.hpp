// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <limits>
#include <optional>
#include <vector>

#include "stiffront/control/coarse_companion.hpp"
#include "stiffront/control/method.hpp"
#include "stiffront/control/state_norm.hpp"
#include "stiffront/model/reaction_term.hpp"
#include "stiffront/splitting/composition.hpp"
#include "stiffront/splitting/reaction_flow.hpp"

namespace stiffront {

/// Parameters of adaptive Strang splitting, by their names in the paper.
struct AdaptiveStrangOptions {
  double tolerance = 1e-4;       ///< eta: bound on the estimated local error in StateNorm
  double initial_step = 0.0;     ///< dt0; 0: chosen from the reaction Jacobian
  double epsilon = 0.05;         ///< shift of the embedded scheme, to begin with
  double epsilon_max = 0.49;     ///< below 1/2, so that no flow runs backwards
  bool critical_step = true;     ///< whether the critical step and epsilon are controlled (section 5)
  int period = 10;               ///< N: accepted steps between estimates of the critical step
  double safety = 0.9;           ///< upsilon, of the step size
  double critical_safety = 0.9;  ///< zeta, of the critical step
  double beta = 0.1;             ///< working region [beta dt*, gamma dt*]
  double gamma = 0.95;
  double theta = 10.0;           ///< aims at dt* = zeta theta dt when epsilon is chosen anew
  double max_growth = 5.0;       ///< of the step from one attempt to the next; the paper has no limit
  double final_error = 0.0;      ///< of the whole run, in tolerances, by a CoarseCompanion; 0: neither estimated nor kept
  double inner_tolerance = 0.0;  ///< relative, of the two flows: smaller differences of states are not taken for splitting errors
  SplittingOrder order = SplittingOrder::reaction_last;
  std::vector<int> species;  ///< those that enter the error; empty: all
};

/// What final_error should be unless told otherwise: 3, and 2 (1e-6/tolerance)^(1/3) where that is more, from 3e-7 downwards.
///
/// There the strategy lowers epsilon so that local errors are a fixed part of the tolerance and steps fall like its cube root, their sum
/// like its power 2/3. A sum that has to fall like the tolerance itself needs steps like its square root: ever more beyond those.
double default_final_error(double tolerance);

/// Strang splitting with an epsilon-shifted embedded scheme, and control of the step, of the critical step below which the
/// difference of the two overestimates the splitting error, and of epsilon.
///
/// One attempt costs 1.5 dt of the last flow and two states of the middle flow advanced together; estimating the critical step
/// adds four Strang steps over 1.5 dt in all, once every `period` accepted steps or when the strategy asks for it.
/// @see Descombes, Duarte, Dumont, Louvet & Massot, Confluentes Math. 3(3), 2011, section 5.3; docs/adaptive-strang.md
class AdaptiveStrang final : public Method {
 public:
  /// @param shape a field of the shape of the states; only its shape is used.
  AdaptiveStrang(const Field& shape, const Boundary& boundary, const ReactionTerm& model, ReactionFlow& reaction, Flow& diffusion,
                 AdaptiveStrangOptions options);

  double first_step(double t, double t_end, Field& u) override;
  Attempt attempt(double t, double dt, Field& u, Field& u_new, std::uint64_t& flags) override;
  void accept(Field& u, Field& u_new) override;
  void restart(double t) override;
  std::optional<double> final_error(double t, Field& u, Work& work) override;
  std::string closing_note() const override;
  void visit_state(StateVisitor& visitor) override;

  double epsilon() const { return epsilon_; }
  double critical_dt() const { return critical_dt_; }
  /// Estimated constants of the local errors: Strang error = c0 dt^3, distance to the embedded scheme = c_epsilon epsilon dt^2.
  double c0() const { return c0_; }
  double c_epsilon() const { return c_epsilon_; }

 private:
  enum Slot { embedded, companion, half, whole };  // norms of an attempt: |v - w|, |u - companion|, E2, E1

  double trial_step(double t, double t_end, const Field& u) const;
  void estimate_strang_error(double t, double dt, Field& u, Attempt& a, Agreement& agreement);
  void strang_and_embedded(double t, double dt, Field& u, Field& v, Attempt& a);
  void update_critical_step(double dt, double error_whole, double error_half, double& error);
  void note(std::optional<CellFailure> failure, Attempt& a) const;

  const Communicator* comm_;
  const ReactionTerm* model_;
  FreeBox free_;
  SplitFlows flows_;
  ReactionFlow* reaction_;
  AdaptiveStrangOptions options_;
  StateNorm norm_;
  Agreement agreement_;  // of an attempt; kept, so that the loop takes no memory
  Composition strang_;
  Field embedded_;                  // w
  std::optional<Field> two_steps_;  // B: only if the critical step is controlled

  std::optional<CoarseCompanion> companion_;
  double attempted_dt_ = 0.0;  // of the last attempt
  Work work_ahead_;            // of first_step, counted with the attempt that follows
  double epsilon_;
  double critical_dt_ = std::numeric_limits<double>::infinity();
  double c0_ = 0.0;
  double c_epsilon_ = 0.0;
  int accepted_ = 0;
  int estimated_at_ = -1;        // value of accepted_ at the last estimate
  bool estimate_asked_ = false;  // the paper's flag
  double refused_dt_ = 0.0;      // step of the last estimate, if it drowned in the errors of the flows
};

}  // namespace stiffront
