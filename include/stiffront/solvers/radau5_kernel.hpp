// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "stiffront/core/simd.hpp"
#include "stiffront/model/model.hpp"
#include "stiffront/solvers/radau5_step.hpp"
#include "stiffront/solvers/reaction_solver.hpp"

namespace stiffront {

/// Work of a Radau5Kernel, summed over cells; each cell's part depends on that cell alone.
struct Radau5Counts {
  std::int64_t steps = 0;  ///< accepted
  std::int64_t error_rejections = 0;
  std::int64_t newton_failures = 0;  ///< attempts in which Newton's iteration did not converge
  std::int64_t newton_iterations = 0;
  std::int64_t rhs = 0;        ///< evaluations of the rates, those within Jacobians included
  std::int64_t jacobians = 0;  ///< one, with its two decompositions, per attempt

  bool operator==(const Radau5Counts&) const = default;
};

/// n consecutive cells, species-major: species s of cell i is at from[s * from_stride + i].
struct CellRow {
  int n;
  const double* from;
  std::ptrdiff_t from_stride;
  double* to;  ///< may be `from`, with the same stride
  std::ptrdiff_t to_stride;
  double* hint;             ///< one per cell: inner step to begin with, 0 for the whole interval; updated
  float* cost;              ///< one per cell: Newton iterations of this call, and attempt_cost for each of its attempts
  std::int64_t first_cell;  ///< number of cell 0 in reports of failures
};

/// A cell that could not be integrated; `to` holds its state at the beginning of the interval.
struct Radau5Failure {
  std::int64_t cell;
  double t;
  double h;
  const char* reason;
  const double* to;  ///< where the state is, and the distance of its species
  std::ptrdiff_t stride;
};

/// Integrates du/dt = rates(t, x, y, u) over an interval [t, t + dt] in many cells, each with inner steps of its own.
///
///     kernel.begin(t, dt);
///     for (each row) kernel.row(row, [&](int i, int n) { return Place<T> of the pack of n cells that starts at cell i; });
///     failure = kernel.finish();
///
/// Most cells of a reacting front need one step. row() goes over the packs in order and tries just that; cells that need more
/// are put on a list. The list is worked off in packs too: as soon as a lane has finished its cell it takes the next one.
/// A cell's result, hint and cost depend on that cell's state, place and hint alone, to the last bit.
///
/// The step control is that of RADAU5: Newton's iteration is stopped by its estimated contraction, starting values extrapolate the
/// last collocation polynomial, the error estimate is filtered twice in first steps and after rejections, and step sizes are
/// predicted from the last two errors (Gustafsson). Different are: Jacobian and decompositions are always fresh (lanes would have
/// to agree to keep them, and for small m they cost little more than one Newton iteration); where two steps will do for the rest of
/// the interval they are equal; fractional powers are replaced by square roots.
///
/// T = double runs the same code one cell at a time.
/// @see Hairer & Wanner, Solving Ordinary Differential Equations II, 2nd ed., IV.8
template <class M, class T = Pack>
class Radau5Kernel {
 public:
  static constexpr int m = M::n_species;
  using Traits = ScalarTraits<T>;
  using Mask = typename Traits::MaskType;

  /// @param max_attempts per cell and call; a cell that needs more has failed.
  Radau5Kernel(M model, const Radau5Tolerances<m>& tolerances, int max_attempts = 100000)
      : model_(std::move(model)), tolerances_(tolerances), max_attempts_(max_attempts) {}

  void begin(double t, double dt) {
    t_ = t;
    dt_ = dt;
    counts_ = {};
    newton_iterations_ = T(0.0);
    failure_.reset();
  }

  template <class PlaceOf>
  [[gnu::flatten]] void row(const CellRow& cells, PlaceOf&& place_of) {
    const T h(dt_);
    const T inverse_h(1.0 / dt_);
    for (int i = 0; i < cells.n; i += Traits::size) whole_step(cells, i, std::min(Traits::size, cells.n - i), place_of, h, inverse_h);
  }

  /// @return the failed cell with the lowest number, if any
  std::optional<Radau5Failure> finish() {
    work_off_list();
    return failure_;
  }

  /// Since begin().
  Radau5Counts counts() const {
    Radau5Counts c = counts_;
    for (int l = 0; l < Traits::size; ++l) c.newton_iterations += static_cast<std::int64_t>(Traits::lane(newton_iterations_, l));
    c.rhs += 3 * c.newton_iterations;
    return c;
  }

