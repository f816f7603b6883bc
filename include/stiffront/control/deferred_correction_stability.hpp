// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <complex>
#include <vector>

#include "stiffront/control/collocation.hpp"

namespace stiffront {

/// What one step of DC-S with k corrections makes of a mode u' = lambda u, z = lambda dt, whose sub-flows are exact: R_k(z), from (15)
/// and (16). Lie and Strang are the same here.
std::complex<double> deferred_correction_amplification(const CollocationNodes& nodes, int k, std::complex<double> z);

/// Largest |z| up to which |R_k| <= 1 on the negative real axis, for k = 0 .. most; infinity where that is the whole axis. To four digits.
///
/// Beyond, |R_k| grows like |z|^(k-1): the corrections that make the order take the stability of the splitting away.
std::vector<double> deferred_correction_stability_limits(const CollocationNodes& nodes, int most);

}  // namespace stiffront
