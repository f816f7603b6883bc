// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <functional>
#include <span>
#include <vector>

#include "stiffront/control/bdf_history.hpp"
#include "stiffront/mesh/row_ring.hpp"
#include "stiffront/solvers/sbdf_kernel.hpp"
#include "stiffront/space/diffusion_operator.hpp"

namespace stiffront {

/// A step of Sbdf in one pass over memory: predictor and right side, all sweeps and what is done with the new state
/// follow each other over the grid at the distance of a stencil, so that what one leaves the next finds in cache.
///
/// In two dimensions they go a few rows at a time and what lies between history and new state lives in rings of rows; in one
/// dimension they go piece by piece along the line. Every number is made by the same operations as in one pass per
/// sweep: the bits are the same for every depth.
class SbdfWavefront {
 public:
  struct Step {
    double t = 0.0;  ///< of the new state
    double gamma = 0.0;
    std::span<const Field* const> states;  ///< newest first
    BdfWeights predictor{};
    BdfWeights history{};
    std::span<const double> shifts;  ///< one per sweep
  };
  /// Called for boxes in which the new state is complete, with the predictor there.
  using Finished = std::function<void(const FreeBox&, const ConstRows& predictor)>;

  /// Whether boxes of this kind can be stepped so: those that need nothing from other ranks, without Dirichlet sides and,
  /// in one dimension, not periodic.
  static bool serves(const Decomposition& decomposition, const Boundary& boundary);

  /// @param max_sweeps the most sweeps of a step
  /// @param depth sweeps per pass over memory; 0: as many as the cache holds
  SbdfWavefront(const Field& shape, const DiffusionOperator& diffusion, const SbdfKernel& kernel, int max_sweeps,
                int depth = 0);

  /// @param predictor, right_side, work fields of the shape, overwritten
  void run(const Step& step, Field& predictor, Field& right_side, Field& work, Field& u_new, const Finished& finished);

 private:
  struct Pass;
  void pass_over_rows(const Step& step, const Pass& pass, const Finished& finished);
  void line(const Step& step, Field& predictor, Field& right_side, Field& work, Field& u_new, const Finished& finished);
  void fill_row_ends(const Rows& rows, int j) const;
  void mirror_row(const Rows& rows, int from, int to) const;

  const Decomposition* decomposition_;
  const DiffusionOperator* diffusion_;
  const SbdfKernel* kernel_;
  int n_species_;
  int n_x_, n_y_;
  int width_;
  bool periodic_x_, periodic_y_;
  std::ptrdiff_t row_length_;  ///< halo included
  int rows_ = 1;  ///< taken through all sweeps at a time
  int depth_;
  std::vector<RowRing> predictor_ring_;  ///< one, or none in one dimension
  std::vector<RowRing> right_side_ring_;
  std::vector<RowRing> stage_rings_;
};

}  // namespace stiffront
