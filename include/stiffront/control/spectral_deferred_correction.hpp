// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "stiffront/control/collocation.hpp"
#include "stiffront/control/method.hpp"
#include "stiffront/control/state_norm.hpp"
#include "stiffront/control/sweep_acceleration.hpp"
#include "stiffront/mesh/field_algebra.hpp"
#include "stiffront/solvers/implicit_part.hpp"
#include "stiffront/space/right_hand_side.hpp"

namespace stiffront {

/// Parameters of SDC by the paper's symbols.
struct SpectralDeferredCorrectionOptions {
  enum class Correction {
    standard,     ///< (2-12)-(2-14)
    alternative,  ///< (2-16)-(2-18): only where its fixed point is the collocation solution, see the constructor
  };
  enum class FinalUpdate {
    automatic,      ///< the last node if it is the end of the step, quadrature otherwise
    last_node,      ///< order min(k + L, q)
    quadrature,     ///< (2-15), order min(k + L + 1, q)
    extrapolation,  ///< (3-27), order min(k + L, q); the last node if that is the end of the step
  };

  NodeFamily nodes = NodeFamily::gauss_radau;
  int node_count = 4;       ///< m, 2 .. 10
  double fixed_step = 0.0;  ///< Delta T; 0: adaptive
  double tolerance = 0.0;   ///< of adaptive steps
  int starting_order = 2;   ///< k, 1 .. m (Lobatto: m - 1)
  int corrections = 5;      ///< L; of adaptive steps, the most
  bool consistent = true;   ///< corrections repeat the explicit part
  Correction correction = Correction::standard;
  FinalUpdate final_update = FinalUpdate::automatic;
  bool accelerate = false;    ///< corrections by nonlinear GMRES
  double initial_step = 0.0;  ///< of adaptive steps; 0: from the reaction's fastest rate
  double safety = 0.9;
  double max_growth = 2.0;  ///< of adaptive steps
};

/// Any method of low order that goes from a state to one a little later, as start and as correction of SDC.
class StepPropagator {
 public:
  virtual ~StepPropagator() = default;
  /// from keeps its interior. A failure of this rank goes into the attempt. @mpi collective
  virtual void advance(double t, double h, Field& from, Field& to, Attempt& a) = 0;
  virtual void visit_state(StateVisitor& visitor) = 0;
};

/// Spectral deferred correction of a linearly implicit splitting F(v) = -P v + (F(v) + P v) (method `sdc`).
///
/// A step from T to T + dT: IMEX backward differentiation of order k visits the m nodes, with the stages of the step before as history;
/// then L sweeps (2-12) correct all nodes towards the collocation solution, whose order q is 2m (Legendre), 2m - 1 (Radau) or 2m - 2
/// (Lobatto). In the form used here, with rho_i = dT sum_a (S_i - S_{i-1})_a F(v_a) - (v_i - v_{i-1}) and the change delta of a node,
///
///     (1 + h_i P) (delta_i - delta_{i-1}) = rho_i + h_i (F(v_{i-1}^new) - F(v_{i-1}))      consistent
///     (1 + h_i P) delta_i = delta_{i-1} + rho_i                                           inconsistent
///
/// so that P itself is never applied. P is taken at the newest state known: the left node's, after its correction. The first step has no
/// history: the order rises from 1 to k over its nodes and k - 1 more sweeps make up for it.
///
/// With a propagator S^h instead of the splitting, a composition of flows for one, the start is v_i = S^h v_{i-1} and a sweep
///
///     v_i^new = S^h v_{i-1}^new - S^h v_{i-1} + v_{i-1} + dT sum_a (S_i - S_{i-1})_a F(v_a),
///
/// that of Duarte & Emmett (2016) on any nodes; S^h v_{i-1} is kept from the sweep before.
///
/// Adaptive steps take the residual of the last node, |v(T) + dT sum_a S_ma F(v_a) - v_m| in the norm of StateNorm, for the error, stop
/// the sweeps when it is below the tolerance, and choose the next step for the number of sweeps that goes farthest for its cost.
///
/// @mpi  one halo exchange per right-hand side, and what P needs; one agreement per step, or per sweep with a tolerance
/// @cost m (L + 1) right-hand sides and solves per step; 3 m + 2 (k - 1) + 5 fields
/// @see  Hagstrom & Zhou, "On the spectral deferred correction of splitting methods for initial value problems", Commun. Appl. Math.
///       Comput. Sci. 1(1), 2006; docs/sdc.md
class SpectralDeferredCorrection final : public Method {
 public:
  /// @param reaction bounds the rates for the first adaptive step; may be null if there is an initial step
  /// @throws Error(input) for options out of range, and for the alternative correction unless the starting method is the correction
  ///         method (order 1, consistent, no acceleration)
  SpectralDeferredCorrection(const Field& shape, RightHandSide& rhs, ImplicitPart& implicit, const ReactionTerm* reaction,
                             SpectralDeferredCorrectionOptions options);
  /// With a propagator of order options.starting_order.
  SpectralDeferredCorrection(const Field& shape, RightHandSide& rhs, StepPropagator& propagator, const ReactionTerm* reaction,
                             SpectralDeferredCorrectionOptions options);

