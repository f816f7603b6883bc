// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "stiffront/control/bdf_control.hpp"
#include "stiffront/control/bdf_history.hpp"
#include "stiffront/control/method.hpp"
#include "stiffront/control/sbdf_tables.hpp"
#include "stiffront/control/sbdf_wavefront.hpp"
#include "stiffront/mesh/halo_exchange.hpp"
#include "stiffront/solvers/model_kernels.hpp"
#include "stiffront/solvers/plane_correction.hpp"
#include "stiffront/solvers/sbdf_kernel.hpp"
#include "stiffront/space/coupled_rhs.hpp"
#include "stiffront/space/diffusion_operator.hpp"

namespace stiffront {

struct SbdfOptions {
  double relative_tolerance = 1e-4;        ///< aimed at for the run; that of a step is less below 1e-3 (docs/sbdf.md)
  std::vector<double> absolute_tolerance;  ///< one per species, or one for all, or none: see Sbdf
  int max_order = 5;                       ///< 1 .. 5
  int max_sweeps = sbdf_max_sweeps;        ///< 1 .. sbdf_max_sweeps; steps are shortened to need no more
  double initial_step = 0.0;               ///< 0: automatic
  int wavefront_depth = 0;                 ///< sweeps per pass over memory; 0: as many as the cache holds
  int wavefront_steps = 0;                 ///< steps per pass, at most; 0: several where the history does not stay in cache
};

/// The relative tolerance of a step in a run with this one.
///
/// Tighter tolerances mean more steps, whose errors add up: the error of a run falls with the 5/6th power of that of a
/// step at order 5, and somewhat slower where the order rises too. Below 1e-3 the tolerance of a step is less by a fifth
/// power of what is asked for, which makes the errors of runs fall with the tolerance. That of a step is 3e-3 at most: with 1e-2
/// an excitable medium may turn negative by enough to be unstable there (bz does so on coarse grids).
double sbdf_step_tolerance(double relative_tolerance);

/// What a Newton iteration that couples the cells of a line costs in sweeps (measured; see docs/sbdf.md). Constants, so that the choice is the
/// same everywhere.
double sbdf_line_cost(int n_species);
/// What a step with corrections on coarser grids in two dimensions costs in sweeps, its sweeps included; infinite for more species than there are
/// corrections for.
double sbdf_plane_cost(int n_species);

/// Backward differentiation of variable order 1..5 and variable step for u' = D Laplacian(u) + rates(t, u), solved by
/// sweeps that never couple cells implicitly.
///
/// The predictor extrapolates through k+1 earlier states. Each of s sweeps evaluates the whole right-hand side at the
/// last iterate and makes one linearly implicit correction per cell, damped by a shift that stands for the diffusion
/// (solvers/sbdf_kernel.hpp); the shifts make the s sweeps a polynomial that is small on the whole spectrum of the
/// diffusion. s is the smallest number that keeps the step stable (control/sbdf_tables.hpp). In one dimension a Newton
/// iteration that couples all cells (solvers/sbdf_line.hpp) takes the place of the sweeps where these would cost more.
/// The error estimate is the difference to the predictor.
///
/// Without absolute tolerances those of a species are relative_tolerance times the largest of: a thousandth of its
/// largest modulus, a tenth of the smaller of its largest positive and negative values (a species that changes sign is
/// not resolved about zero), a millionth of the largest modulus of any species. The moduli are those of the initial and
/// of all later states.
///
/// Where a pass over memory may take several steps (control/sbdf_wavefront.hpp) the next steps are made ahead when they are
/// likely to have the same size and order. They are what those attempts will be if nothing changes, to the bit, and thrown
/// away if something does; the counts of work leave them out.
///
/// @mpi    One halo exchange per step where the wavefront serves the box, else one per sweep (diffusing species only);
/// one agreement per step attempt; the messages of BlockTridiagonal in a step that couples all cells.
/// @cost   per sweep and cell: one evaluation of rates and Jacobian, one m x m solve; 5 + max_order fields of memory, two
/// more where steps are made ahead
/// @see    docs/sbdf.md; Hagstrom & Zhou, Commun. Appl. Math. Comput. Sci. 1(1), 2006, section 5 (the splitting of the
/// Jacobian)
class Sbdf final : public Method {
 public:
  /// @param shape a field of the shape of the states
  /// @param rhs of the model; used for the first step. Must outlive the method.
  /// @throws Error(input) for options out of range
  Sbdf(const Field& shape, CoupledRhs& rhs, const ModelKernels& model, SbdfOptions options);

  double first_step(double t, double t_end, Field& u) override;
  Attempt attempt(double t, double dt, Field& u, Field& u_new, std::uint64_t& flags) override;
  void accept(Field& u, Field& u_new) override;
  void restart(double t) override;
  void visit_state(StateVisitor& visitor) override;
  std::string closing_note() const override;

  int order() const { return control_.order(); }

