// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "stiffront/mesh/field.hpp"
#include "stiffront/space/coupled_rhs.hpp"

namespace stiffront {

/// A value at fraction theta of a step from u0 to u1 with slopes d0 and d1 (times the step): the cubic Hermite polynomial, its slopes
/// limited where they cannot be those of the solution.
///
/// The state a splitting leaves is off the slow manifold by its error; the stiff part of F multiplies that distance by dt/epsilon, and
/// an interpolant with such slopes overshoots by as much. A cubic is left as it is if it is monotone (0 <= d0, d1 <= 3 (u1-u0)), or if
/// its ends bend the same way and neither bends more than four times as much as the other, as every resolved solution does; of two
/// ends that differ more the stronger bend is cut to four times the weaker, and if they bend against each other the line is taken.
double interpolate_in_step(double theta, double u0, double d0, double u1, double d1);

/// States inside an accepted step, by the above with the coupled right-hand side at both ends. Fourth order where the step resolves
/// the solution; works on each point alone, so it does not depend on the ranks. Dirichlet points get their values at the time asked for.
class StepInterpolation {
 public:
  /// Evaluates F at both ends; halos of u and u_new are brought up to date, their interior is not changed. @mpi collective.
  StepInterpolation(CoupledRhs& rhs, double t, Field& u, double t_new, Field& u_new);

  /// The state at `time` in [t, t_new].
  void at(double time, Field& result) const;

 private:
  const CoupledRhs* rhs_;
  double t_;
  double t_new_;
  const Field* u_;
  const Field* u_new_;
  Field slope_;
  Field slope_new_;
};

}  // namespace stiffront