 private:
  /// A cell on the list, with what its attempt at a whole step has left.
  struct Pending {
    double* to;
    std::ptrdiff_t stride;
    double* hint;
    float* cost;
    std::int64_t cell;
    double x, y;
    double h;
    double work;  ///< its cost so far
    bool rejected;
  };
  /// A list so long is worked off at once: it stays in the cache, and the few idle lanes at its end do not matter.
  static constexpr std::size_t longest_list = 2048;

  static constexpr double safety = 0.9;
  static constexpr double largest_growth = 8.0;
  static constexpr double smallest_shrink = 0.2;

  static T load(const double* p, int n) { return n == Traits::size ? Traits::load(p) : Traits::load_partial(p, n); }
  static void store(T x, double* p, int n) {
    if (n == Traits::size) {
      Traits::store(x, p);
    } else {
      Traits::store_partial(x, p, n);
    }
  }
  static std::int64_t count(Mask mask) { return __builtin_popcount(bits(mask)); }

  /// The step size after an attempt: err^(1/4) with RADAU5's safety factor, which favours steps with few Newton iterations.
  static T quotient(const Radau5Attempt<T, m>& a) {
    constexpr double n = 2.0 * radau5_max_newton_iterations;
    const T factor = min(T(safety), T(safety * (1.0 + n)) / (a.newton_iterations + T(n)));
    const T root = sqrt(sqrt(sqrt(max(a.error_squared, T(1e-20)))));
    return max(T(1.0 / largest_growth), min(T(1.0 / smallest_shrink), root / factor));
  }
  /// The step after a rejected attempt.
  static T after_rejection(const Radau5Attempt<T, m>& a, T h) {
    const T by_error = select(is_finite(a.error_squared), h / quotient(a), T(smallest_shrink) * h);
    return select(a.converged, by_error, a.shrink * h);
  }
  /// What of h is used when `rest` remains: all, half of it, or h.
  static T fit(T h, T rest) { return select(T(1.0001) * h >= rest, rest, select(T(2.0) * h >= rest, T(0.5) * rest, h)); }

  template <class PlaceOf>
  [[gnu::always_inline]] void whole_step(const CellRow& cells, int i, int n, PlaceOf&& place_of, T h, T inverse_h) {
    const Mask present = n == Traits::size ? Mask(true) : Traits::first(n);
    const T hint = load(cells.hint + i, n);
    const Mask wanted = present && (hint == T(0.0) || hint >= h);
    Radau5Start<T, m> start{place_of(i, n), {}, h, inverse_h, wanted, Mask(true)};
    start.place.t = T(t_);
    T* const u = start.u;
    for (int s = 0; s < m; ++s) u[s] = load(cells.from + s * cells.from_stride + i, n);

    Mask left = present;
    T retry = hint;
    T cost(0.0);
    if (any(wanted)) {
      Radau5Attempt<T, m> a;
      a.newton_factor = T(1.0);
      radau5_attempt<true>(model_, start, tolerances_, a);
      const Mask accepted = a.converged && a.error_squared < T(1.0);
      count_attempts(wanted, accepted, a);
      for (int s = 0; s < m; ++s) u[s] = select(accepted, u[s] + (a.w[0][s] + a.w[1][s]), u[s]);
      cost = select(wanted, a.newton_iterations + T(ReactionSolver::attempt_cost), T(0.0));
      left = present && !accepted;
      retry = select(accepted, T(0.0), hint);
      if (any(left)) retry = select(wanted && !accepted, after_rejection(a, h), retry);
    }
    for (int s = 0; s < m; ++s) store(u[s], cells.to + s * cells.to_stride + i, n);
    Traits::store_as_float(cost, cells.cost + i, n);
    store(retry, cells.hint + i, n);  // of cells on the list: replaced when they are done

    if (any(left)) {
      for (int l = 0; l < n; ++l) {
        if ((bits(left) >> l & 1U) == 0) continue;
        list_.push_back({cells.to + i + l, cells.to_stride, cells.hint + i + l, cells.cost + i + l, cells.first_cell + i + l,
                         Traits::lane(start.place.x, l), Traits::lane(start.place.y, l), Traits::lane(retry, l), Traits::lane(cost, l),
                         (bits(wanted) >> l & 1U) != 0});
      }
      if (list_.size() >= longest_list) work_off_list();
    }
  }

  void count_attempts(Mask wanted, Mask accepted, const Radau5Attempt<T, m>& a) {
    const std::int64_t attempts = count(wanted);
    newton_iterations_ = newton_iterations_ + select(wanted, a.newton_iterations, T(0.0));
    counts_.steps += count(accepted);
    counts_.error_rejections += count(wanted && a.converged && !accepted);
    counts_.newton_failures += count(wanted && !a.converged);
    counts_.jacobians += attempts;
    counts_.rhs += attempts + count(wanted && a.refined);
  }