 private:
  /// What a step is made of, fixed before the first sweep.
  struct Step {
    int order = 1;
    int sweeps = 1;          ///< 0: Newton iterations on the line, corrections on coarser grids in the plane
    std::size_t points = 1;  ///< of the predictor
    double gamma = 0.0;
    double error_factor = 0.0;  ///< local error per difference to the predictor
    BdfWeights predictor{};
    BdfWeights history{};
    bool tests_order = false;
    double lower_factor = 0.0;
    double upper_factor = 0.0;
    double second_factor = 0.0;  ///< of order 2, whose predictor then is in the place of the upper one
    BdfWeights lower{};
    BdfWeights upper{};

    bool operator==(const Step&) const = default;
  };
  /// A step that was made: its new state is in place, what it needs to be judged here.
  struct Made {
    double t = 0.0;
    double dt = 0.0;
    Step step;
    std::array<ReproducibleSum, 3> sums;  ///< of squared errors: at the step's own order, the lower and the upper
    std::vector<Pack> extremes;           ///< largest v_s and then largest -v_s, by lanes
  };

  /// How a step deals with diffusion, and at what price in sweeps.
  struct Treatment {
    int sweeps = 0;  ///< 0: Newton iterations on the line, corrections on coarser grids in the plane
    double cost = 0.0;
  };
  Treatment treatment(int order, double dt) const;
  double cap_step(int order, double dt) const;
  /// The step of this size after `ahead` more of the same.
  Step plan(double dt, int ahead = 0) const;
  void ensure_slope(double t, Field& u);
  void update_tolerances(std::span<const double> extremes);
  double norm(const ReproducibleSum& sum) const;
  /// Of the combination of states less u, in the norm of the error test at u. @mpi collective
  double scaled_norm(const Field& u, std::span<const Field* const> states, const BdfWeights& weights);
  /// Makes the new state, and likely next ones, and adds up their errors.
  void make_steps(double t, double dt, const Step& step, const Field& u, Field& u_new);
  bool is_in_wavefront(const Step& step) const { return wavefront_ && step.sweeps > 0 && wavefront_->covers(step.sweeps); }
  /// The step, if it was made ahead.
  bool take_made(double t, double dt, const Step& step, Field& u_new);
  void make_by_sweeps(const Made& made, std::span<const Field* const> states, Field& u_new);
  void add_errors(Made& made, const Field& u_new, const BdfPredictors& predictors, bool tested, const FreeBox& box);
  std::span<const double> shifts_of(const Step& step) const;
  void sweep(const Step& step, double t_new, const Field& v, Field& out, double shift);
  void correct_plane(const Step& step, double t_new, Field& v, bool is_first);
  void count_work(const Step& step, Work& work) const;
  void iterate_line(const Step& step, double t_new, const Field& v, Field& out, double c);
  Field& ring(std::size_t i) { return history_[(newest_ + i) % history_.size()]; }
  const Field& ring(std::size_t i) const { return history_[(newest_ + i) % history_.size()]; }

  CoupledRhs* rhs_;
  const DiffusionOperator* diffusion_;
  const Communicator* comm_;
  SbdfOptions options_;
  const ModelKernels* model_;
  std::unique_ptr<SbdfKernel> kernel_;
  std::unique_ptr<SbdfLine> line_;  ///< these three are made when they are first needed
  std::unique_ptr<SbdfEquations> equations_;
  std::unique_ptr<PlaneCorrection> plane_;
  HaloExchange halo_;
  FreeBox free_;
  FreeBox interior_;
  std::vector<FreeBox> edges_;
  bool has_neighbours_;
  double cells_;  ///< evolving points of the whole grid
  /// Longest step by order and place among the numbers of sweeps; infinite where nothing diffuses.
  std::array<std::array<double, sbdf_sweep_counts.size()>, sbdf_max_order + 1> longest_steps_{};
  /// Longest step worth its sweeps, by order.
  std::array<double, sbdf_max_order + 1> economic_steps_{};

  BdfControl control_;
  std::vector<double> extremes_;  ///< largest values of each species so far, then largest negative ones
  std::vector<double> absolute_;

  std::vector<Field> history_;  ///< ring of the states before u, newest first from newest_
  std::size_t newest_ = 0;
  std::size_t states_ = 1;                      ///< states known, u included
  std::array<double, bdf_max_points> steps_{};  ///< steps_[i]: from state i+1 to state i, u being state 0
  bool has_slope_ = false;                      ///< states_ is 1 and the newest ring entry holds F(t, u)
  Field predictor_;
  Field right_side_;
  Field work_;

  std::optional<SbdfWavefront> wavefront_;           ///< where the box is served by one
  std::array<Made, SbdfWavefront::max_steps> made_;  ///< the step attempted and those made ahead
  std::vector<Field> ahead_;                         ///< states of those made ahead; none where none are
  std::size_t made_count_ = 0;                       ///< steps made at once
  std::size_t next_made_ = 0;                        ///< the first of them not attempted yet
  Agreement agreement_;
  double attempted_dt_ = 0.0;

  std::int64_t accepted_ = 0;  ///< steps of this run, and those of them that diffusion kept from being longer
  std::int64_t limited_ = 0;
  std::int64_t low_order_ = 0;  ///< made at low order since higher ones would have rung
};

}  // namespace stiffront
