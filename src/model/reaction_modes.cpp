// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/model/reaction_modes.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

// g++ 12 warns inside Eigen's AVX-512 code; the matrices here are tiny.
#ifndef EIGEN_DONT_VECTORIZE
#define EIGEN_DONT_VECTORIZE
#endif
#include <Eigen/Eigenvalues>

namespace stiffront {

void look_at_reaction_modes(const ReactionTerm& model, double t, const Field& u, const FreeBox& box, std::int64_t at_most,
                            const std::function<bool(int, int, std::span<const std::complex<double>>)>& f) {
  const Decomposition& d = u.decomposition();
  const Grid& grid = d.grid();
  const int m = u.n_species();
  const std::int64_t stride = (grid.total_points() + at_most - 1) / at_most;
  std::vector<double> cell(static_cast<std::size_t>(m));
  std::vector<double> entries(static_cast<std::size_t>(m) * static_cast<std::size_t>(m));
  Eigen::MatrixXd jacobian(m, m);
  Eigen::EigenSolver<Eigen::MatrixXd> solver(m);
  for (int j = box.j_begin; j < box.j_end; ++j) {
    for (int i = box.i_begin; i < box.i_end; ++i) {
      // 31: so that the chosen points of neighbouring rows are not below each other.
      if ((d.offset_x() + i + 31 * (d.offset_y() + j)) % stride != 0) continue;
      for (int s = 0; s < m; ++s) cell[static_cast<std::size_t>(s)] = u.at(s, i, j);
      model.jacobian_at(t, grid.position(0, d.offset_x() + i), grid.dimension == 2 ? grid.position(1, d.offset_y() + j) : 0.0, cell.data(),
                        entries.data());
      if (!std::all_of(entries.begin(), entries.end(), [](double x) { return std::isfinite(x); })) {
        if (!f(i, j, {})) return;
        continue;
      }
      for (int r = 0; r < m; ++r) {
        for (int q = 0; q < m; ++q) jacobian(r, q) = entries[static_cast<std::size_t>(r * m + q)];
      }
      solver.compute(jacobian, false);
      if (solver.info() != Eigen::Success) continue;
      if (!f(i, j, {solver.eigenvalues().data(), static_cast<std::size_t>(m)})) return;
    }
  }
}

}  // namespace stiffront
