// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <map>
#include <vector>

namespace stiffront {

/// One method of the ROCK4 family: s stages, order 4, stable on the real interval [-interval, 0].
///
/// With n = s - 4, a step of length h from (t, y) is
///
///     g_0 = y,  g_1 = y + h mu_1 f(t, y),
///     g_j = h mu_j f(t + ct_{j-1} h, g_{j-1}) + nu_j g_{j-1} + kappa_j g_{j-2},        j = 2 .. n,
///     k_i = f(t + c_i h, g_n + h sum_{l<i} a_il k_l),                                  i = 1 .. 4,
///     y_1 = g_n + h sum_i b_i k_i,
///
/// and the local error estimate, of order 3, costs no further evaluation of f:
///
///     est = d0 [ (y - g_n) + h sum_i e_i k_i ].
///
/// The estimate scales the weights of the first part by 1 - d0, so its constants do not decay with s as those of the
/// traditional estimate do, whose weight of f(y_1) is 1/interval.
///
/// Rounding errors of g_n come back multiplied by about 1.5e-4 s^8, see rock4_max_stages.
/// @see Abdulle, SIAM J. Sci. Comput. 23(6), 2002, for the family; the coefficients are our own (docs/rock4.md).
struct Rock4Coefficients {
  int stages;                              ///< s, evaluations of f in an accepted step
  std::vector<double> mu;                  ///< mu_j at [j - 1], j = 1 .. n
  std::vector<double> nu;                  ///< nu_j at [j - 1]; nu_1 = 1
  std::vector<double> kappa;               ///< kappa_j at [j - 1]; kappa_1 = 0, and nu_j + kappa_j = 1 without rounding error
  std::vector<double> ct;                  ///< ct_j at [j], j = 0 .. n, the time of g_j; ct_0 = 0
  std::array<double, 4> c;                 ///< times of k_1 .. k_4; c[0] = ct_n
  std::array<std::array<double, 4>, 4> a;  ///< strictly lower triangular
  std::array<double, 4> b;
  std::array<double, 4> e;
  double d0;        ///< weight of the error estimate
  double interval;  ///< |R(z)| <= 0.95 for z in [-interval, -0.0514]
};

/// The smallest number of stages there is: one recurrence step and the four of the finishing procedure.
inline constexpr int rock4_min_stages = 5;

/// Computes the method with `stages` stages: 0.05 .. 5 ms, the same bits at every call.
/// @throws Error(kind = bug) if stages < 5 or the stability polynomial was not found
Rock4Coefficients rock4_coefficients(int stages);

/// Length of the damped stability interval: a lower bound, by at most 0.07, that is monotone in `stages`.
double rock4_interval(int stages);

/// The smallest number of stages (at least 5) whose interval contains h_rho, the step times the spectral radius.
/// @throws Error(kind = bug) if h_rho is negative, not finite, or would need more than 10^8 stages
int rock4_stages(double h_rho);

/// The largest useful number of stages in double precision at a relative tolerance.
///
/// Stiff modes leave the recurrence reduced by 1/|w(-interval)| and the finishing procedure amplifies them, and the
/// rounding errors of the last recurrence stage with them, by |w(-interval)| ~ 1.5e-4 s^8. Beyond
/// min(150, 290 tolerance^(1/8)) stages that noise exceeds the tolerance.
int rock4_max_stages(double tolerance);

/// Keeps the methods computed so far. One table belongs to one solver; it is no part of any result.
class Rock4Table {
 public:
  /// The reference stays valid for the life of the table.
  const Rock4Coefficients& operator[](int stages);

 private:
  std::map<int, Rock4Coefficients> methods_;
};

}  // namespace stiffront
