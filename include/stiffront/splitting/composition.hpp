// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <span>
#include <vector>

#include "stiffront/solvers/flow.hpp"

namespace stiffront {

enum class Process { reaction, diffusion };

/// One factor of a splitting: a flow over a fraction of the step.
struct Substep {
  Process process;
  double fraction;
};

/// A splitting as data: its factors in the order in which they are applied. The fractions of each process add up to 1.
using Composition = std::vector<Substep>;

/// Which flow is applied last; for stiff reactions it should be the reaction (Descombes & Massot, Numer. Math. 97, 2004).
enum class SplittingOrder { reaction_last, diffusion_last };

/// X then Y (reaction last), order 1.
Composition lie(SplittingOrder order);
/// Half the last flow, the other one, half the last flow; order 2.
/// @see Strang, SIAM J. Numer. Anal. 5, 1968; Descombes et al. 2011, eq. (2.3), (2.4)
Composition strang(SplittingOrder order);
/// The embedded scheme: (1/2 + epsilon), 1, (1/2 - epsilon); order 1 with an error proportional to epsilon. -1/2 < epsilon < 1/2.
/// @see Descombes et al. 2011, eq. (2.7), (2.8)
Composition shifted_strang(SplittingOrder order, double epsilon);

/// The two flows a splitting is made of.
struct SplitFlows {
  Flow* reaction;
  Flow* diffusion;
  Flow& of(Process p) const { return p == Process::reaction ? *reaction : *diffusion; }
};

/// Applies a composition over a step from t to t + dt. Each process has its own clock: it has consumed the sum of its fractions.
/// `from` keeps its interior unless it is `to`.
/// @return the first failure of this rank; later factors are applied nevertheless, since their communication is collective.
std::optional<CellFailure> advance(const SplitFlows& flows, const Composition& composition, double t, double dt, Field& from, Field& to,
                                   Work& work);

}  // namespace stiffront