  /// The state of the cells that are being integrated, one per lane.
  struct Lanes {
    T u[m];
    T polynomial[3][m];  ///< of the last step, in Newton's form
    T x, y;
    T elapsed;
    T h;
    T last_h;  ///< 0 before the first accepted step
    T last_error;
    T newton_factor;
    T attempts;
    T cost;
    T rates_size;  ///< of the last attempt
    Mask rejected;
    Mask active;
    const Pending* cell[Traits::size];
  };

  void enter(Lanes& lanes, int l, const Pending& p) {
    for (int s = 0; s < m; ++s) {
      Traits::set_lane(lanes.u[s], l, p.to[s * p.stride]);
      for (int k = 0; k < 3; ++k) Traits::set_lane(lanes.polynomial[k][s], l, 0.0);
    }
    Traits::set_lane(lanes.x, l, p.x);
    Traits::set_lane(lanes.y, l, p.y);
    Traits::set_lane(lanes.elapsed, l, 0.0);
    Traits::set_lane(lanes.h, l, Traits::lane(fit(T(p.h), T(dt_)), l));
    Traits::set_lane(lanes.last_h, l, 0.0);
    Traits::set_lane(lanes.last_error, l, 1.0);
    Traits::set_lane(lanes.newton_factor, l, 1.0);
    Traits::set_lane(lanes.attempts, l, p.rejected ? 1.0 : 0.0);
    Traits::set_lane(lanes.cost, l, p.work);
    Traits::set_lane(lanes.rejected, l, p.rejected);
    lanes.cell[l] = &p;
  }

  void work_off_list() {
    if (list_.empty()) return;
    Lanes lanes;
    std::size_t next = 0;
    for (int l = 0; l < Traits::size; ++l) {
      const bool real = next < list_.size();
      enter(lanes, l, real ? list_[next++] : list_.front());  // idle lanes repeat a cell, so that they hold sensible numbers
      Traits::set_lane(lanes.active, l, real);
    }
    while (any(lanes.active)) {
      Mask done;
      Mask failed;
      T hint;
      step(lanes, done, failed, hint);
      const unsigned leaving = bits(done || failed);
      for (int l = 0; l < Traits::size && leaving >> l != 0; ++l) {
        if ((leaving >> l & 1U) == 0) continue;
        leave(lanes, l, (bits(failed) >> l & 1U) != 0, Traits::lane(hint, l));
        if (next < list_.size()) {
          enter(lanes, l, list_[next++]);
        } else {
          Traits::set_lane(lanes.active, l, false);
        }
      }
    }
    list_.clear();
  }

