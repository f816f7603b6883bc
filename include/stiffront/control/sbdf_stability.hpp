// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <complex>
#include <span>

/// Linear stability of SBDF(k) with cell-local sweeps, mode by mode.
///
/// One species, one Fourier mode: v' = -(L/dt) v - rho mu v, where L >= 0 is a stable reaction eigenvalue times the
/// step (complex or negative L are allowed here too), rho the spectral radius of the species' discrete diffusion and
/// mu in [0, 1] the place of the mode in its spectrum. z = dt rho. With gamma = 1/(dt d_0) from the leading BDF weight
/// d_0 and y = gamma (z mu + L), the BDF equation reads (1 + y) v = r, r = sum_i w_i v_{n-i}, and has the solution
/// v* = r / (1 + y). A sweep with shift g (in units of half the spectral radius) computes
///
///     (1 + gamma L + gamma z g/2) delta = r - (1 + y) v,   v += delta,
///
/// hence multiplies the error v - v* by 1 - (1 + y)/(1 + gamma L + gamma z g/2)
/// = gamma z (g/2 - mu) / (1 + gamma L + gamma z g/2). After all sweeps the error of the predictor
/// v^(0) = sum_i e_i v_{n-i} is left with the factor phi, the product of these, and
///
///     v_n = v* + phi (v^(0) - v*) = phi sum_{i=1}^{k+1} e_i v_{n-i} + (1 - phi)/(1 + y) sum_{i=1}^{k} w_i v_{n-i}.
///
/// So a mode is a scalar linear recursion of k+1 terms that depends on the sweeps only through phi; it is stable where
/// the polynomial zeta^{k+1} - sum c_i zeta^{k+1-i} has its roots in the unit disk.
///
/// What this does not cover: species with different diffusion coupled by a Jacobian that does not commute with it
/// (sampled, not scanned, see docs/sbdf-stability.md), and advection.
namespace stiffront::sbdf_stability {

inline constexpr int max_order = 5;

/// Weights of one step of order k, made dimensionless by the step itself.
struct StepWeights {
  int order = 0;
  std::array<double, max_order + 1> predictor{};  ///< e_i of v_{n-i}, i = 1..k+1: polynomial of degree k through them
  std::array<double, max_order> history{};        ///< w_i of v_{n-i}, i = 1..k: r = sum w_i v_{n-i}
  double gamma = 0;                               ///< 1/(dt d_0)
};

/// Weights for a history of unequal steps: steps[0] is the step being made, steps[i] the one i steps earlier.
/// @pre order in 1..max_order, order + 1 positive steps (a predictor of order + 1 points needs them all)
StepWeights step_weights(int order, std::span<const double> steps);

/// Weights for equal steps.
StepWeights constant_step_weights(int order);

/// phi: what the sweeps leave of the predictor's error in the mode mu. T: double or std::complex<double>.
template <typename T>
T sweep_remainder(double gamma, double z, double mu, T reaction, std::span<const double> shifts);

/// v_n = sum_{i=1}^{length} c[i-1] v_{n-i}.
template <typename T>
struct Recursion {
  int length = 0;
  std::array<T, max_order + 1> c{};
};

/// The recursion of a mode whose sweeps leave phi, y = gamma (z mu + L).
template <typename T>
Recursion<T> recursion(const StepWeights& weights, T phi, T y);

/// The recursion of the mode mu under the given sweeps.
template <typename T>
Recursion<T> mode_recursion(const StepWeights& weights, double z, double mu, T reaction, std::span<const double> shifts);

/// True if all roots of the recursion's polynomial have modulus < radius.
///
/// Schur-Cohn test: for a p of degree n with |p_n| < |p_0| (p_0 leading) the polynomial (conj(p_0) p - p_n p*)/zeta,
/// p* having the reversed conjugated coefficients, has the same number of roots outside; down to degree 0. About n^2
/// operations, no root is computed.
/// @see Henrici, Applied and Computational Complex Analysis I, 1974, section 6.8
template <typename T>
bool roots_within(const Recursion<T>& recursion, double radius);

/// The largest root modulus, to 1e-9 relative, by bisection with roots_within.
template <typename T>
double largest_root(const Recursion<T>& recursion);

/// The modulus asked of a mode whose exact solution decays by exp(-decay) in the step, decay = z mu + L: at most
/// `modulus`, but a slow mode need not decay faster than half its exact rate.
double required_modulus(double decay, double modulus);

/// True if every mode is damped as required_modulus asks: mu in [0, 1], L = 0 and L in a logarithmic grid up to 1e5,
/// and z' = z and smaller, which is what species with smaller diffusion and smaller steps see.
///
/// A scan, not a proof: points_per_lobe values of mu in every interval between neighbouring zeros of phi(mu).
/// @pre shifts in [0, 2], in any order
bool all_modes_damped(int order, std::span<const double> shifts, double z, double modulus, int points_per_lobe);

}  // namespace stiffront::sbdf_stability
