// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <limits>
#include <optional>
#include <vector>

#include "stiffront/control/collocation.hpp"
#include "stiffront/control/deferred_correction_control.hpp"
#include "stiffront/control/method.hpp"
#include "stiffront/control/state_norm.hpp"
#include "stiffront/mesh/field_algebra.hpp"
#include "stiffront/space/coupled_rhs.hpp"
#include "stiffront/splitting/composition.hpp"
#include "stiffront/splitting/reaction_flow.hpp"

namespace stiffront {

/// High order by splitting and deferred corrections on the nodes of Radau IIA (method `dcs`).
///
/// Prediction (15): splitting from node to node. Correction (16): v_i <- v_{i-1} + I_i(F(v)) + S v_{i-1}^new - S v_{i-1}, where I_i is
/// the collocation quadrature between the nodes and the old S v_{i-1} is kept from the iteration before: an iteration costs
/// s - 1 splitting steps and s right-hand sides. Order min(2 s - 1, p + k); fixed point: the Radau IIA step.
///
/// The iteration is not unconditionally stable: with k >= 2 a mode of eigenvalue lambda needs |lambda| dt below stability_limit(k).
/// The spectral radius of the diffusion and a bound for the reaction's decide how many iterations an adaptive step may use; a fixed step
/// beyond the limit is an error.
/// @see Duarte & Emmett, "High order schemes based on operator splitting and deferred corrections for stiff time dependent PDEs",
///      2016, eqs. (15), (16), (43)-(47); docs/dcs.md for what was changed and why
class DeferredCorrection final : public Method {
 public:
  DeferredCorrection(const Field& shape, CoupledRhs& rhs, ReactionFlow& reaction, Flow& diffusion, DeferredCorrectionOptions options);

  double first_step(double t, double t_end, Field& u) override;
  Attempt attempt(double t, double dt, Field& u, Field& u_new, std::uint64_t& flags) override;
  void visit_state(StateVisitor& visitor) override;

  /// Largest |z|, z = lambda dt < 0, for which k corrections do not amplify a mode split exactly. k <= max(kmax, fixed iterations).
  double stability_limit(int k) const { return stability_limits_[static_cast<std::size_t>(k)]; }

  /// What an iterate tells of its own error.
  struct Estimate {
    double residual = 0.0;                                         ///< e_k
    double error = std::numeric_limits<double>::quiet_NaN();       ///< err_k by (43); NaN where r >= 1
    double step_limit = std::numeric_limits<double>::quiet_NaN();  ///< dt_max,k = 1/zeta_k; NaN for k = 0
  };
  /// The estimates of k = 0 .. most corrections of one step from u, none of them accepted or rejected: for order studies. @mpi collective.
  std::vector<Estimate> estimates(double t, double dt, Field& u, int most);

 private:
  void predict(double t, double dt, Field& u, Attempt& a);
  void evaluate_right_hand_sides(double t, double dt, Attempt& a);
  void correct(double t, double dt, const Field& u, Attempt& a);
  void quadrature_to_end(double dt, const Field& u, Field& result);
  void split(double t, double dt, Field& from, Field& to, Attempt& a);
  void add_modes(double dt, Agreement& agreement);
  double quadrature_error(double dt, const Agreement& agreement) const;
  void check_stability(double t, double dt, const Field& u) const;
  [[noreturn]] void refuse_step(double t, double dt, double rate) const;
  Attempt fixed(double t, double dt, Field& u, Field& u_new, std::uint64_t& flags);
  Attempt adaptive(double t, double dt, Field& u, Field& u_new, std::uint64_t& flags);

  const Communicator* comm_;
  CoupledRhs* rhs_;
  ReactionFlow* reaction_;
  SplitFlows flows_;
  DeferredCorrectionOptions options_;
  CollocationNodes nodes_;
  std::vector<double> stability_limits_;
  Composition composition_;
  StateNorm norm_;
  DeferredCorrectionControl control_;
  Agreement agreement_;  // of an iteration; kept, like terms_, so that the loop takes no memory
  std::vector<Term> terms_;
  FreeBox free_;
  std::vector<Field> v_;                          // stages
  std::vector<Field> f_;                          // right-hand sides at the stages
  std::vector<Field> s_;                          // s_[i]: splitting result from stage i - 1 to stage i
  std::vector<std::vector<double>> inner_steps_;  // the reaction's, cell by cell, with which the splitting step to a node begins
  std::vector<double> diffusion_at_first_;        // state of the diffusion's step control with which all of them begin
  std::vector<std::vector<double>> modes_;  // weights of the stages in the last Legendre coefficients of F: degree s - 1, s - 2, s - 3
  double quadrature_constant_;
  std::optional<Field> last_;  // adaptive: last stage of the prediction; fixed: last stage before the correction
  Work work_ahead_;            // of first_step, counted with the attempt that follows
  double rate_ = 0.0;          // bound on |lambda| of diffusion and reaction, renewed with every accepted step
};

}  // namespace stiffront
