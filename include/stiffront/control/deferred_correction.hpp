// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <optional>
#include <vector>

#include "stiffront/control/collocation.hpp"
#include "stiffront/control/method.hpp"
#include "stiffront/control/state_norm.hpp"
#include "stiffront/mesh/field_algebra.hpp"
#include "stiffront/space/coupled_rhs.hpp"
#include "stiffront/splitting/composition.hpp"
#include "stiffront/splitting/reaction_flow.hpp"

namespace stiffront {

/// Parameters of DC-S by the paper's symbols.
struct DeferredCorrectionOptions {
  enum class StepRule {
    k,     ///< (44): from the iterations done
    kmax,  ///< (46): as if all iterations had been done
    min,   ///< the smaller of the two
  };
  enum class Exponent {
    observed,   ///< 1/(k + p + 1), the power of the step the error has; with the rule k also the best k for its cost
    published,  ///< 1/k as in (44), 1/kmax as in (46): oscillates, see docs/dcs.md
  };

  double tolerance = 1e-4;      ///< eta; ignored with a fixed step
  double fixed_step = 0.0;      ///< if positive: this step and `iterations` corrections, no error control
  int iterations = 0;           ///< k of fixed steps
  int stages = 3;               ///< s, 2 .. 5
  int max_iterations = 4;       ///< kmax
  bool strang = false;          ///< Strang (p = 2) inside instead of Lie (p = 1); reaction last in both
  StepRule step_rule = StepRule::k;
  Exponent exponent = Exponent::observed;
  double safety = 0.9;          ///< nu
  bool predict = true;          ///< give up early when the remaining iterations cannot reach the tolerance (section 5.1)
  double initial_step = 0.0;    ///< 0: from the fastest time scale
  double max_growth = 5.0;      ///< of the step
  std::vector<int> species;     ///< in the error norm; empty: all
};

/// High order by splitting and deferred corrections on the nodes of Radau IIA (method `dcs`).
///
/// Prediction (15): splitting from node to node. Correction (16): v_i <- v_{i-1} + I_i(F(v)) + S v_{i-1}^new - S v_{i-1}, where I_i is
/// the collocation quadrature between the nodes and the old S v_{i-1} is kept from the iteration before: an iteration costs
/// s - 1 splitting steps and s right-hand sides. Order min(2 s - 1, p + k); fixed point: the Radau IIA step.
///
/// The iteration is not unconditionally stable: with k >= 2 a mode of eigenvalue lambda needs |lambda| dt below stability_limit(k).
/// The spectral radius of the diffusion and a bound for the reaction's decide how many iterations a step may use.
/// @see Duarte & Emmett, "High order schemes based on operator splitting and deferred corrections for stiff time dependent PDEs",
///      2016, eqs. (15), (16), (43)-(47); docs/dcs.md for what was changed and why
class DeferredCorrection final : public Method {
 public:
  DeferredCorrection(const Field& shape, CoupledRhs& rhs, ReactionFlow& reaction, Flow& diffusion, DeferredCorrectionOptions options);

  double first_step(double t, double t_end, Field& u) override;
  Attempt attempt(double t, double dt, Field& u, Field& u_new, std::uint64_t& flags) override;
  void visit_state(StateVisitor& visitor) override;

  /// Largest |z|, z = lambda dt < 0, for which k corrections on s = 3 nodes do not amplify a mode split exactly.
  static double stability_limit(int k);

  /// Estimates of the last attempt, one per iteration done, for order studies: err_k by (43) and dt_max,k = 1/zeta_k.
  const std::vector<double>& error_estimates() const { return error_estimates_; }
  const std::vector<double>& step_limits() const { return step_limits_; }

 private:
  void predict(double t, double dt, Field& u, Attempt& a);
  void evaluate_right_hand_sides(double t, double dt, Attempt& a);
  void correct(double t, double dt, const Field& u, Attempt& a);
  void quadrature_to_end(double dt, const Field& u, Field& result);
  void split(double t, double dt, Field& from, Field& to, Attempt& a);
  [[noreturn]] void refuse_step(double t, double dt, double rate) const;
  Attempt fixed(double t, double dt, Field& u, Field& u_new, std::uint64_t& flags);
  Attempt adaptive(double t, double dt, Field& u, Field& u_new, std::uint64_t& flags);
  int allowed_iterations(double dt) const;
  double proposed_step(int k, double dt, double error, double contraction, double zeta, double residual) const;

  const Communicator* comm_;
  CoupledRhs* rhs_;
  ReactionFlow* reaction_;
  SplitFlows flows_;
  DeferredCorrectionOptions options_;
  CollocationNodes nodes_;
  Composition composition_;
  int order_;  // p of the splitting
  StateNorm norm_;
  Agreement agreement_;        // of an iteration; kept, like terms_, so that the loop takes no memory
  std::vector<Term> terms_;
  FreeBox free_;
  std::vector<Field> v_;       // stages
  std::vector<Field> f_;       // right-hand sides at the stages
  std::vector<Field> s_;       // s_[i]: splitting result from stage i - 1 to stage i
  std::optional<Field> predicted_;  // last stage of the prediction, for the estimate
  Work work_ahead_;            // of first_step, counted with the attempt that follows
  double rate_ = 0.0;          // bound on |lambda| of diffusion and reaction, renewed with every accepted step
  int hold_ = 0;               // accepted steps in which the number of iterations is not raised
  std::vector<double> error_estimates_;
  std::vector<double> step_limits_;
};

}  // namespace stiffront
