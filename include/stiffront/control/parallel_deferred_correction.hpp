// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "stiffront/control/collocation.hpp"
#include "stiffront/control/method.hpp"
#include "stiffront/control/state_norm.hpp"
#include "stiffront/mesh/halo_exchange.hpp"
#include "stiffront/solvers/model_kernels.hpp"
#include "stiffront/solvers/node_sweep.hpp"
#include "stiffront/space/coupled_rhs.hpp"

namespace stiffront {

struct ParallelDeferredCorrectionOptions {
  int node_count = 4;         ///< m, 2 .. max_parallel_nodes
  double fixed_step = 0.0;    ///< 0: adaptive
  double tolerance = 0.0;     ///< of adaptive steps
  int starting_order = 3;     ///< k, 1 .. m
  int corrections = 5;        ///< sweeps; of adaptive steps, those planned: there may be twice as many
  double shift = 0.25;        ///< factor on the diagonal of the diffusion in the preconditioner
  double initial_step = 0.0;  ///< of adaptive steps; 0: from the reaction's fastest rate
  double safety = 0.9;
  double max_growth = 2.0;  ///< of adaptive steps
};

/// Spectral deferred correction on Radau nodes with a preconditioner that couples neither cells nor nodes (`sdc` with splitting "diagonal").
///
/// Start: linearly implicit BDF of order k visits the nodes one by one, with the nodes of the step before as history, each by one sweep of
/// the method sbdf without shift. Then sweeps over all nodes at a time, every one of which is one pass over the cells and one halo exchange
/// (solvers/node_sweep.hpp), with the coefficients MIN-SR-S (control/diagonal_preconditioner.hpp). The state after a step is its last node.
///
/// Of adaptive steps the change of the last node by the last sweep is the error, though it is that of the iterate before: its changes do
/// not fall evenly enough to tell the next one. The step is chosen for the planned number of sweeps; more are made while the error is above
/// the tolerance, fewer where diffusion keeps the step short. The error of the quadrature is not seen.
///
/// @mpi  one halo exchange per node of the start, one of all nodes per sweep; one agreement per step, and per sweep beyond those planned
/// @cost per node and cell: one sweep of sbdf in the start, one rate evaluation more in every sweep; 2 m + k + 2 fields
/// @see docs/sdc.md; Hagstrom & Zhou, Commun. Appl. Math. Comput. Sci. 1(1), 2006, for the start; Caklovic, Lunet, Goetschel, Ruprecht, SIAM
///      J. Sci. Comput. 47(1), 2025
class ParallelDeferredCorrection final : public Method {
 public:
  /// Largest dT rho of adaptive steps, rho being the spectral radius of the diffusion: scanned, see docs/sdc.md.
  static constexpr double stable_z = 3.2;

  /// @throws Error(input) for options out of range
  ParallelDeferredCorrection(const Field& shape, CoupledRhs& rhs, const ModelKernels& model, ParallelDeferredCorrectionOptions options);

  double first_step(double t, double t_end, Field& u) override;
  Attempt attempt(double t, double dt, Field& u, Field& u_new, std::uint64_t& flags) override;
  void accept(Field& u, Field& u_new) override;
  void restart(double t) override;
  void visit_state(StateVisitor& visitor) override;
  std::string closing_note() const override;

 private:
  std::size_t count() const { return v_.size(); }
  void start(double t, double dt, Field& u, Attempt& a);
  void sweep(double t, double dt, const Field& u, Attempt& a);
  Attempt fixed(double t, double dt, Field& u, Field& u_new, std::uint64_t& flags);
  Attempt adaptive(double t, double dt, Field& u, Field& u_new, std::uint64_t& flags);

  const Communicator* comm_;
  CoupledRhs* rhs_;
  const DiffusionOperator* diffusion_;
  const ModelKernels* model_;
  ParallelDeferredCorrectionOptions options_;
  CollocationNodes nodes_;
  std::unique_ptr<SbdfKernel> start_kernel_;
  std::unique_ptr<NodeSweepKernel> kernel_;
  NodeSweep sweep_;
  HaloExchange halo_;        ///< of one field
  HaloExchange node_halos_;  ///< of all nodes
  StateNorm norm_;
  FreeBox free_;
  std::vector<Field> v_;               ///< nodes
  std::vector<Field> next_;            ///< nodes after a sweep; in the start, scratch
  std::vector<Field> history_;         ///< nodes of the step before, from its end backwards, its end itself left out
  std::vector<double> history_times_;  ///< relative to the beginning of the present step
  double attempted_dt_ = 0.0;
  double longest_step_ = 0.0;  ///< of adaptive steps: for the stability of the diffusion
  std::int64_t accepted_ = 0;  ///< adaptive steps of this run, and those of them that were no longer for that reason
  std::int64_t limited_ = 0;
};

}  // namespace stiffront
