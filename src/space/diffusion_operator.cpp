// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/space/diffusion_operator.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "stiffront/core/error.hpp"
#include "stiffront/space/centred_difference.hpp"
#include "stiffront/space/sub_cell_closure.hpp"

namespace stiffront {
namespace {

/// Two closures may not overlap.
constexpr std::int64_t fewest_uniform_points_with_sub_cells = 10;
/// The largest eigenvalue of -second_difference between sub-cells is 25.26; of one closure alone it is the same.
constexpr double radius_with_sub_cells = 25.3;

}  // namespace

DiffusionOperator::DiffusionOperator(const Grid& grid, const Boundary& boundary, std::vector<double> coefficients, int order)
    : order_(order), dimension_(grid.dimension), boundary_(&boundary), coefficients_(std::move(coefficients)) {
  if (order != 2 && order != 4 && order != 8) throw Error(ErrorKind::input, fmt::format("space.order: expected 2, 4 or 8, got {}", order));
  for (std::size_t s = 0; s < coefficients_.size(); ++s) {
    if (!(coefficients_[s] >= 0.0 && std::isfinite(coefficients_[s]))) {
      throw Error(ErrorKind::input, fmt::format("model.diffusion: expected a coefficient >= 0, got {}", coefficients_[s]));
    }
    if (coefficients_[s] > 0.0) diffusing_.push_back(static_cast<int>(s));
  }
  for (int d = 0; d < 2; ++d) {
    const auto k = static_cast<std::size_t>(d);
    for (int which = 0; which < 2 && d < dimension_; ++which) {
      const bool closed = order == 8 && boundary.side(d, which).kind == BoundaryKind::dirichlet;
      if (grid.sub_cell[k][static_cast<std::size_t>(which)] != closed) {
        throw Error(ErrorKind::input,
                    "space.order: differences of order 8, and they alone, need a grid with sub-cells at its Dirichlet sides");
      }
    }
    if (grid.has_sub_cells(d) && grid.uniform_points(d) < fewest_uniform_points_with_sub_cells) {
      throw Error(ErrorKind::input, fmt::format("grid.points: differences of order 8 between given values need {} points, got {}",
                                                fewest_uniform_points_with_sub_cells, grid.uniform_points(d)));
    }
    radius_[k] = grid.has_sub_cells(d) ? radius_with_sub_cells : second_difference_radius(order);
  }
  inverse_dx2_[0] = 1.0 / (grid.spacing(0) * grid.spacing(0));
  inverse_dx2_[1] = dimension_ == 2 ? 1.0 / (grid.spacing(1) * grid.spacing(1)) : 0.0;
}

double DiffusionOperator::spectral_radius(int species) const {
  if (radius_[0] == radius_[1]) return radius_[0] * (k_x(species) + k_y(species));
  return radius_[0] * k_x(species) + radius_[1] * k_y(species);
}

double DiffusionOperator::spectral_radius() const {
  double rho = 0.0;
  for (int s : diffusing_) rho = std::max(rho, spectral_radius(s));
  return rho;
}

int DiffusionOperator::reach() const { return order_ == 8 && boundary_->has_dirichlet() ? SubCellClosure::columns - 1 : halo_width(); }

double DiffusionOperator::diagonal() const { return second_difference_diagonal(order_); }

void DiffusionOperator::apply_of_order_8(const Field& u, Field& du, int s, const FreeBox& box) const {
  const SubCellClosure::Weights& weights = SubCellClosure::get().second;
  const Decomposition& d = u.decomposition();
  const ClosedEnds ends_x(d, 0);
  const ClosedEnds ends_y(d, 1);
  for (int j = box.j_begin; j < box.j_end; ++j) {
    double* const out = du.row(s, j);
    if (coefficient(s) == 0.0) {
      std::fill(out + box.i_begin, out + box.i_end, 0.0);
      continue;
    }
    const double* const in = u.row(s, j);
    for_each_pack(box.i_begin, box.i_end, [&](int i, int n) {
      (Pack(k_x(s)) * second_difference_of_order_8(in + i, 1, Pack::load(in + i))).store_partial(out + i, n);
    });
    ends_x.for_each(box.i_begin, box.i_end, u.n_x(), [&](int i, int row, int first, int inwards) {
      out[i] = k_x(s) * closed_difference<double>(weights, row, [&](int k) { return in[first + k * inwards]; });
    });
    if (dimension_ == 1) continue;
    const int from_lower = ends_y.row_from_lower(j);
    const int from_upper = ends_y.row_from_upper(j, u.n_y());
    for_each_pack(box.i_begin, box.i_end, [&](int i, int n) {
      const Pack along_y =
          from_lower + from_upper > 0
              ? closed_difference<Pack>(weights, from_lower + from_upper,
                                        [&](int k) { return Pack::load(u.row(s, from_lower > 0 ? k : u.n_y() - 1 - k) + i); })
              : second_difference_of_order_8(in + i, u.row_stride(), Pack::load(in + i));
      (Pack::load_partial(out + i, n) + Pack(k_y(s)) * along_y).store_partial(out + i, n);
    });
  }
}

void DiffusionOperator::apply(const Field& u, Field& du, const FreeBox& box) const {
  if (order_ == 8) {
    for (int s = 0; s < n_species(); ++s) apply_of_order_8(u, du, s, box);
    return;
  }
  dispatch([&]<int Order, int Dimension>() {
    for (int s = 0; s < n_species(); ++s) {
      const auto laplacian = stencil<Order, Dimension>(s, u);
      for (int j = box.j_begin; j < box.j_end; ++j) {
        if (coefficient(s) == 0.0) {
          // Such a species has no halo to be read, and the sign of a zero must not depend on what is there.
          std::fill(du.row(s, j) + box.i_begin, du.row(s, j) + box.i_end, 0.0);
          continue;
        }
        const double* in = u.row(s, j);
        double* out = du.row(s, j);
        for_each_pack(box.i_begin, box.i_end, [&](int i, int n) { laplacian(in + i).store_partial(out + i, n); });
      }
    }
  });
}

}  // namespace stiffront
