// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>

#include "stiffront/app/options.hpp"

namespace stiffront::app {

/// What the method auto knows of a case before it runs.
struct AutoProblem {
  double tolerance = 0.0;
  double span = 0.0;             ///< of time
  double spectral_radius = 0.0;  ///< of the diffusion
  int dimension = 1;
  int n_species = 1;
};

/// The work of a method, by the model.
struct PredictedWork {
  double steps = 0.0;
  double sweeps = 0.0;     ///< evaluations of all cells, in sweeps of sbdf
  double round_off = 0.0;  ///< what rounding leaves in the solution, relative to it
};

struct AutoChoice {
  MethodOptions method;
  std::string reason;
};

/// Steps and work of sbdf at order 5 and of sdc with nodes in parallel, from counts of problem A (a front that crosses the domain in the
/// span of time): docs/performance.md. Nothing enters but what the case says: the choice is the same on every machine and any number of
/// ranks, and after a restart.
PredictedWork predicted_sbdf(const AutoProblem& problem);
PredictedWork predicted_sdc(const AutoProblem& problem, int nodes);

/// The cheapest of them whose rounding alone is not above the tolerance; if there is none, the one that rounding spoils least.
AutoChoice choose_method(const AutoProblem& problem);

}  // namespace stiffront::app
