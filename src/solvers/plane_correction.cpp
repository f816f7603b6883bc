// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/solvers/plane_correction.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "plane_level.hpp"
#include "species_count.hpp"

namespace stiffront {
namespace {

// A grid on which the coupling is this weak needs no coarser one: three cell-Jacobi steps do.
constexpr double weak_coupling = 0.25;

// Steps on coarser grids damp modes smoother than they must, too.
constexpr double part_on_coarser = 0.8;

/// Numbers of sweeps and steps, found by the analysis that docs/sbdf-stability.md describes.
struct Smoothing {
  std::array<int, PlaneCorrection::groups> sweeps;  ///< on the finest grid
  int before, after;                                ///< the correction on a coarser one
};
/// @param rough the smallest part of the spectral radius that belongs to a mode which the next coarser grid cannot hold
Smoothing smoothing(double rough) {
  if (rough > 0.23) return {{2, 3, 2}, 2, 2};
  if (rough > 0.15) return {{3, 4, 3}, 3, 3};
  return {{4, 5, 4}, 3, 3};
}

/// The smallest part of the spectral radius of a mode that is rough in a direction coarsened.
double rough_part(const CoarseGrid& fine, const CoarseGrid& coarse, double k_x, double k_y) {
  const double x = k_x * fine.x().coupling();
  const double y = k_y * fine.y().coupling();
  double least = 1.0;
  if (coarse.x().n() < fine.x().n()) least = std::min(least, 0.5 * x / (x + y));
  if (coarse.y().n() < fine.y().n()) least = std::min(least, 0.5 * y / (x + y));
  return least;
}

/// Zeros of the Chebyshev polynomial of degree n for [from, 1], the largest first.
std::vector<double> zeros(double from, int n) {
  std::vector<double> all;
  for (int i = 0; i < n; ++i) all.push_back(0.5 * (1.0 + from) + 0.5 * (1.0 - from) * std::cos((2 * i + 1) * std::numbers::pi / (2 * n)));
  return all;
}

template <int m>
class Correction final : public PlaneCorrection {
 public:
  Correction(const Field& shape, const DiffusionOperator& diffusion) : diffusion_(&diffusion), residual_(shape.decomposition(), m, 1) {
    int leading = 0;
    for (int s = 1; s < m; ++s) {
      if (diffusion.coefficient(s) > diffusion.coefficient(leading)) leading = s;
    }
    const double k_x = diffusion.k_x(leading);
    const double k_y = diffusion.k_y(leading);
    const Decomposition& d = shape.decomposition();
    grids_ = coarse_grids(d, diffusion.boundary(), k_x, k_y);
    const double rough = grids_.size() > 1 ? rough_part(grids_[0], grids_[1], k_x, k_y) : 1.0;
    const Smoothing finest = smoothing(rough);
    share_out(zeros(rough, finest.sweeps[0] + finest.sweeps[1] + finest.sweeps[2]), finest.sweeps);
    transfer_.emplace(grids_[0]);
    halo_.emplace(d, grids_[0], m);
    levels_.reserve(grids_.size());
    for (std::size_t l = 1; l < grids_.size(); ++l) {
      levels_.emplace_back(d, grids_[l], nullptr);
      Weights& weights = weights_.emplace_back();
      if (l + 1 == grids_.size()) break;
      const double rough_here = rough_part(grids_[l], grids_[l + 1], k_x, k_y);
      const Smoothing here = smoothing(rough_here);
      const std::vector<double> all = zeros(part_on_coarser * rough_here, here.before + here.after);
      // The matrix in units of its cell blocks has twice the part of the spectral radius as its eigenvalue.
      for (std::size_t i = 0; i < all.size(); ++i) (i % 2 == 0 ? weights.before : weights.after).push_back(0.5 / all[i]);
    }
    if (levels_.empty()) return;
    const auto centres = [&](int direction) {
      const auto [first, last] = transfer_->coarse_part(direction);
      const auto axis = static_cast<std::size_t>(direction);
      std::vector<int> local;
      for (int c = first; c < last; ++c) local.push_back(grids_[0].lines[axis].centre[static_cast<std::size_t>(c)] - grids_[0].begin[axis]);
      return std::pair(first, local);
    };
    std::tie(first_column_, columns_) = centres(0);
    std::tie(first_row_, rows_) = centres(1);
  }

  std::span<const double> shifts(std::size_t group) const override { return shifts_[group]; }

