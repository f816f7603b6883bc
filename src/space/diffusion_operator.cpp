// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/space/diffusion_operator.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "stiffront/core/error.hpp"

namespace stiffront {

DiffusionOperator::DiffusionOperator(const Grid& grid, const Boundary& boundary, std::vector<double> coefficients, int order)
    : order_(order), dimension_(grid.dimension), boundary_(&boundary), coefficients_(std::move(coefficients)) {
  if (order != 2 && order != 4) throw Error(ErrorKind::input, fmt::format("space.order: expected 2 or 4, got {}", order));
  for (std::size_t s = 0; s < coefficients_.size(); ++s) {
    if (!(coefficients_[s] >= 0.0 && std::isfinite(coefficients_[s]))) {
      throw Error(ErrorKind::input, fmt::format("model.diffusion: expected a coefficient >= 0, got {}", coefficients_[s]));
    }
    if (coefficients_[s] > 0.0) diffusing_.push_back(static_cast<int>(s));
  }
  inverse_dx2_[0] = 1.0 / (grid.spacing(0) * grid.spacing(0));
  inverse_dx2_[1] = dimension_ == 2 ? 1.0 / (grid.spacing(1) * grid.spacing(1)) : 0.0;
}

double DiffusionOperator::spectral_radius(int species) const {
  return second_difference_radius(order_) * (k_x(species) + k_y(species));
}

double DiffusionOperator::spectral_radius() const {
  double rho = 0.0;
  for (int s : diffusing_) rho = std::max(rho, spectral_radius(s));
  return rho;
}

void DiffusionOperator::apply(const Field& u, Field& du, const FreeBox& box) const {
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
