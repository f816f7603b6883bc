// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/SparseCore>
#include <vector>

#include "stiffront/mesh/halo_exchange.hpp"
#include "stiffront/space/diffusion_operator.hpp"
#include "support/grids.hpp"

namespace stiffront::testing {

/// The diffusion operator of one species with D = 1 as a matrix and a vector, L u = matrix u + boundary_part over the free points of
/// a grid on one process, found by applying the operator to unit vectors.
struct AssembledDiffusion {
  AssembledDiffusion(const Communicator& self, const Grid& grid_, const Sides& x, const Sides& y, const BoundaryValue& value, int order)
      : grid(grid_),
        decomposition(self, grid, {0, 0}, 1),
        boundary(boundary_of(x, y, 1, value)),
        diffusion(grid, boundary, {1.0}, order),
        box(boundary.free_box(decomposition)) {
    const Boundary homogeneous = boundary_of(x, y, 1, zero);
    HaloExchange halo(decomposition, boundary, 1, 1, diffusion.halo_width());
    Field u(decomposition, 1, diffusion.halo_width());
    Field lu(decomposition, 1, diffusion.halo_width());
    const auto apply = [&](const Boundary& values) {
      values.impose(u, 0.0);
      halo.exchange(u);
      diffusion.apply(u, lu, box);
    };
    std::vector<Eigen::Triplet<double>> entries;
    for_each_point([&](int column, int i, int j) {
      u.at(0, i, j) = 1.0;
      apply(homogeneous);
      for_each_point([&](int row, int k, int l) {
        if (lu.at(0, k, l) != 0.0) entries.emplace_back(row, column, lu.at(0, k, l));
      });
      u.at(0, i, j) = 0.0;
    });
    matrix.resize(size(), size());
    matrix.setFromTriplets(entries.begin(), entries.end());
    apply(boundary);
    boundary_part.resize(size());
    for_each_point([&](int row, int i, int j) { boundary_part[row] = lu.at(0, i, j); });
  }

  int size() const { return (box.i_end - box.i_begin) * (box.j_end - box.j_begin); }
  /// f(number, i, j) for the free points.
  template <class F>
  void for_each_point(F&& f) const {
    int number = 0;
    for (int j = box.j_begin; j < box.j_end; ++j) {
      for (int i = box.i_begin; i < box.i_end; ++i) f(number++, i, j);
    }
  }

  Grid grid;
  Decomposition decomposition;
  Boundary boundary;
  DiffusionOperator diffusion;
  FreeBox box;
  Eigen::SparseMatrix<double> matrix;
  Eigen::VectorXd boundary_part;
};

}  // namespace stiffront::testing
