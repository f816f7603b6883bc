// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <cmath>

#include "stiffront/core/simd.hpp"
#include "stiffront/model/model.hpp"
#include "stiffront/solvers/cell_solve.hpp"
#include "stiffront/solvers/radau5_tableau.hpp"

namespace stiffront {

/// What the step needs to know about accuracy, in the form in which it uses it.
///
/// As in RADAU5, tolerances are transformed, since the error estimate belongs to a formula of order 3 and the solution has order 5: a
/// relative tolerance r is replaced by 0.1 r^(2/3), absolute ones in proportion. Steps then grow like r^(1/6) and the error of the
/// solution like r^(5/6), and is of the size of r.
template <int m>
struct Radau5Tolerances {
  double relative;
  double absolute[m];
  double newton_squared;  ///< Newton's iteration stops when the square of the estimated remaining error is below this
  /// Estimates filtered twice are held against the tolerances proper: they measure what is left of a fast transient, which is an
  /// error of the solution itself, not of a formula of lower order. Squared factor by which those are smaller.
  double refined_squared;

  /// @param absolute_tolerance one per species, positive
  /// @param relative_tolerance positive
  /// @param newton in units of the transformed tolerance; 0 chooses min(0.03, sqrt(relative))
  Radau5Tolerances(double relative_tolerance, const double* absolute_tolerance, double newton = 0.0) {
    relative = 0.1 * std::pow(relative_tolerance, 2.0 / 3.0);
    const double transformed = relative / relative_tolerance;
    for (int s = 0; s < m; ++s) absolute[s] = absolute_tolerance[s] * transformed;
    refined_squared = std::max(1.0, transformed * transformed);
    if (newton == 0.0) newton = std::max(10.0 * 2.2e-16 / relative, std::min(0.03, std::sqrt(relative)));
    newton_squared = newton * newton;
  }
};

inline constexpr int radau5_max_newton_iterations = 7;

/// One attempt at one step in each lane.
template <class T, int m>
struct Radau5Attempt {
  using Mask = typename ScalarTraits<T>::MaskType;

  T w[3][m];        ///< T^-1 z, see radau5_tableau.hpp; the starting values on entry unless started from zero
  T error_squared;  ///< squared norm of the error estimate: below 1 the step is good
  T newton_iterations;
  T newton_factor;  ///< theta/(1 - theta) of the last contraction theta; starting value of the next step on entry
  T rates_size;     ///< sum of |f(t, u)|, to tell rates that are not finite from steps that are too long
  T shrink;         ///< where Newton's iteration failed: what to multiply the step with
  Mask converged;
  Mask refined;  ///< where the estimate was filtered a second time, with one more evaluation of the rates
};

/// Where and what a step starts from, in each lane.
template <class T, int m>
struct Radau5Start {
  using Mask = typename ScalarTraits<T>::MaskType;

