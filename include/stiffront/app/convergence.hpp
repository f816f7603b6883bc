// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "stiffront/app/options.hpp"
#include "stiffront/app/simulation.hpp"
#include "stiffront/core/mpi.hpp"
#include "stiffront/solvers/model_registry.hpp"

namespace stiffront::app {

/// One entry of an order study.
struct ConvergenceRow {
  double step = 0.0;
  std::string variant;          ///< name of the method, or "k=N" for N iterations of dcs
  double error = 0.0;           ///< largest over the species; NaN if the run failed
  std::optional<double> order;  ///< from the row before of the same variant
  std::vector<std::pair<std::string, double>> per_species;
  std::string failure;  ///< why there is no error
  /// Local studies of dcs: the method's own estimate of the error, (43) of Duarte & Emmett 2016, and the step dt_max,k from which on its k-th
  /// correction improves nothing. NaN where there is none.
  std::optional<double> estimate, step_limit;
};

struct ConvergenceStudy {
  std::string kind;       ///< "global" or "local"
  std::string reference;  ///< how the reference was made
  std::vector<ConvergenceRow> rows;
};

/// Errors of a method with fixed steps against a reference solution of the same semi-discrete problem: over the whole time span, or
/// over one step from the initial state.
///
/// Errors are root mean squares over the grid points, divided by the largest modulus of the species in the reference.
/// @throws Error(input) if the case has no [converge] or its method has no fixed step. @mpi collective.
ConvergenceStudy converge(const Case& c, const ModelRegistry& models, const Communicator& comm);

/// Runs the study, prints its table and writes converge.json in the output directory. @mpi collective.
void run_convergence(const Case& c, const ModelRegistry& models, const Communicator& comm, const RunOptions& options);

}  // namespace stiffront::app
