// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>

#include "stiffront/app/options.hpp"
#include "stiffront/core/mpi.hpp"
#include "stiffront/io/progress.hpp"
#include "stiffront/solvers/model_registry.hpp"

namespace stiffront::app {

/// What the command line says about a run besides the case.
struct RunOptions {
  std::string restart;  ///< "latest", a checkpoint folder, or empty for a fresh run
  bool force = false;   ///< replace the results of another run
  bool quiet = false;
  ProgressMode progress = ProgressMode::automatic;
};

/// Runs a case from beginning to end: builds the problem and its method, evolves it, writes results and the summary.
///
/// @throws Error on every rank, with what went wrong; a numerical failure leaves a summary with its reason first.
/// @mpi collective.
void simulate(const Case& c, const ModelRegistry& models, const Communicator& comm, const RunOptions& options);

}  // namespace stiffront::app