  double first_step(double t, double t_end, Field& u) override;
  Attempt attempt(double t, double dt, Field& u, Field& u_new, std::uint64_t& flags) override;
  void accept(Field& u, Field& u_new) override;
  void restart(double t) override;
  void visit_state(StateVisitor& visitor) override;
  std::string closing_note() const override { return implicit_ != nullptr ? implicit_->closing_note() : std::string(); }

  /// Right-hand sides evaluated since construction.
  std::int64_t evaluations() const { return evaluations_; }

 private:
  SpectralDeferredCorrection(const Field& shape, RightHandSide& rhs, ImplicitPart* implicit, StepPropagator* propagator,
                             const ReactionTerm* reaction, SpectralDeferredCorrectionOptions options);
  std::size_t count() const { return static_cast<std::size_t>(nodes_.size()); }
  double node(std::size_t i) const { return nodes_.c[i]; }
  std::size_t first_moving() const { return nodes_.starts_at_zero() ? 1 : 0; }
  void evaluate(double t, Field& u, Field& f, Attempt& a);
  void ensure_slope(double t, Field& u, Attempt& a);
  void start(double t, double dt, Field& u, Attempt& a);
  void start_node(std::size_t i, double t, double dt, Field& u, Attempt& a);
  void residual_increments(double dt, const Field& u);
  void sweep(double t, double dt, Field& u, bool last, Attempt& a);
  void propagate(std::size_t i, double t, double dt, Field& u, Attempt& a);
  void start_by_propagation(double t, double dt, Field& u, Attempt& a);
  void propagated_sweep(double t, double dt, Field& u, Attempt& a);
  void alternative_sweep(double t, double dt, Field& u, Attempt& a);
  void accelerated_sweep(double t, double dt, Field& u, Attempt& a);
  void finish(double t, double dt, const Field& u, Field& u_new);
  void integrate(const std::vector<double>& weights, double dt, const Field& u, Field& result) const;
  void zero_fixed_points(Field& f) const;
  Attempt fixed(double t, double dt, Field& u, Field& u_new, std::uint64_t& flags);
  Attempt adaptive(double t, double dt, Field& u, Field& u_new, std::uint64_t& flags);
  double proposed_step(double dt, const std::vector<double>& residuals) const;

  const Communicator* comm_;
  RightHandSide* rhs_;
  ImplicitPart* implicit_;  // or
  StepPropagator* propagator_;
  const ReactionTerm* reaction_;
  SpectralDeferredCorrectionOptions options_;
  CollocationNodes nodes_;
  std::vector<double> end_weights_;  // of v(T) and the stages, for extrapolation to the end
  StateNorm norm_;
  FreeBox free_;
  std::vector<Field> v_;    // stages
  std::vector<Field> f_;    // right-hand sides at the stages
  std::vector<Field> rho_;  // residual increments
  Field f0_;                // right-hand side at the beginning of the step
  Field work_;
  Field delta_;
  std::vector<Field> propagated_;   // S^h of the left neighbours, with a propagator
  std::vector<Field> provisional_;  // of the alternative correction
  std::vector<Field> history_v_;    // stages of the step before, from its end backwards, its end itself left out
  std::vector<Field> history_f_;
  std::vector<double> history_times_;  // relative to the beginning of the present step
  std::optional<SweepAcceleration> acceleration_;
  std::vector<Field> before_;  // of an accelerated sweep
  bool has_slope_ = false;
  bool has_end_slope_ = false;  // f_.back() is the right-hand side at the end of the attempt
  double attempted_dt_ = 0.0;
  std::int64_t evaluations_ = 0;
};

}  // namespace stiffront
