// SPDX-License-Identifier: BSD-3-Clause
//
// Computes the shifts and stability limits of SBDF(k) with cell-local sweeps.
//
//   sbdf_tables > include/stiffront/control/sbdf_tables.hpp
//
// In y = gamma z mu, the sweeps leave of the predictor's error the polynomial
//
//     phi(y) = prod_j (y_j - y)/(1 + y_j),  y_j = gamma z g_j/2,  phi(-1) = 1, and phi(0) = 0 as g_1 = 0,
//
// and a mode is damped exactly when phi lies in a band lower(y) <= phi <= upper(y) that depends on the order alone, not
// on the sweeps. The largest z = Y/gamma for s sweeps therefore belongs to the polynomial that touches lower, upper,
// lower, ... in turn, once in each of its s lobes (0, y_2), (y_2, y_3), ..., (y_s, Y): a weighted Chebyshev polynomial.
// Its s unknowns y_2..y_s, Y follow from s equations, solved by Newton's method from Chebyshev nodes. (That equal
// ripples are optimal is the usual argument of counting zeros: if another polynomial with the same values at -1 and 0
// stayed inside the band on a longer interval, the difference would have s - 1 zeros between the touching points
// besides the zeros at -1 and 0: s + 1 zeros, one too many.) Reactions L > 0 and smaller z are not in the band; they
// are scanned afterwards and cut z if they must.
#include <fmt/core.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <limits>
#include <numbers>
#include <numeric>
#include <string>
#include <vector>

#include "stiffront/control/sbdf_stability.hpp"
#include "stiffront/core/error.hpp"

namespace {

using namespace stiffront;
using namespace stiffront::sbdf_stability;

constexpr int highest_order = 5;

// Every number of sweeps up to here; beyond, numbers some 17 % apart (a step then makes 8 % too many on average).
constexpr int dense_up_to = 12;
constexpr std::array sweep_counts{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 14, 16, 19, 22, 26, 30, 35, 41, 48, 56, 66, 77, 90, 105};

// Every mode loses at least 2 % of its amplitude in a step, or half of the logarithm it should lose if that is less.
constexpr double damping = 0.98;

// At order 1 the band reaches to phi = 1, where a sweep sequence corrects nothing. This bound is the smallest (in steps
// of 0.05) that leaves order 1 a larger z than order 2 for every number of sweeps.
constexpr double largest_remainder = 0.85;

// ---------------------------------------------------------------------------------------------------- the band

class Band {
 public:
  explicit Band(int order) : weights_(constant_step_weights(order)) {
    for (int i = 0; i < points; ++i) {
      const double y = std::exp(log_first + log_step * i);
      lower_.push_back(edge(y, -1));
      upper_.push_back(edge(y, +1));
    }
  }

  double gamma() const { return weights_.gamma; }

  // |phi| at the edge on the side of this sign, linear in log y.
  double operator()(double y, double sign) const {
    const auto& values = sign < 0 ? lower_ : upper_;
    const double place = std::clamp((std::log(std::max(y, 1e-300)) - log_first) / log_step, 0.0, points - 1.001);
    const auto i = static_cast<std::size_t>(place);
    const double fraction = place - static_cast<double>(i);
    return values[i] * (1 - fraction) + values[i + 1] * fraction;
  }

 private:
  static constexpr int points = 2000;
  static constexpr double log_first = -9.3;                // y = 1e-4
  static constexpr double log_step = 16.2 / (points - 1);  // to y = 1e3

  // First |phi| at which damping is lost, seen from phi = 0 (plain BDF, always damped on the real axis).
  double edge(double y, double sign) const {
    const double allowed = required_modulus(y / weights_.gamma, damping);
    const auto damped = [&](double phi) { return roots_within(recursion(weights_, sign * phi, y), allowed); };
    double inside = 0;
    double outside = 1e-3;
    while (damped(outside)) {
      if (outside >= largest_remainder) return largest_remainder;
      inside = outside;
      outside *= 1.01;
    }
    for (int i = 0; i < 40; ++i) {
      const double middle = (inside + outside) / 2;
      (damped(middle) ? inside : outside) = middle;
    }
    return std::min(inside, largest_remainder);
  }

