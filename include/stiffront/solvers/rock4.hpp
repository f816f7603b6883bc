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
/// @mpi    One halo message per neighbour and exchange, carrying all states; one exchange per `halo_depth` stages, as deep as the stencils
///         of these stages reach, whose points next to the box are computed here too; one reduction per step attempt.
/// @throws Error(bug), on every rank, for dt < 0
/// @cost   per state 4 fields of scratch memory (3 if `to` differs from `from` and one step suffices); a stage streams
/// 3 arrays
///         per variable (the last four 2, 3, 4 and 6)
/// @see    docs/rock4.md
class Rock4 final : public Flow {
 public:
  /// @pre decomposition and diffusion outlive the flow.
  /// @param halo_depth stages per exchange of halos, at most what the halos of the states and the boxes allow; 0: what a model of the cost
  ///        finds best for a step, never more than automatic_depth. Order 8 has 1. Bits do not depend on it.
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

  /// Part of the box and whether it needs the halo; any may be empty.
  struct Tiles {
    FreeBox interior;              ///< may be computed while messages travel
    std::array<FreeBox, 4> edges;  ///< the rest
  };

  void prepare(std::span<const Transition> states, double t);
  double attempt(double t, double h, Work& work);
  void accept(double time);
  void deliver(std::span<const Transition> states, double time);
  std::optional<CellFailure> fail(std::span<const Transition> states, double t, double dt, double h,
                                  const char* reason);
  Field* scratch(const Field& like);
  /// A stage reads its input around each point and other buffers at the point.
  template <class Pass>
  void stage(std::size_t input, std::initializer_list<std::size_t> others, double time, Pass&& pass);
  HaloExchange& exchange_for(int together, std::size_t n_fields);
  FreeBox extended(int by) const;
  Tiles tiles_of(const FreeBox& box) const;
  int reach() const { return (largest_depth_ - 1) * diffusion_->halo_width(); }

  const Decomposition* decomposition_;
  const DiffusionOperator* diffusion_;
  Rock4Tolerances tolerances_;
  double rho_;
  int max_stages_;
  FreeBox free_;
  double free_variables_;
  FreeBox inner_;  ///< points that need no halo, in whole packs; empty if nobody sends any
  int asked_depth_;
  std::optional<HaloCost> halo_cost_;  ///< if the depth is chosen
  int largest_depth_ = 1;  ///< that boxes and halos allow
  int depth_ = 1;          ///< of the attempt under way
  int stages_left_ = 0;
  int stages_ahead_ = 0;   ///< for which the halos at hand are deep enough
  std::int64_t exchanges_made_ = 0;
  Rock4Table table_;
  double first_step_ = 0.0;

  std::map<std::pair<int, std::size_t>, std::unique_ptr<HaloExchange>> exchanges_;  ///< by depth and number of fields
  std::deque<Field> scratch_;
  std::size_t scratch_used_ = 0;
  std::vector<Field> slope_;  ///< order 8: D Laplacian(u), for want of a fused kernel
  std::vector<Buffers> buffers_;  ///< one per state
  std::vector<Field*> exchanged_;
  std::vector<const Field*> kept_;  ///< `from` fields that must not be written
  std::size_t result_ = start;      ///< buffer that holds the result of the last attempt
};

}  // namespace stiffront
