// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <vector>

#include "stiffront/app/options.hpp"
#include "stiffront/core/mpi.hpp"
#include "stiffront/solvers/model_registry.hpp"

namespace stiffront::app {

/// How fast what happens in a state is. All in units of 1/time.
struct Stiffness {
  double diffusion = 0.0;    ///< spectral radius of the diffusion operator
  double reaction = 0.0;     ///< largest modulus of an eigenvalue of the reaction Jacobian over the cells looked at
  double growth = 0.0;       ///< largest real part, 0 if none is positive
  double oscillation = 0.0;  ///< largest imaginary part of an eigenvalue whose real part is negative
  double at_x = 0.0;         ///< place of the largest modulus
  double at_y = 0.0;
  bool finite = true;  ///< otherwise some cell's rates or derivatives are not, and at_x, at_y is the first such cell
};

/// What a case is going to be like, from a look at its initial state: unknowns and memory, stiffness, the time a step takes (measured
/// by a few attempts from the initial state, on a part of the grid with the same spacing if it is large), combinations whose error
/// control says less than it seems to, and what to use instead. Lines of text, without line ends.
///
/// @mpi `self` has one process.
/// @throws Error(input) for what only building the problem finds (a file that cannot be read, ...)
std::vector<std::string> guidance(const Case& c, const ModelRegistry& models, const Communicator& self);

/// What deserves a warning in a case, from its entries alone.
std::vector<std::string> questionable(const Case& c);

/// MiB a run of the case takes on all processes together, as measured for each method.
double estimated_memory_mib(const Case& c);

}  // namespace stiffront::app
