// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstdint>
#include <deque>
#include <initializer_list>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "stiffront/mesh/halo_exchange.hpp"
#include "stiffront/mesh/row_halo.hpp"
#include "stiffront/mesh/wavefront.hpp"
#include "stiffront/solvers/flow.hpp"
#include "stiffront/solvers/halo_depth.hpp"
#include "stiffront/solvers/rock4_coefficients.hpp"
#include "stiffront/space/diffusion_operator.hpp"

namespace stiffront {

/// The local error of a step is at most absolute[s] + relative |u_s|, in the root mean square over the evolving points
/// of all diffusing species.
struct Rock4Tolerances {
  double relative = 1e-5;
  std::vector<double> absolute;  ///< one per species, > 0
};

/// The diffusion flow du_s/dt = D_s Laplacian(u_s) by the stabilised explicit method ROCK4, order 4.
///
/// The stages of a step follow from its length and the exact bound of the spectral radius; no estimate is involved.
/// States advanced together take the same steps, those the most demanding of them needs. Species with D = 0 are copied.
///
/// Rounding errors limit the number of stages to rock4_max_stages(relative), so the cost grows like the spectral
/// radius, no longer like its square root, when the data ask for steps beyond that: with the rates to be resolved 1e4
/// times slower than the fastest mode or more.
///
/// Dirichlet values that depend on time are taken at the times of the stages, whatever `from` holds there.
/// Several stages make one pass over memory: they follow each other over the rows at the distance of a stencil (mesh/wavefront.hpp).
///
/// @mpi    One halo message per neighbour and exchange, carrying all states; one exchange per pass, as deep as the stencils
///         of its stages reach, whose points next to the box are computed here too; one reduction per step attempt.
/// @throws Error(bug), on every rank, for dt < 0
/// @cost   per state 4 fields of scratch memory (3 if `to` differs from `from` and one step suffices); a pass streams 2 arrays
///         per variable, a stage alone 3 (the last four 2, 3, 4 and 6)
/// @see    docs/rock4.md
class Rock4 final : public Flow {
 public:
  /// @pre decomposition and diffusion outlive the flow.
  /// @param halo_depth stages per pass over memory and exchange of halos, among several ranks at most what the halos of the states and the
  ///        boxes allow; 0: as many as the cache holds, among several ranks what a model of the cost finds best for a step. Order 8 has 1.
  ///        Bits do not depend on it.
  /// @throws Error(input) for tolerances that are not positive numbers or a relative one below 1e-14
  /// @mpi    collective if halo_depth is 0
  Rock4(const Decomposition& decomposition, const DiffusionOperator& diffusion, Rock4Tolerances tolerances, int halo_depth = 1);

  /// Halos for so many stages should a state have, as far as boxes are large enough for that.
  static constexpr int automatic_depth = 8;

  using Flow::advance;
  std::optional<CellFailure> advance(double t, double dt, std::span<const Transition> states, Work& work) override;

  /// The one number that outlives a call, {first step the next call will try}; 0 before the first call.
  std::vector<double> state() const override { return {first_step_}; }
  void set_state(std::span<const double> state) override;
  void exchange_state(std::span<double> state) override { std::swap(first_step_, state[0]); }

  /// The largest step that needs no more stages than rounding errors allow.
  double largest_step() const;

 private:
  /// Which buffer of a state: where the step starts, and four to work in.
  static constexpr std::size_t start = 0;
  using Buffers = std::array<Field*, 5>;

  static constexpr std::size_t none = 5;

  /// What one stage does: it reads its input around each point and other buffers at the point.
  struct Stage {
    enum Kind { euler, recurrence, last_argument, solution };
    Kind kind = euler;
    std::size_t input = start;
    std::array<std::size_t, 2> others{none, none};
    std::size_t to = start;
    double time = 0.0;    ///< of the input
    double weight = 0.0;  ///< of the slope
    double kappa = 0.0;
  };
  struct Finish;

  void prepare(std::span<const Transition> states, double t);
  double attempt(double t, double h, Work& work);
  void accept(double time);
  void deliver(std::span<const Transition> states, double time);
  std::optional<CellFailure> fail(std::span<const Transition> states, double t, double dt, double h, const char* reason);
  Field* scratch(const Field& like);
  void plan(const Rock4Coefficients& m, const Finish& finish, double t, double h);
  int depth_of(int stages) const;
  template <class Make>
  void pass(std::span<const Stage> stages, const Make& make);
  HaloExchange& exchange_for(int together, std::size_t n_fields);
  FreeBox extended(int by) const;
  std::array<FreeBox, 4> around_inner(const FreeBox& tile) const;
  int reach() const { return alone_ ? 0 : (largest_depth_ - 1) * diffusion_->halo_width(); }

  const Decomposition* decomposition_;
  const DiffusionOperator* diffusion_;
  Rock4Tolerances tolerances_;
  double rho_;
  int max_stages_;
  bool alone_;  ///< one rank
  FreeBox free_;
  double free_variables_;
  FreeBox inner_;  ///< points that need no halo, in whole packs; empty if nobody sends any
  int asked_depth_;
  RowHalo row_halo_;
  std::optional<HaloCost> halo_cost_;  ///< if the depth is chosen, among several ranks
  int largest_depth_ = 1;              ///< that boxes and halos allow
  int depth_in_cache_;                 ///< stages per pass over memory, alone
  int rows_at_a_time_;                 ///< points on a line
  bool is_large_ = false;              ///< does not stay in cache from one stage to the next
  std::int64_t exchanges_made_ = 0;
  Rock4Table table_;
  double first_step_ = 0.0;

  std::map<std::pair<int, std::size_t>, std::unique_ptr<HaloExchange>> exchanges_;  ///< by depth and number of fields
  std::deque<Field> scratch_;
  std::size_t scratch_used_ = 0;
  std::vector<Field> slope_;   ///< order 8: D Laplacian(u), for want of a fused kernel
  std::vector<Stage> stages_;  ///< of the attempt under way
  std::vector<WavefrontPass> passes_;
  std::vector<Buffers> buffers_;  ///< one per state
  std::vector<Field*> exchanged_;
  std::vector<const Field*> kept_;  ///< `from` fields that must not be written
  std::size_t result_ = start;      ///< buffer that holds the result of the last attempt
};

}  // namespace stiffront