  void prepare(const SbdfEquations& equations, const SbdfSweep& sweep) override {
    if (levels_.empty()) return;
    PlaneView jacobian = levels_[0].jacobian();
    const CoarseGrid& first = grids_[1];
    PlaneView mine = jacobian;
    mine.first = jacobian.row(0, first_row_ - first.begin[1]) + (first_column_ - first.begin[0]);
    equations.jacobian(sweep, columns_, rows_, mine);
    if (!first.contributions.empty()) levels_[0].gather(jacobian, m * m);
    double k_x[m];
    double k_y[m];
    for (int s = 0; s < m; ++s) k_x[s] = sweep.gamma * diffusion_->k_x(s), k_y[s] = sweep.gamma * diffusion_->k_y(s);
    levels_[0].set_matrix(sweep.gamma, k_x, k_y);
    n_levels_ = 1;
    while (levels_[n_levels_ - 1].coupling() > weak_coupling && n_levels_ < levels_.size()) {
      PlaneLevel<m>& fine = levels_[n_levels_ - 1];
      PlaneLevel<m>& coarse = levels_[n_levels_];
      fine.exchange(fine.jacobian(), m * m);
      fine.restrict_to(coarse, fine.jacobian(), coarse.jacobian(), m * m);
      if (!coarse.grid().contributions.empty()) coarse.gather(coarse.jacobian(), m * m);
      coarse.set_matrix(sweep.gamma, k_x, k_y);
      ++n_levels_;
    }
  }

  void correct(const SbdfEquations& equations, const SbdfSweep& sweep, Field& v) override {
    if (levels_.empty()) return;
    SbdfSweep into_residual = sweep;
    into_residual.out = rows_of(residual_);
    equations.residual(*diffusion_, into_residual, grids_[0].free);
    PlaneLevel<m>& coarse = levels_[0];
    halo_->exchange(view(residual_), m);
    transfer_->restrict_to(coarse.grid(), view(residual_), coarse.b, m);
    if (!coarse.grid().contributions.empty()) coarse.gather(coarse.b, m);
    cycle(0);
    coarse.exchange(coarse.x, m);
    transfer_->add_from(coarse.grid(), coarse.x, view(v), m);
  }

 private:
  struct Weights {
    std::vector<double> before, after;
  };

  /// Every group gets large and small ones.
  void share_out(const std::vector<double>& zeros, const std::array<int, groups>& sizes) {
    std::array<double, groups> due{};
    for (double zero : zeros) {
      std::size_t next = groups;
      for (std::size_t g = 0; g < groups; ++g) {
        due[g] += static_cast<double>(sizes[g]) / static_cast<double>(zeros.size());
        if (shifts_[g].size() == static_cast<std::size_t>(sizes[g])) continue;
        if (next == groups || due[g] > due[next] + 1e-9) next = g;
      }
      shifts_[next].push_back(2.0 * zero);
      due[next] -= 1.0;
    }
  }

  /// A V-cycle on coarser grid l + 1 for its right side, from zero.
  void cycle(std::size_t l) {
    PlaneLevel<m>& level = levels_[l];
    if (l + 1 == n_levels_) {
      level.begin(1.0);
      if (level.coupling() > 0.0) level.smooth(1.0), level.smooth(1.0);
      return;
    }
    PlaneLevel<m>& coarse = levels_[l + 1];
    const Weights& weights = weights_[l];
    level.begin(weights.before[0]);
    for (std::size_t i = 1; i < weights.before.size(); ++i) level.smooth(weights.before[i]);
    level.exchange(level.x, m);
    level.residual(level.b, level.x, level.r);
    level.exchange(level.r, m);
    level.restrict_to(coarse, level.r, coarse.b, m);
    if (!coarse.grid().contributions.empty()) coarse.gather(coarse.b, m);
    cycle(l + 1);
    coarse.exchange(coarse.x, m);
    level.add_from(coarse);
    for (double weight : weights.after) level.smooth(weight);
  }

  const DiffusionOperator* diffusion_;
  Field residual_;
  std::vector<CoarseGrid> grids_;
  std::optional<PlaneTransfer> transfer_;  // of the finest grid
  std::optional<PlaneExchange> halo_;      // of the residual
  std::vector<PlaneLevel<m>> levels_;      // without the finest
  std::vector<Weights> weights_;           // of every level
  std::size_t n_levels_ = 1;
  std::array<std::vector<double>, groups> shifts_;
  std::vector<int> columns_, rows_;  // of this rank's points of the first coarser grid
  int first_column_ = 0;
  int first_row_ = 0;
};

}  // namespace

std::unique_ptr<PlaneCorrection> make_plane_correction(const Field& shape, const DiffusionOperator& diffusion) {
  return for_species_count<std::unique_ptr<PlaneCorrection>>(shape.n_species(),
                                                             [&]<int m>() { return std::make_unique<Correction<m>>(shape, diffusion); });
}

}  // namespace stiffront
