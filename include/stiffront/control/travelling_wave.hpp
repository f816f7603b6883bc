// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <functional>

namespace stiffront {

/// A reaction term f(u) with its first four derivatives: {f, f', f'', f''', f''''} at u.
using ReactionJet = std::function<std::array<double, 5>(double u)>;
/// A profile with its first two derivatives: {u, u', u''} at x.
using ProfileJet = std::function<std::array<double, 3>(double x)>;

/// Leading constants of the local errors of Strang splitting and of its epsilon-shifted embedded scheme for du/dt = u_xx + f(u),
/// in the L2 norm on the line: |S - S_epsilon| = epsilon M1 dt^2, |T - S| = M2 dt^3.
/// @see Descombes et al. 2011, eq. (4.3), (4.4)
struct SplittingConstants {
  double m1 = 0.0;
  double m2 = 0.0;
};

/// By the trapezoidal rule with n intervals, which is accurate to rounding for profiles whose derivatives vanish at both ends.
SplittingConstants splitting_constants(const ReactionJet& f, const ProfileJet& profile, double lower, double upper, int n);

/// M1, M2 of the wave u = 1 / (1 + exp(x / sqrt(2))) of f(u) = u^2 (1 - u).
/// @see Descombes et al. 2011, section 4.2
SplittingConstants kpp_splitting_constants();

/// The step below which the difference of the two schemes overestimates the error of Strang splitting, for a travelling wave of
/// du/dt = D u_xx + k f(u): epsilon M1 / (k M2) with the constants of k = D = 1. @see eq. (4.5), (4.8)
double critical_splitting_step(const SplittingConstants& c, double epsilon, double k);

/// The L2 norms themselves for any k and D: |S - S_epsilon| = epsilon m1 dt^2, |T - S| = m2 dt^3. Time scales like 1/k, space like
/// sqrt(D/k) (eq. 4.6, 4.7).
SplittingConstants scaled(const SplittingConstants& c, double k, double diffusion);

}  // namespace stiffront