  StepWeights weights_;
  std::vector<double> lower_;
  std::vector<double> upper_;
};

// ------------------------------------------------------------------------------------------------ the polynomial

struct Ripples {
  std::vector<double> zeros;  // y_1 = 0 < y_2 < ... < y_s
  double end = 0;             // Y
};

double remainder(const std::vector<double>& zeros, double y) {
  double phi = 1;
  for (const double zero : zeros) phi *= (zero - y) / (1 + zero);
  return phi;
}

// Largest |phi| / edge of the band in the lobe that starts at zeros[lobe].
double ripple(const Band& band, const Ripples& ripples, std::size_t lobe) {
  const double first = ripples.zeros[lobe];
  const double last = lobe + 1 < ripples.zeros.size() ? ripples.zeros[lobe + 1] : ripples.end;
  const double sign = lobe % 2 == 0 ? -1 : 1;
  const auto height = [&](double y) { return std::abs(remainder(ripples.zeros, y)) / band(y, sign); };
  constexpr int points = 48;
  int best = 1;
  for (int i = 2; i <= points; ++i) {
    if (height(first + (last - first) * i / points) > height(first + (last - first) * best / points)) best = i;
  }
  double left = first + (last - first) * (best - 1) / points;
  double right = first + (last - first) * std::min(best + 1, points) / points;
  for (int i = 0; i < 60; ++i) {
    const double a = left + (right - left) / 3;
    const double b = right - (right - left) / 3;
    (height(a) < height(b) ? left : right) = height(a) < height(b) ? a : b;
  }
  return std::max(height((left + right) / 2), height(last));
}

// Unknowns: logarithms of the distances between neighbouring zeros, so that the order of the zeros cannot be lost.
Ripples from_distances(const Eigen::VectorXd& log_distances) {
  Ripples ripples;
  double y = 0;
  for (const double log_distance : log_distances) {
    ripples.zeros.push_back(y);
    y += std::exp(log_distance);
  }
  ripples.end = y;
  return ripples;
}

Ripples equal_ripples(const Band& band, int sweeps) {
  Eigen::VectorXd x(sweeps);
  double previous = 0;
  for (int i = 0; i < sweeps; ++i) {  // zeros of the Chebyshev polynomial on [0, s^2/3], moved to start at 0
    const double next = sweeps * sweeps / 6.0 * (1 - std::cos(std::numbers::pi * (i + 1.5) / (sweeps + 1)));
    x[i] = std::log(next - previous);
    previous = next;
  }
  const auto residual = [&](const Eigen::VectorXd& at) {
    const Ripples ripples = from_distances(at);
    Eigen::VectorXd result(sweeps);
    for (int i = 0; i < sweeps; ++i) result[i] = std::log(ripple(band, ripples, static_cast<std::size_t>(i)));
    return result;
  };
  Eigen::VectorXd r = residual(x);
  for (int iteration = 0; iteration < 200 && r.cwiseAbs().maxCoeff() > 1e-7; ++iteration) {
    Eigen::MatrixXd jacobian(sweeps, sweeps);
    constexpr double increment = 1e-5;
    for (int j = 0; j < sweeps; ++j) {
      Eigen::VectorXd moved = x;
      moved[j] += increment;
      jacobian.col(j) = (residual(moved) - r) / increment;
    }
    Eigen::VectorXd step = jacobian.fullPivLu().solve(-r);
    step *= std::min(1.0, 0.5 / step.cwiseAbs().maxCoeff());
    Eigen::VectorXd r_new = residual(x + step);
    for (int halving = 0; halving < 20 && !(r_new.norm() < r.norm()); ++halving) {
      step /= 2;
      r_new = residual(x + step);
    }
    if (!(r_new.norm() < r.norm())) break;
    x += step;
    r = r_new;
  }
  if (r.cwiseAbs().maxCoeff() > 1e-4) {
    throw Error(ErrorKind::numerics, fmt::format("no equal ripples found for {} sweeps", sweeps));
  }
  return from_distances(x);
}

// ------------------------------------------------------------------------------------------- the order of the sweeps

// phi does not depend on the order of its factors, but what happens between the sweeps does: after the first j the
// error of the predictor has the product of j factors, and what the nonlinear cell solve of sweep j gets wrong is
// multiplied by the factors still to come. Both must stay small for every mode. The first sweep has g = 0 so that
// smooth modes meet the undamped equation at once. The best order of the others minimises the sum over j of both
// maxima; the maximum of a product depends on the set of its factors only, so the sum is a shortest path through sets.
std::vector<double> best_order(std::vector<double> zeros, double end) {
  const std::size_t n = zeros.size();
  constexpr int points = 400;
  const std::uint32_t all = (1U << n) - 1;
  std::vector<double> largest(all + 1);
  for (std::uint32_t set = 0; set <= all; ++set) {
    double most = 0;
    for (int i = 0; i <= points; ++i) {
      double product = 1;
      for (std::size_t j = 0; j < n; ++j) {
        if ((set >> j & 1U) != 0) product *= (zeros[j] - end * i / points) / (1 + zeros[j]);
      }
      most = std::max(most, std::abs(product));
    }
    largest[set] = most;
  }
  std::vector<double> cost(all + 1, std::numeric_limits<double>::infinity());
  std::vector<std::size_t> last(all + 1, 0);
  cost[1] = 0;  // the set of the first sweep, g = 0
  for (std::uint32_t set = 1; set <= all; set += 2) {
    for (std::size_t j = 1; j < n; ++j) {
      const std::uint32_t next = set | 1U << j;
      if (next == set) continue;
      const double candidate = cost[set] + largest[next] + largest[all & ~next];
      if (candidate < cost[next]) {
        cost[next] = candidate;
        last[next] = j;
      }
    }
  }
  std::vector<double> ordered(n);
  std::uint32_t set = all;
  for (std::size_t place = n - 1; place > 0; --place) {
    ordered[place] = zeros[last[set]];
    set &= ~(1U << last[set]);
  }
  ordered[0] = zeros[0];
  return ordered;
}

// Long sequences. With shift 0 first the roughest modes of the predictor's error would grow by gamma z, thousands of
// times, which nonlinear rates do not forgive; so the place of the zero is free too. Too many sets for all of them: the
// best `width` beginnings are continued, measured as above.
std::vector<double> good_order(const std::vector<double>& zeros, double end) {
  const std::size_t n = zeros.size();
  constexpr int per_lobe = 8;
  constexpr std::size_t width = 24;
  std::vector<double> places;
  for (std::size_t j = 0; j < n; ++j) {
    const double next = j + 1 < n ? zeros[j + 1] : end;
    for (int i = 1; i <= per_lobe; ++i) places.push_back(zeros[j] + (next - zeros[j]) * (i - (j + 1 < n ? 0.5 : 0)) / per_lobe);
  }
  const std::size_t points = places.size();
  std::vector<std::vector<double>> factor(n, std::vector<double>(points));
  std::vector<double> whole(points, 0);
  for (std::size_t j = 0; j < n; ++j) {
    for (std::size_t p = 0; p < points; ++p) {
      factor[j][p] = std::log(std::abs((zeros[j] - places[p]) / (1 + zeros[j])));
      whole[p] += factor[j][p];
    }
  }
  struct Beginning {
    double cost = 0;
    std::vector<bool> used;
    std::vector<std::size_t> sequence;
    std::vector<double> product;  // logarithms
  };
  std::vector<Beginning> best{{0, std::vector<bool>(n, false), {}, std::vector<double>(points, 0)}};
  for (std::size_t place = 0; place < n; ++place) {
    struct Candidate {
      double cost;
      std::size_t from;
      std::size_t next;
    };
    std::vector<Candidate> candidates;
    for (std::size_t from = 0; from < best.size(); ++from) {
      for (std::size_t j = 0; j < n; ++j) {
        if (best[from].used[j]) continue;
        double before = -1e300;
        double after = -1e300;
        for (std::size_t p = 0; p < points; ++p) {
          const double product = best[from].product[p] + factor[j][p];
          before = std::max(before, product);
          after = std::max(after, whole[p] - product);
        }
        candidates.push_back({best[from].cost + std::exp(before) + std::exp(after), from, j});
      }
    }
    // Equal costs come from the same set in another order: one of them is enough.
    std::stable_sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) { return a.cost < b.cost; });
    std::vector<Beginning> next;
    for (const Candidate& c : candidates) {
      if (next.size() == width) break;
      std::vector<bool> used = best[c.from].used;
      used[c.next] = true;
      if (std::any_of(next.begin(), next.end(), [&](const Beginning& b) { return b.used == used; })) continue;
      Beginning b{c.cost, std::move(used), best[c.from].sequence, best[c.from].product};
      b.sequence.push_back(c.next);
      for (std::size_t p = 0; p < points; ++p) b.product[p] += factor[c.next][p];
      next.push_back(std::move(b));
    }
    best = std::move(next);
  }
  std::vector<double> ordered;
  for (const std::size_t j : best.front().sequence) ordered.push_back(zeros[j]);
  return ordered;
}

