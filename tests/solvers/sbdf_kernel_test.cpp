// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/solvers/sbdf_kernel.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "stiffront/mesh/halo_exchange.hpp"
#include "stiffront/model/builtin/bz.hpp"
#include "stiffront/model/builtin/pulse.hpp"

namespace stiffront {
namespace {

/// One problem of any dimension and order, its fields filled with smooth data, halos by the exchange.
template <class M>
class SweepProblem {
 public:
  static constexpr int m = M::n_species;

  SweepProblem(int dimension, int order, std::vector<double> diffusion)
      : comm_(MPI_COMM_SELF),
        grid_{dimension, {29, dimension == 2 ? 11 : 1}, {0.0, 0.0}, {1.0, 0.7}},
        decomposition_(comm_, grid_, {1, 1}, order / 2),
        boundary_(Boundary::natural(grid_)),
        diffusion_(grid_, boundary_, std::move(diffusion), order),
        kernel_(model_),
        v(decomposition_, m, order / 2),
        r(v.similar()),
        out(v.similar()) {
    for (int s = 0; s < m; ++s) {
      for (int j = 0; j < v.n_y(); ++j) {
        for (int i = 0; i < v.n_x(); ++i) {
          v.at(s, i, j) = 0.3 + 0.1 * s + 0.1 * std::sin(0.4 * i + 0.9 * j + s);
          r.at(s, i, j) = v.at(s, i, j) + 0.01 * std::cos(0.3 * i - 0.5 * j + 2.0 * s);
        }
      }
    }
    HaloExchange halo(decomposition_, boundary_, m, 1, order / 2, diffusion_.diffusing_species());
    halo.exchange(v);
  }

  SbdfSweep sweep() const { return {0.4, 2e-3, 1.3, &decomposition_, rows_of(v), rows_of(r), {}}; }
  void run(const FreeBox& box, Field& to) const {
    SbdfSweep s = sweep();
    s.out = rows_of(to);
    kernel_.sweep(diffusion_, s, box);
  }
  FreeBox box() const { return {0, v.n_x(), 0, v.n_y()}; }

  /// The left side of the cell's system applied to what the sweep has added, minus its right side.
  double residual(int s, int i, int j) const {
    const SbdfSweep w = sweep();
    double u[m];
    double rate[m];
    double jacobian[m * m];
    for (int q = 0; q < m; ++q) u[q] = v.at(q, i, j);
    const double x = grid_.position(0, i);
    const double y = grid_.dimension == 2 ? grid_.position(1, j) : 0.0;
    cell_rates(model_, w.t, x, y, u, rate);
    cell_jacobian(model_, w.t, x, y, u, jacobian);
    double laplacian = 0.0;
    diffusion_.dispatch([&]<int Order, int Dimension>() {
      laplacian = diffusion_.coefficient(s) > 0.0 ? diffusion_.stencil<Order, Dimension>(s, v)(v.row(s, j) + i)[0] : 0.0;
    });
    double left = (1.0 + 0.5 * w.gamma * w.shift * diffusion_.spectral_radius(s)) * (out.at(s, i, j) - u[s]);
    for (int q = 0; q < m; ++q) left -= w.gamma * jacobian[s * m + q] * (out.at(q, i, j) - u[q]);
    return left - (r.at(s, i, j) - u[s] + w.gamma * (rate[s] + laplacian));
  }

 private:
  Communicator comm_;
  Grid grid_;
  Decomposition decomposition_;
  Boundary boundary_;
  DiffusionOperator diffusion_;
  M model_;
  SbdfKernelOf<M> kernel_;

 public:
  Field v, r, out;
};

template <class M>
void expect_solved_and_independent_of_the_cut(std::vector<double> diffusion) {
  for (int dimension : {1, 2}) {
    for (int order : {2, 4}) {
      SweepProblem<M> p(dimension, order, diffusion);
      p.run(p.box(), p.out);
      for (int s = 0; s < M::n_species; ++s) {
        for (int j = 0; j < p.v.n_y(); ++j) {
          for (int i = 0; i < p.v.n_x(); ++i) EXPECT_NEAR(p.residual(s, i, j), 0.0, 1e-12) << s << ' ' << i << ' ' << j;
        }
      }
      // The same box cut anywhere, so that cells change lanes and rows become shorter than a pack.
      for (int cut : {1, 3, 8, 13, 28}) {
        Field pieces = p.v.similar();
        p.run({0, cut, 0, p.v.n_y()}, pieces);
        p.run({cut, p.v.n_x(), 0, p.v.n_y()}, pieces);
        for (int s = 0; s < M::n_species; ++s) {
          for (int j = 0; j < p.v.n_y(); ++j) {
            for (int i = 0; i < p.v.n_x(); ++i) EXPECT_EQ(pieces.at(s, i, j), p.out.at(s, i, j)) << cut;
          }
        }
      }
    }
  }
}

TEST(SbdfKernel, SolvesTheCellSystemsWithTheSameBitsHoweverTheBoxIsCut) {
  expect_solved_and_independent_of_the_cut<Bz>({2.5e-3, 2.5e-3, 1.5e-3});
}

TEST(SbdfKernel, KnowsTimeAndPlaceOfEveryCellAndSpeciesThatDoNotDiffuse) { expect_solved_and_independent_of_the_cut<Pulse>({0.01, 0.0}); }

TEST(SbdfKernel, LeavesPointsOutsideTheBoxAlone) {
  SweepProblem<Bz> p(2, 2, {1.0, 1.0, 1.0});
  p.run({2, 20, 3, 9}, p.out);
  for (int j = 0; j < p.v.n_y(); ++j) {
    for (int i = 0; i < p.v.n_x(); ++i) {
      const bool inside = i >= 2 && i < 20 && j >= 3 && j < 9;
      EXPECT_EQ(p.out.at(0, i, j) != 0.0, inside) << i << ' ' << j;
    }
  }
}

}  // namespace
}  // namespace stiffront