  Place<T> place;  ///< time included
  T u[m];
  T h;
  T inverse_h;
  Mask wanted;  ///< the lanes in which a step is to be tried
  Mask refine;  ///< where an estimate above 1 is filtered a second time: in first steps and after rejections
};

/// Tries a step of Radau IIA of order 5, with a fresh Jacobian, in the lanes that are wanted; the others do no harm.
///
/// Everything a lane computes depends on that lane's arguments alone: iterations continue until the last lane is done, but
/// only change lanes that are not.
/// @tparam from_zero whether the starting values of the stages are zero rather than those in r.w
/// @return false if row exchanges are needed and not allowed; r is then unchanged
template <bool from_zero, bool exchanges, class M, class T>
[[gnu::always_inline]] inline bool radau5_attempt_with(const M& model, const Radau5Start<T, M::n_species>& start,
                                                       const Radau5Tolerances<M::n_species>& tolerances,
                                                       Radau5Attempt<T, M::n_species>& r) {
  namespace tab = radau5_tableau;
  using Mask = typename ScalarTraits<T>::MaskType;
  constexpr int m = M::n_species;
  const T* const u = start.u;
  const T h = start.h;
  const T inverse_h = start.inverse_h;
  const Place<T>& place = start.place;

  // J - gamma/h and J - (alpha + i beta)/h: the negatives of the matrices in the literature, to save changing the sign of J
  T f[m];
  CellLu<T, m, exchanges> real_system;
  ComplexCellLu<T, m, exchanges> complex_system;
  {
    T jacobian[m][m];
    rates_and_jacobian(model, u, f, jacobian, place);
    for (int i = 0; i < m; ++i) {
      for (int j = 0; j < m; ++j) {
        real_system(i, j) = i == j ? jacobian[i][j] - T(tab::gamma) * inverse_h : jacobian[i][j];
        complex_system.re(i, j) = i == j ? jacobian[i][j] - T(tab::alpha) * inverse_h : jacobian[i][j];
        complex_system.im(i, j) = i == j ? T(-tab::beta) * inverse_h : T(0.0);
      }
    }
  }
  const bool real_good = real_system.factor();
  const bool complex_good = complex_system.factor();
  if (!exchanges && !(real_good && complex_good)) return false;

  r.rates_size = T(0.0);
  for (int s = 0; s < m; ++s) r.rates_size = r.rates_size + abs(f[s]);

  T weight[m];  // squares of the inverse tolerances
  for (int s = 0; s < m; ++s) {
    const T scale = mul_add(T(tolerances.relative), abs(u[s]), T(tolerances.absolute[s]));
    weight[s] = T(1.0) / (scale * scale);
  }

  const T newton_squared(tolerances.newton_squared);
  Mask iterating = start.wanted;
  r.converged = Mask(false);
  r.newton_iterations = T(0.0);
  r.shrink = T(0.5);
  if constexpr (from_zero) {
    for (int s = 0; s < m; ++s) r.w[0][s] = r.w[1][s] = r.w[2][s] = T(0.0);
  }
  T last_norm(0.0);   // squares of the norm of the last increment
  T last_ratio(1.0);  // and of the last ratio of two norms
  for (int k = 1; k <= radau5_max_newton_iterations; ++k) {
    T d[3][m];
    {
      T stage[3][m];
      const auto state_of = [&](int i, T* v) {
        for (int s = 0; s < m; ++s) {
          if (from_zero && k == 1) {
            v[s] = u[s];
          } else if (i == 2) {
            v[s] = u[s] + (r.w[0][s] + r.w[1][s]);
          } else {
            v[s] = u[s] + mul_add(T(tab::t[i][0]), r.w[0][s], mul_add(T(tab::t[i][1]), r.w[1][s], T(tab::t[i][2]) * r.w[2][s]));
          }
        }
      };
      const auto place_of = [&](int i) { return Place<T>{mul_add(T(tab::c[i]), h, place.t), place.x, place.y}; };
      // An interpreted model looks its instructions up once for all three stages.
      if constexpr (requires(T(*v)[m], const Place<T>* places) { model.template rates_of_several<3>(v, v, places); }) {
        T v[3][m];
        for (int i = 0; i < 3; ++i) state_of(i, v[i]);
        const Place<T> places[3] = {place_of(0), place_of(1), place_of(2)};
        model.template rates_of_several<3>(v, stage, places);
      } else {
        for (int i = 0; i < 3; ++i) {
          T v[m];
          state_of(i, v);
          model.rates(v, stage[i], place_of(i));
        }
      }
      const T gamma_h = T(tab::gamma) * inverse_h;
      const T alpha_h = T(tab::alpha) * inverse_h;
      const T beta_h = T(tab::beta) * inverse_h;
      for (int s = 0; s < m; ++s) {  // Lambda/h w - T^-1 F, negative as the matrices
        const auto row = [&](int i) {
          return mul_add(T(tab::t_inverse[i][0]), stage[0][s],
                         mul_add(T(tab::t_inverse[i][1]), stage[1][s], T(tab::t_inverse[i][2]) * stage[2][s]));
        };
        const T f0 = row(0);
        const T f1 = stage[2][s] - f0;
        const T f2 = row(2);
        if (from_zero && k == 1) {
          d[0][s] = -f0;
          d[1][s] = -f1;
          d[2][s] = -f2;
        } else {
          d[0][s] = mul_add(gamma_h, r.w[0][s], -f0);
          d[1][s] = mul_add(alpha_h, r.w[1][s], neg_mul_add(beta_h, r.w[2][s], -f1));
          d[2][s] = mul_add(alpha_h, r.w[2][s], mul_add(beta_h, r.w[1][s], -f2));
        }
      }
    }
    real_system.solve(d[0]);
    complex_system.solve(d[1], d[2]);

    T norm(0.0);
    for (int s = 0; s < m; ++s) {
      norm = mul_add(mul_add(d[0][s], d[0][s], mul_add(d[1][s], d[1][s], d[2][s] * d[2][s])), weight[s], norm);
      for (int i = 0; i < 3; ++i) r.w[i][s] = select(iterating, r.w[i][s] + d[i][s], r.w[i][s]);
    }
    norm = norm * T(1.0 / (3 * m));
    r.newton_iterations = r.newton_iterations + select(iterating, T(1.0), T(0.0));

    Mask good;
    if (k == 1) {
      good = r.newton_factor * r.newton_factor * norm <= newton_squared;
    } else {
      const T ratio = norm / last_norm;
      const T theta = sqrt(k == 2 ? ratio : sqrt(ratio * last_ratio));
      last_ratio = ratio;
      const T factor = theta / (T(1.0) - theta);
      const T remaining = factor * factor * norm;
      good = remaining <= newton_squared;
      // what would remain after the last iteration
      T final_remaining = remaining;
      for (int i = k + 1; i < radau5_max_newton_iterations; ++i) final_remaining = final_remaining * (theta * theta);
      const Mask contracts = theta < T(0.99);
      r.newton_factor = select(iterating && contracts, factor, r.newton_factor);
      const Mask slow = contracts && final_remaining >= newton_squared;
      good = good && contracts;
      if (any(iterating && slow)) {
        // As in RADAU5, with the fourth or eighth root instead of the 1/(10 - k)-th: sequences of square roots
        const T excess = sqrt(sqrt(min(T(400.0), final_remaining / newton_squared)));
        const T root = k <= 3 ? sqrt(sqrt(excess)) : sqrt(excess);
        r.shrink = select(iterating && slow, T(0.8) / root, r.shrink);
      }
      iterating = iterating && contracts && !slow;
    }
    r.converged = r.converged || (iterating && good);
    iterating = iterating && !good;
    if (none(iterating)) break;
    last_norm = max(norm, T(4.9e-32));
  }

  // Error estimate
  T increment[m];
  T e[m];
  for (int s = 0; s < m; ++s) {
    increment[s] = inverse_h * mul_add(T(tab::error_weights[0]), r.w[0][s],
                                       mul_add(T(tab::error_weights[1]), r.w[1][s], T(tab::error_weights[2]) * r.w[2][s]));
    e[s] = -(f[s] + increment[s]);
  }
  real_system.solve(e);
  const auto norm_of = [&](const T* x) {
    T sum(0.0);
    for (int s = 0; s < m; ++s) sum = mul_add(x[s] * x[s], weight[s], sum);
    return sum * T(1.0 / m);
  };
  r.error_squared = norm_of(e);
  r.refined = r.converged && start.refine && r.error_squared >= T(1.0);
  if (any(r.refined)) {
    T v[m];
    for (int s = 0; s < m; ++s) v[s] = u[s] + e[s];
    model.rates(v, e, place);
    for (int s = 0; s < m; ++s) e[s] = -(e[s] + increment[s]);
    real_system.solve(e);
    r.error_squared = select(r.refined, T(tolerances.refined_squared) * norm_of(e), r.error_squared);
  }
  return true;
}

/// The same with row exchanges. It works on a copy, so that the common path may keep its numbers in registers.
template <bool from_zero, class M, class T>
[[gnu::noinline]] void radau5_attempt_with_exchanges(const M& model, const Radau5Start<T, M::n_species>& start,
                                                     const Radau5Tolerances<M::n_species>& tolerances, Radau5Attempt<T, M::n_species>& r) {
  radau5_attempt_with<from_zero, true>(model, start, tolerances, r);
}

/// The same, with row exchanges where they are needed.
template <bool from_zero, class M, class T>
[[gnu::always_inline]] inline void radau5_attempt(const M& model, const Radau5Start<T, M::n_species>& start,
                                                  const Radau5Tolerances<M::n_species>& tolerances, Radau5Attempt<T, M::n_species>& r) {
  if (!radau5_attempt_with<from_zero, false>(model, start, tolerances, r)) [[unlikely]] {
    const Radau5Start<T, M::n_species> start_copy = start;
    Radau5Attempt<T, M::n_species> r_copy = r;
    radau5_attempt_with_exchanges<from_zero>(model, start_copy, tolerances, r_copy);
    r = r_copy;
  }
}

}  // namespace stiffront