// --------------------------------------------------------------------------------------------------------- the table

struct Entry {
  double z = 0;
  std::vector<double> shifts;
};

// Of the shifts; the smallest of the longest sequence is 1e-3.
constexpr double unit = 1e-6;

double rounded(double x, double to) { return std::round(x / to) * to; }

Entry make_entry(int order, int sweeps, const Band& band) {
  const Ripples ripples = equal_ripples(band, sweeps);
  Entry entry;
  const bool is_short = sweeps <= dense_up_to;
  for (const double zero : is_short ? best_order(ripples.zeros, ripples.end) : good_order(ripples.zeros, ripples.end)) {
    entry.shifts.push_back(rounded(2 * zero / ripples.end, unit));
  }
  // The limit is what a direct scan of all modes confirms for the rounded shifts, never more than the ideal.
  const int points_per_lobe = is_short ? 60 : 40;
  const double ideal = ripples.end / band.gamma();
  double good = 0.5 * ideal;
  double bad = 1.001 * ideal;
  if (!all_modes_damped(order, entry.shifts, good, damping, points_per_lobe)) {
    throw Error(ErrorKind::numerics, fmt::format("order {}, {} sweeps: undamped at half the ideal", order, sweeps));
  }
  while (bad - good > 1e-5 * ideal) {
    const double middle = (good + bad) / 2;
    (all_modes_damped(order, entry.shifts, middle, damping, points_per_lobe) ? good : bad) = middle;
  }
  entry.z = std::floor(std::min(good, ideal) * 1e4) / 1e4;
  return entry;
}

