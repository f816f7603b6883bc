// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "stiffront/solvers/model_registry.hpp"
#include "stiffront/solvers/rock4.hpp"
#include "stiffront/space/coupled_rhs.hpp"
#include "stiffront/splitting/reaction_flow.hpp"

namespace stiffront::testing {

/// The Brusselator on a line, smooth data, with inner solvers far finer than the errors measured. Diffusion is strong enough for the
/// splitting error to stand above the quadrature's.
class SplitBrusselator : public ::testing::Test {
 protected:
  SplitBrusselator()
      : comm_(MPI_COMM_SELF),
        decomposition_(comm_, Grid{1, {33, 1}}, {1, 1}, 1),
        boundary_(Boundary::natural(decomposition_.grid())),
        model_(make_model()),
        diffusion_(decomposition_.grid(), boundary_, {0.05, 0.025}, 2),
        rhs_(decomposition_, diffusion_, *model_),
        reaction_(decomposition_, boundary_, model_->make_radau5({1e-13, {1e-13, 1e-13}})),
        rock4_(decomposition_, diffusion_, {1e-13, {1e-13, 1e-13}}),
        u_(decomposition_, 2, 1) {
    for (int i = 0; i < u_.n_x(); ++i) {
      const double x = decomposition_.grid().position(0, i);
      u_.at(0, i) = 1.0 + 0.5 * std::cos(M_PI * x);
      u_.at(1, i) = 3.0 + 0.5 * std::cos(2 * M_PI * x);
    }
  }

  /// Largest difference.
  static double distance(const Field& a, const Field& b) {
    double e = 0.0;
    for (int s = 0; s < 2; ++s) {
      for (int i = 0; i < a.n_x(); ++i) e = std::max(e, std::abs(a.at(s, i) - b.at(s, i)));
    }
    return e;
  }

  Communicator comm_;
  Decomposition decomposition_;
  Boundary boundary_;
  std::unique_ptr<ModelKernels> model_;
  DiffusionOperator diffusion_;
  CoupledRhs rhs_;
  ReactionFlow reaction_;
  Rock4 rock4_;
  Field u_;

 private:
  static std::unique_ptr<ModelKernels> make_model() {
    ModelRegistry registry;
    register_builtin_models(registry);
    return registry.make("brusselator", {{"A", 1.0}, {"B", 3.0}});
  }
};

}  // namespace stiffront::testing
