// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/bdf_ringing.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

// g++ 12 warns inside Eigen's AVX-512 code; the matrices here are tiny.
#ifndef EIGEN_DONT_VECTORIZE
#define EIGEN_DONT_VECTORIZE
#endif
#include <Eigen/Eigenvalues>

#include "stiffront/control/sbdf_stability.hpp"

namespace stiffront {

bool bdf_rings(int order, std::complex<double> step_lambda) {
  if (!(step_lambda.real() < 0.0)) return false;
  const auto weights = sbdf_stability::constant_step_weights(order);
  const std::complex<double> solved_exactly = 0.0;
  return !sbdf_stability::roots_within(sbdf_stability::recursion(weights, solved_exactly, -weights.gamma * step_lambda),
                                       1.002);
}

int highest_quiet_order(int max_order, double t, double dt, const Field& u, const ReactionTerm& model,
                        const FreeBox& box) {
  const Decomposition& d = u.decomposition();
  const Grid& grid = d.grid();
  const int m = u.n_species();
  const std::int64_t stride = (grid.total_points() + 1023) / 1024;
  int quiet = max_order;
  std::vector<double> cell(static_cast<std::size_t>(m));
  std::vector<double> entries(static_cast<std::size_t>(m) * static_cast<std::size_t>(m));
  Eigen::MatrixXd jacobian(m, m);
  Eigen::EigenSolver<Eigen::MatrixXd> solver(m);
  for (int j = box.j_begin; j < box.j_end; ++j) {
    for (int i = box.i_begin; i < box.i_end && quiet > 2; ++i) {
      // 31: so that the chosen points of neighbouring rows are not below each other.
      if ((d.offset_x() + i + 31 * (d.offset_y() + j)) % stride != 0) continue;
      for (int s = 0; s < m; ++s) cell[static_cast<std::size_t>(s)] = u.at(s, i, j);
      model.jacobian_at(t, grid.position(0, d.offset_x() + i),
                        grid.dimension == 2 ? grid.position(1, d.offset_y() + j) : 0.0, cell.data(), entries.data());
      if (!std::all_of(entries.begin(), entries.end(), [](double x) { return std::isfinite(x); })) continue;
      for (int r = 0; r < m; ++r) {
        for (int q = 0; q < m; ++q) jacobian(r, q) = entries[static_cast<std::size_t>(r * m + q)];
      }
      solver.compute(jacobian, false);
      if (solver.info() != Eigen::Success) continue;
      for (const std::complex<double>& lambda : solver.eigenvalues()) {
        if (!(lambda.imag() > 0.0)) continue;
        while (quiet > 2 && (bdf_rings(quiet, dt * lambda) || bdf_rings(quiet, 1.5 * dt * lambda))) --quiet;
      }
    }
  }
  return quiet;
}

}  // namespace stiffront
