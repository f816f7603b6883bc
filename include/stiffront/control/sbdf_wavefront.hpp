// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <functional>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "stiffront/control/bdf_history.hpp"
#include "stiffront/mesh/halo_exchange.hpp"
#include "stiffront/mesh/row_halo.hpp"
#include "stiffront/mesh/row_ring.hpp"
#include "stiffront/mesh/wavefront.hpp"
#include "stiffront/solvers/sbdf_kernel.hpp"
#include "stiffront/space/diffusion_operator.hpp"

namespace stiffront {

/// Steps of Sbdf in one pass over memory: predictor and right side, all sweeps and what is done with the new state
/// follow each other over the grid at the distance of a stencil, so that what one leaves the next finds in cache.
///
/// In two dimensions they go a few rows at a time and what lies between history and new state lives in rings of rows; a
/// step may be followed by the next ones in the same pass, which find the history in cache. In one dimension they go piece
/// by piece along the line. Every number is made by the same operations as in one pass per sweep: the bits are the same
/// for every depth and number of steps.
///
/// Next to other ranks predictor and right side are exchanged once per step, on halos as deep as all sweeps reach, and every
/// sweep is made on a box that is smaller by a stencil than the one before: what it does beyond the rank's own box its
/// neighbour does too.
/// @mpi one halo exchange per step, where there are neighbours
class SbdfWavefront {
 public:
  /// Steps in one pass.
  static constexpr int max_steps = 3;

  struct Step {
    double t = 0.0;  ///< of the new state
    double gamma = 0.0;
    std::span<const Field* const> states;  ///< newest first; for a test one more than the predictor needs
    int points = 0;                        ///< of them for predictor and right side
    BdfWeights predictor{};
    BdfWeights history{};
    bool tests_order = false;  ///< the predictors of other orders are wanted, too
    BdfWeights lower{};
    BdfWeights upper{};
    std::span<const double> shifts;  ///< one per sweep
    Field* u_new = nullptr;
  };
  /// Called for boxes in which the new state of a step is complete, with the predictors there.
  /// @param tested whether those of other orders are among them
  using Finished = std::function<void(std::size_t step, const FreeBox& box, const BdfPredictors& predictors, bool tested)>;

  /// Whether boxes of this kind can be stepped so: all but those of a periodic direction x that is divided, where rates beyond the box
  /// would have to know that they are at the other end of the domain.
  static bool serves(const Decomposition& decomposition);

  /// @param max_sweeps the most sweeps of a step
  /// @param depth sweeps per pass over memory; 0: as many as the cache holds
  /// @param together steps per pass over memory, at most; 0: several where the history does not stay in cache
  SbdfWavefront(const Field& shape, const DiffusionOperator& diffusion, const SbdfKernel& kernel, int max_sweeps, int depth = 0,
                int together = 0);

  /// Whether steps of so many sweeps can be made: next to other ranks as many as the halos are deep.
  bool covers(int sweeps) const { return !has_neighbours_ || sweeps <= depth_; }
  bool has_neighbours() const { return has_neighbours_; }
  /// Halo that predictor and right side need.
  int halo() const { return reach_; }
  /// How many steps of so many sweeps a pass may take.
  int steps_together(int sweeps) const;
  /// Whether the predictors of other orders are made on the way of a step of so many sweeps.
  bool tests_on_the_way(int sweeps) const { return !tests_.empty() && sweeps <= depth_; }

  /// @param steps at most steps_together() of them, each one's new state the newest of the next one's states
  /// @param predictor, right_side with a halo of halo(), work a field of the shape; overwritten
  void run(std::span<const Step> steps, Field& predictor, Field& right_side, Field& work, const Finished& finished);

 private:
  /// Sweeps first .. last - 1 of a step, within a pass over memory.
  struct Leg {
    std::size_t step = 0;
    int first = 0;
    int last = 0;
    const Field* from = nullptr;  ///< the state before; nullptr: the predictor, to be made from the history
    Field* to = nullptr;
    Field* predictor = nullptr;   ///< kept here if there are several passes, else nullptr
    Field* right_side = nullptr;  ///< likewise
    bool finishes = false;
  };
  /// What lies between history and new state of a leg.
  struct Rings {
    Rings(const Field& shape, int rows, int width, int sweeps);
    RowRing predictor;
    RowRing right_side;
    std::vector<RowRing> stages;
  };
  void pass_over_rows(std::span<const Step> steps, std::span<const Leg> legs, const Field& predictor, const Field& right_side,
                      const Finished& finished);
  void line(const Step& step, Field& predictor, Field& right_side, Field& work, const Finished& finished);
  /// Rows of predictor and right side alive at a time: the last sweep reads them `sweeps` stencils behind the front, the first one two
  /// stencils, and at a side a stencil lies before it.
  static int window(int rows, int width, int sweeps) { return rows + (sweeps + 2) * width; }
  /// Where state k of a pass of so many sweeps is made.
  FreeBox box_of(int sweeps, int k) const;
  /// Whether rows beyond the box are made, where they would be those of its other end.
  bool is_unrolled() const { return periodic_y_ && !lower_ && !upper_; }
  void exchange(const Step& step, Field& predictor, Field& right_side);
  void begin_rows(const Step& step, const Leg& leg, Rings& rings, const FreeBox& box, int shift, const Field& predictor,
                  const Field& right_side);
  void copy_fixed(const ConstRows& from, const Rows& to, const FreeBox& box) const;
  void complete(const Step& step, const Field& predictor, const Rows& v, const FreeBox& box) const;

  const Decomposition* decomposition_;
  const DiffusionOperator* diffusion_;
  const SbdfKernel* kernel_;
  int n_species_;
  int n_x_, n_y_;
  int width_;
  FreeBox free_;
  RowHalo row_halo_;
  bool periodic_y_;
  std::ptrdiff_t row_bytes_ = 0;  ///< of the longest row of any rank, all species
  int rows_ = 1;                  ///< taken through all sweeps at a time
  int depth_;
  int together_;
  std::vector<WavefrontPass> passes_;                ///< of the pass over memory under way
  std::vector<std::pair<std::size_t, int>> places_;  ///< of each: the leg, and the state it makes
  std::vector<Rings> rings_;                         ///< by leg; none in one dimension
  std::vector<RowRing> tests_;                       ///< predictors of lower and upper order

  bool left_, right_, lower_, upper_;  ///< whether another rank is there
  bool has_neighbours_;
  int reach_ = 0;  ///< halo of predictor and right side
  struct Exchange {
    int sweeps;
    std::unique_ptr<HaloExchange> halos;
  };
  std::vector<Exchange> exchanges_;  ///< from the shallowest to the deepest
  std::vector<Field> line_states_;   ///< two, on a line next to others
};

}  // namespace stiffront
