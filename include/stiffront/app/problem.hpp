// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "stiffront/app/options.hpp"
#include "stiffront/mesh/boundary.hpp"
#include "stiffront/mesh/decomposition.hpp"
#include "stiffront/solvers/model_registry.hpp"
#include "stiffront/space/coupled_rhs.hpp"
#include "stiffront/space/diffusion_operator.hpp"

namespace stiffront::app {

/// The diffusion coefficients of a case, one per species. @throws Error(input) for an expression that cannot be evaluated
std::vector<double> diffusion_coefficients(const Case& c);

/// The semi-discrete problem of a case: grid, boundary, model, operators and the initial state, built and ready.
///
/// Its parts refer to each other, so it stays where it is made.
/// @throws Error(input) on every rank for what the case file's own validation cannot know.
/// @mpi collective.
class Problem {
 public:
  Problem(const Case& c, const ModelRegistry& models, const Communicator& comm);
  Problem(const Problem&) = delete;
  Problem& operator=(const Problem&) = delete;

  /// Scale of each species: its largest modulus in the initial state, 1 where that is 0.
  const std::vector<double>& scales() const { return scales_; }

  /// Where the initial state came from, if that needs saying.
  const std::string& note() const { return note_; }

  const Case& options;
  const Communicator& comm;
  Grid grid;
  Decomposition decomposition;
  Boundary boundary;
  std::unique_ptr<ModelKernels> model;
  std::unique_ptr<TransportTerm> transport;  ///< null for models without first derivatives
  DiffusionOperator diffusion;
  CoupledRhs rhs;
  Field state;

 private:
  std::vector<double> scales_;
  std::string note_;
};

}  // namespace stiffront::app