  /// One attempt in each active lane.
  [[gnu::noinline, gnu::flatten]] void step(Lanes& lanes, Mask& done, Mask& failed, T& hint) {
    namespace tab = radau5_tableau;
    const T h = lanes.h;
    const Mask active = lanes.active;
    const Mask first = lanes.last_h == T(0.0);
    Radau5Start<T, m> start{{T(t_) + lanes.elapsed, lanes.x, lanes.y}, {}, h, T(1.0) / h, active, first || lanes.rejected};
    for (int s = 0; s < m; ++s) start.u[s] = lanes.u[s];
    Radau5Attempt<T, m> a;
    {
      // Lagrange's polynomial of the last step at the new stages, less its value at the new origin
      const T ratio = select(first, T(1.0), h / select(first, T(1.0), lanes.last_h));
      const T at1 = T(tab::c[0]) * ratio;
      const T at2 = T(tab::c[1]) * ratio;
      for (int s = 0; s < m; ++s) {
        const auto value = [&](T at) {
          const T inner = mul_add(at - T(tab::c[0] - 1.0), lanes.polynomial[2][s], lanes.polynomial[1][s]);
          return at * mul_add(at - T(tab::c[1] - 1.0), inner, lanes.polynomial[0][s]);
        };
        const T z[3] = {value(at1), value(at2), value(ratio)};
        for (int i = 0; i < 3; ++i) {
          a.w[i][s] = mul_add(T(tab::t_inverse[i][0]), z[0], mul_add(T(tab::t_inverse[i][1]), z[1], T(tab::t_inverse[i][2]) * z[2]));
        }
      }
    }
    // The contraction is not taken for granted from one step to the next: RADAU5 uses its 0.8th power, here the 3/4th
    const T root = sqrt(max(lanes.newton_factor, T(2.2e-16)));
    a.newton_factor = root * sqrt(root);
    radau5_attempt<false>(model_, start, tolerances_, a);
    const Mask accepted = active && a.converged && a.error_squared < T(1.0);
    count_attempts(active, accepted, a);
    lanes.attempts = lanes.attempts + T(1.0);
    lanes.cost = lanes.cost + (a.newton_iterations + T(ReactionSolver::attempt_cost));
    lanes.newton_factor = a.newton_factor;

    // Step size: the elementary controller, and after the first accepted step the smaller one of it and Gustafsson's
    T q = quotient(a);
    const T error_squared = max(a.error_squared, T(1e-20));
    const T predictive = (lanes.last_h / h) * sqrt(sqrt(error_squared / lanes.last_error)) * T(1.0 / safety);
    q = select(first, q, max(q, max(T(1.0 / largest_growth), min(T(1.0 / smallest_shrink), predictive))));
    T next = h / q;
    next = select(lanes.rejected, min(next, h), next);
    next = select(accepted, next, after_rejection(a, h));

    const T rest = T(dt_) - lanes.elapsed;
    done = accepted && h >= rest;
    const T elapsed = select(accepted, lanes.elapsed + h, lanes.elapsed);
    for (int s = 0; s < m; ++s) {
      const T z0 = mul_add(T(tab::t[0][0]), a.w[0][s], mul_add(T(tab::t[0][1]), a.w[1][s], T(tab::t[0][2]) * a.w[2][s]));
      const T z1 = mul_add(T(tab::t[1][0]), a.w[0][s], mul_add(T(tab::t[1][1]), a.w[1][s], T(tab::t[1][2]) * a.w[2][s]));
      const T z2 = a.w[0][s] + a.w[1][s];
      constexpr double c1 = tab::c[0];
      constexpr double c2 = tab::c[1];
      const T d32 = (z1 - z2) * T(1.0 / (c2 - 1.0));
      const T d21 = (z0 - z1) * T(1.0 / (c1 - c2));
      const T d321 = (d21 - d32) * T(1.0 / (c1 - 1.0));
      const T d210 = (d21 - z0 * T(1.0 / c1)) * T(1.0 / c2);
      const T p[3] = {d32, d321, d321 - d210};
      for (int k = 0; k < 3; ++k) lanes.polynomial[k][s] = select(accepted, p[k], lanes.polynomial[k][s]);
      lanes.u[s] = select(accepted, lanes.u[s] + z2, lanes.u[s]);
    }
    lanes.elapsed = elapsed;
    lanes.last_h = select(accepted, h, lanes.last_h);
    lanes.last_error = select(accepted, max(sqrt(error_squared), T(1e-2)), lanes.last_error);
    lanes.rejected = active && !accepted;
    lanes.h = fit(next, T(dt_) - elapsed);
    hint = next;

    const Mask stuck = elapsed + T(0.1) * lanes.h == elapsed || lanes.h < T(1e-30 * dt_);
    const Mask exhausted = lanes.attempts >= T(static_cast<double>(max_attempts_));
    failed = active && !done && (stuck || exhausted || !is_finite(a.rates_size));
    lanes.rates_size = a.rates_size;
  }

  void leave(Lanes& lanes, int l, bool failed, double hint) {
    const Pending& p = *lanes.cell[l];
    *p.cost = static_cast<float>(Traits::lane(lanes.cost, l));
    if (!failed) {
      for (int s = 0; s < m; ++s) p.to[s * p.stride] = Traits::lane(lanes.u[s], l);
      *p.hint = hint < dt_ ? hint : 0.0;
      return;
    }
    *p.hint = 0.0;
    if (failure_ && failure_->cell < p.cell) return;
    const char* reason = "the inner step size has become too small";
    if (Traits::lane(lanes.attempts, l) >= max_attempts_) reason = "too many inner steps";
    if (!is_finite(Traits::lane(lanes.rates_size, l))) reason = "the rates are not finite";
    failure_ = Radau5Failure{p.cell, t_ + Traits::lane(lanes.elapsed, l), Traits::lane(lanes.h, l), reason, p.to, p.stride};
  }

  M model_;
  Radau5Tolerances<m> tolerances_;
  int max_attempts_;
  double t_ = 0.0;
  double dt_ = 0.0;
  std::vector<Pending> list_;
  Radau5Counts counts_;
  T newton_iterations_;  ///< whole numbers: the order in which cells are added does not matter
  std::optional<Radau5Failure> failure_;
};

}  // namespace stiffront