void print_table() {
  std::string counts;
  for (int sweeps : sweep_counts) counts += fmt::format("{}{}", counts.empty() ? "" : ", ", sweeps);
  fmt::print(R"(// SPDX-License-Identifier: BSD-3-Clause
// Generated by drivers/generators/sbdf_tables.cpp: sbdf_tables > include/stiffront/control/sbdf_tables.hpp
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <stdexcept>

// clang-format off
namespace stiffront {{

/// Highest order the tables hold.
inline constexpr int sbdf_max_order = {};
/// Numbers of sweeps the tables hold, ascending.
inline constexpr std::array sbdf_sweep_counts{{{}}};
inline constexpr int sbdf_max_sweeps = sbdf_sweep_counts.back();

namespace sbdf_tables {{

/// z_limit[order - 1][n]: largest dt * rho, rho: spectral radius of a species' diffusion.
inline constexpr std::array<std::array<double, sbdf_sweep_counts.size()>, sbdf_max_order> z_limit = {{{{
)",
             highest_order, counts);
  std::vector<std::vector<Entry>> entries;
  for (int order = 1; order <= highest_order; ++order) {
    const Band band(order);
    auto& row = entries.emplace_back();
    for (int sweeps : sweep_counts) row.push_back(make_entry(order, sweeps, band));
    fmt::print("    {{{{");
    for (std::size_t s = 0; s < row.size(); ++s) fmt::print("{}{:.4f}", s == 0 ? "" : ", ", row[s].z);
    fmt::print("}}}},\n");
    std::fflush(stdout);
  }
  fmt::print(R"(}}}};

/// shifts[order - 1]: the shifts of all numbers of sweeps one after the other, those of one in the order of the sweeps,
/// in units of half the spectral radius of the species (the diagonal of -D lap for the three-point stencil).
inline constexpr std::array<std::array<double, {}>, sbdf_max_order> shifts = {{{{
)",
             std::accumulate(sweep_counts.begin(), sweep_counts.end(), 0));
  for (const auto& row : entries) {
    fmt::print("    {{{{\n");
    for (const Entry& entry : row) {
      for (std::size_t j = 0; j < entry.shifts.size(); ++j) {
        fmt::print("{}{:.6f},{}", j % 12 == 0 ? "        " : " ", entry.shifts[j],
                   j % 12 == 11 || j + 1 == entry.shifts.size() ? "\n" : "");
      }
    }
    fmt::print("    }}}},\n");
  }
  fmt::print(R"(}}}};

/// Place of a number of sweeps among sbdf_sweep_counts. @throws std::out_of_range if it is not there
constexpr std::size_t place_of(int sweeps) {{
  const auto* const found = std::find(sbdf_sweep_counts.begin(), sbdf_sweep_counts.end(), sweeps);
  if (found == sbdf_sweep_counts.end()) throw std::out_of_range("sbdf tables: number of sweeps");
  return static_cast<std::size_t>(found - sbdf_sweep_counts.begin());
}}

}}  // namespace sbdf_tables

/// Largest dt * rho at which SBDF(order) with this many sweeps damps every mode of a step by {:.0f} % or more, for equal
/// steps and real non-positive reaction eigenvalues; rho is the largest of the species' spectral radii of diffusion.
/// Multiply by sbdf_z_safety(order) before use. order in 1..sbdf_max_order, sweeps one of sbdf_sweep_counts.
/// @throws std::out_of_range outside of the table
/// @see stiffront/control/sbdf_stability.hpp, docs/sbdf-stability.md
constexpr double sbdf_z_limit(int order, int sweeps) {{
  return sbdf_tables::z_limit.at(static_cast<std::size_t>(order - 1)).at(sbdf_tables::place_of(sweeps));
}}

/// The part of sbdf_z_limit to use: 0.7 for orders 1 and 2, 0.9 for orders 3 to 5.
///
/// Unequal steps, the smallest sufficient number of sweeps in every step: random ratios in [0.5, g], g = 2, 1.8, 1.4,
/// 1.25, 1.2 for orders 1..5, keep all modes bounded up to factors of 0.99, 1.05, 1.22, 1.26, 1.26 of the limit. The
/// most harmful pattern, up by g and down again in every other step, allows 0.59, 0.66, 0.92, 1.04, 1.04; if a raised or
/// lowered step is held for order + 1 steps, halving and raising in turn allows 0.84, 1.06, 1.05, 1.12, 1.11.
/// Raise order 5 by 1.2 only with that hold, or else by 1.1 at most: raising by 1.2 in every step amplifies a
/// disturbance some 10^4 times on the way through the table, because BDF5 does so without any sweeps.
/// Damped oscillating reactions: 0.7 leaves orders 1 and 2 A-stable in the presence of diffusion (0.9 would leave 65
/// degrees at order 2); 0.9 leaves 76 degrees at order 3 (0.8 all of its 86) and the full sector of orders 4 and 5.
constexpr double sbdf_z_safety(int order) {{ return order <= 2 ? 0.7 : 0.9; }}

/// The shifts in the order of the sweeps, each in units of half the spectral radius of the species' own diffusion; one of
/// them is 0, the first if there are at most {} sweeps. Valid for every dt * rho <= sbdf_z_limit(order, sweeps).
/// @throws std::out_of_range outside of the table
constexpr std::span<const double> sbdf_shifts(int order, int sweeps) {{
  const auto& row = sbdf_tables::shifts.at(static_cast<std::size_t>(order - 1));
  std::size_t first = 0;
  for (std::size_t n = sbdf_tables::place_of(sweeps); n > 0; --n) first += static_cast<std::size_t>(sbdf_sweep_counts[n - 1]);
  return std::span<const double>(row).subspan(first, static_cast<std::size_t>(sweeps));
}}

}}  // namespace stiffront
)",
             100 * (1 - damping), dense_up_to);
}

}  // namespace

int main() {
  try {
    print_table();
  } catch (const std::exception& error) {
    fmt::print(stderr, "sbdf_tables: {}\n", error.what());
    return EXIT_FAILURE;
  }
  return EXIT_SUCCESS;
}
