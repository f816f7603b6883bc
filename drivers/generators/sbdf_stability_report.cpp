// SPDX-License-Identifier: BSD-3-Clause
//
// Prints the numbers of docs/sbdf-stability.md: what the tables of SBDF(k) with cell-local sweeps allow beyond the
// conditions they were computed for (equal steps, real eigenvalues, one species).
//
//   sbdf_stability_report
#include <fmt/core.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cstdio>
#include <numbers>
#include <random>
#include <span>
#include <utility>
#include <vector>

#include "stiffront/control/sbdf_stability.hpp"
#include "stiffront/control/sbdf_tables.hpp"

namespace {

using namespace stiffront;
using namespace stiffront::sbdf_stability;

// Largest growth of a step, orders 1..5.
constexpr std::array growth_limit{4.0, 2.2, 1.7, 1.45, 1.35};

std::size_t index(int i) { return static_cast<std::size_t>(i); }

// mu at the extrema of phi and between: `points` in every interval between neighbouring zeros.
std::vector<double> modes(std::span<const double> shifts, int points) {
  std::vector<double> ends{1};
  for (const double g : shifts) ends.push_back(g / 2);
  std::sort(ends.begin(), ends.end());
  std::vector<double> mus;
  for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
    for (int j = 1; j <= points; ++j) mus.push_back(ends[i] + (ends[i + 1] - ends[i]) * j / points);
  }
  return mus;
}

int sufficient_sweeps(int order, double z, double safety) {
  for (int sweeps : sbdf_sweep_counts) {
    if (safety * sbdf_z_limit(order, sweeps) >= z * (1 - 1e-9)) return sweeps;
  }
  return sbdf_max_sweeps;
}

// ---------------------------------------------------------------------------------------------------- the table

void report_table() {
  fmt::print("\n## limits\n\n| k | s | z | z/s^2 | max abs phi | largest between sweeps | largest still to come |\n");
  fmt::print("|---|---|---|---|---|---|---|\n");
  for (int k = 1; k <= sbdf_max_order; ++k) {
    const double gamma = constant_step_weights(k).gamma;
    for (int s : sbdf_sweep_counts) {
      const auto shifts = sbdf_shifts(k, s);
      const double z = sbdf_z_limit(k, s);
      double phi = 0;
      double before = 0;
      double after = 0;
      for (const double mu : modes(shifts, 40)) {
        phi = std::max(phi, std::abs(sweep_remainder(gamma, z, mu, 0.0, shifts)));
        for (std::size_t j = 1; j <= shifts.size(); ++j) {
          before = std::max(before, std::abs(sweep_remainder(gamma, z, mu, 0.0, shifts.first(j))));
          after = std::max(after, std::abs(sweep_remainder(gamma, z, mu, 0.0, shifts.subspan(j))));
        }
      }
      fmt::print("| {} | {} | {:.3f} | {:.3f} | {:.3f} | {:.1f} | {:.2f} |\n", k, s, z, z / (s * s), phi, before, after);
    }
  }
}

// ------------------------------------------------------------------------------------------------- unequal steps

// Steps in units of the largest one allowed.
using Steps = std::vector<double>;

Steps alternating(double ratio) {
  Steps steps;
  for (int n = 0; n < 3000; ++n) steps.push_back(n % 2 == 0 ? 1 : 1 / ratio);
  return steps;
}

// A target drawn anew every `hold` steps is followed with ratios in [0.5, growth].
Steps random_walk(double growth, int hold, unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> log2_target(-5, 0);
  Steps steps;
  double step = 1;
  for (int n = 0; n < 3000; ++n) {
    if (n % hold == 0) {
      const double target = std::exp2(log2_target(generator));
      step = std::clamp(target, 0.5 * step, std::min(1.0, growth * step));
    }
    steps.push_back(step);
  }
  return steps;
}

// Halved when the largest step is reached, then raised again.
Steps sawtooth(double growth, int hold) {
  Steps steps;
  double step = 1;
  for (int n = 0; n < 3000; ++n) {
    if (n % hold == 0) step = step >= 1 ? 0.5 : std::min(1.0, growth * step);
    steps.push_back(step);
  }
  return steps;
}

std::vector<StepWeights> weights_of(int order, const Steps& steps) {
  std::vector<StepWeights> weights(steps.size());
  for (std::size_t n = index(order); n < steps.size(); ++n) {
    std::array<double, max_order + 1> history{};
    for (std::size_t i = 0; i <= index(order); ++i) history[i] = steps[n - i];
    weights[n] = step_weights(order, history);
  }
  return weights;
}

// Mean logarithmic growth a step of the worst mode; negative: all modes decay.
double worst_growth(int order, const Steps& steps, const std::vector<StepWeights>& weights, double z_max, double safety) {
  double worst = -1e300;
  for (int m = 1; m <= 60; ++m) {
    const double mu = m / 60.0;
    for (const double reaction : {0.0, 1.0, 10.0}) {
      std::array<double, max_order + 1> v{1, -0.7, 0.4, 0.9, -0.2, 0.5};
      double logarithm = 0;
      int counted = 0;
      for (std::size_t n = index(order); n < steps.size(); ++n) {
        const double z = z_max * steps[n];
        const auto shifts = sbdf_shifts(order, sufficient_sweeps(order, z, safety));
        const auto step = mode_recursion(weights[n], z, mu, reaction * steps[n], shifts);
        double next = 0;
        for (std::size_t i = 0; i < index(step.length); ++i) next += step.c[i] * v[i];
        std::shift_right(v.begin(), v.end(), 1);
        v[0] = next;
        if (n % 8 == 0) {
          double size = 1e-300;
          for (std::size_t i = 0; i < index(step.length); ++i) size = std::max(size, std::abs(v[i]));
          for (double& value : v) value /= size;
          if (n > 200) {
            logarithm += std::log(size);
            counted += 8;
          }
        }
      }
      worst = std::max(worst, logarithm / counted);
    }
  }
  return worst;
}

void report_unequal_steps() {
  fmt::print("\n## unequal steps: largest safety factor at which all modes decay\n\n");
  fmt::print(
      "| k | largest z | alternating 1.2 | alternating g | random, g | random, 1.1 | random, g, held | sawtooth g |"
      " sawtooth g, held |\n|---|---|---|---|---|---|---|---|---|\n");
  for (int k = 1; k <= sbdf_max_order; ++k) {
    const double g = growth_limit[index(k - 1)];
    const std::array patterns{alternating(1.2),         alternating(g), random_walk(g, 1, 1), random_walk(1.1, 1, 2),
                              random_walk(g, k + 1, 3), sawtooth(g, 1), sawtooth(g, k + 1)};
    for (const int sweeps : {2, 4, 8, 12, 35, 105}) {
      fmt::print("| {} | z({}, {})", k, k, sweeps);
      for (const Steps& steps : patterns) {
        const auto weights = weights_of(k, steps);
        double good = 0.2;
        double bad = 1.4;
        while (bad - good > 0.01) {
          const double safety = (good + bad) / 2;
          const double growth = worst_growth(k, steps, weights, safety * sbdf_z_limit(k, sweeps), safety);
          (growth < 0 ? good : bad) = safety;
        }
        fmt::print(" | {}{:.2f}", good > 1.38 ? "> " : "", good);
      }
      fmt::print(" |\n");
      std::fflush(stdout);
    }
  }
}

// Largest |v_n| after a unit impulse while the step grows from far below the limit of one sweep to that of all.
double transient(int order, double ratio, int hold) {
  const double last = sbdf_z_safety(order) * sbdf_z_limit(order, sbdf_max_sweeps);
  Steps z(10, 0.2 * sbdf_z_safety(order) * sbdf_z_limit(order, 1));
  while (z.back() < last) z.insert(z.end(), index(hold), std::min(last, ratio * z.back()));
  z.insert(z.end(), 60, last);
  const auto weights = weights_of(order, z);
  double largest = 0;
  for (int m = 1; m <= 100; ++m) {
    const double mu = (m / 100.0) * (m / 100.0);
    for (std::size_t start = index(order); start + 60 < z.size(); ++start) {
      std::array<double, max_order + 1> v{1};
      for (std::size_t n = start; n < start + 60; ++n) {
        const auto shifts = sbdf_shifts(order, sufficient_sweeps(order, z[n], sbdf_z_safety(order)));
        const auto step = mode_recursion(weights[n], z[n], mu, 0.0, shifts);
        double next = 0;
        for (std::size_t i = 0; i < index(step.length); ++i) next += step.c[i] * v[i];
        std::shift_right(v.begin(), v.end(), 1);
        v[0] = next;
        largest = std::max(largest, std::abs(next));
      }
    }
  }
  return largest;
}

void report_transients() {
  fmt::print("\n## growth of a unit disturbance while the step grows through the whole table\n\n");
  fmt::print("| k | 1.05 every step | 1.1 | 1.2 | g | g, held |\n|---|---|---|---|---|---|\n");
  for (int k = 1; k <= sbdf_max_order; ++k) {
    const double g = growth_limit[index(k - 1)];
    fmt::print("| {} | {:.1f} | {:.1f} | {:.1f} | {:.1f} | {:.1f} |\n", k, transient(k, 1.05, 1), transient(k, 1.1, 1),
               transient(k, 1.2, 1), transient(k, g, 1), transient(k, g, k + 1));
    std::fflush(stdout);
  }
}

// ------------------------------------------------------------------------------- complex and growing reaction modes

bool stable_at_angle(int order, std::span<const double> shifts, double z_max, double degrees) {
  const StepWeights weights = constant_step_weights(order);
  const std::complex<double> direction = std::polar(1.0, degrees * std::numbers::pi / 180);
  auto mus = modes(shifts, 8);
  mus.push_back(0);
  for (const double fraction : {1.0, 0.9, 0.75, 0.5, 0.25, 0.1, 0.03}) {
    for (const double mu : mus) {
      for (double size = 0.02; size < 1e3; size *= 1.12) {
        // 1e-6: on the imaginary axis small modes have modulus 1 + O(size^(k+1)) for every order.
        if (!roots_within(mode_recursion(weights, fraction * z_max, mu, size * direction, shifts), 1 + 1e-6)) {
          return false;
        }
      }
    }
  }
  return true;
}

double largest_angle(int order, std::span<const double> shifts, double z_max) {
  double good = 0;
  double bad = 90;
  if (stable_at_angle(order, shifts, z_max, bad)) return bad;
  while (bad - good > 0.2) {
    const double middle = (good + bad) / 2;
    (stable_at_angle(order, shifts, z_max, middle) ? good : bad) = middle;
  }
  return good;
}

void report_angles() {
  fmt::print("\n## sector of reaction eigenvalues (degrees from the negative real axis), smallest of all s >= 2\n\n");
  constexpr std::array safeties{1.0, 0.9, 0.8, 0.7, 0.6, 0.5};
  fmt::print("| k | BDF alone | s = 1 |");
  for (const double safety : safeties) fmt::print(" {} z |", safety);
  fmt::print("\n|---|---|---|---|---|---|---|---|---|\n");
  for (int k = 1; k <= sbdf_max_order; ++k) {
    fmt::print("| {} | {:.1f}", k, largest_angle(k, sbdf_shifts(k, 1), 1e-9));
    fmt::print(" | {:.1f}", largest_angle(k, sbdf_shifts(k, 1), sbdf_z_limit(k, 1)));
    for (const double safety : safeties) {
      double smallest = 90;
      for (int s : sbdf_sweep_counts) {
        if (s == 1) continue;
        smallest = std::min(smallest, largest_angle(k, sbdf_shifts(k, s), safety * sbdf_z_limit(k, s)));
      }
      fmt::print(" | {:.1f}", smallest);
      std::fflush(stdout);
    }
    fmt::print(" |\n");
  }
}

// Growing reactions, L = -growth: the worst ln|zeta| over all modes with at least the given exact decay (negative:
// growth) z mu - growth.
double worst_logarithm(int order, double growth, double least_decay) {
  const StepWeights weights = constant_step_weights(order);
  double worst = -1e300;
  for (int s : sbdf_sweep_counts) {
    const auto shifts = sbdf_shifts(order, s);
    for (const double fraction : {1.0, 0.9, 0.75, 0.5, 0.25, 0.1, 0.03}) {
      const double z = fraction * sbdf_z_safety(order) * sbdf_z_limit(order, s);
      auto mus = modes(shifts, 12);
      mus.push_back(0);
      for (const double mu : mus) {
        if (z * mu - growth < least_decay) continue;
        worst = std::max(worst, std::log(largest_root(mode_recursion(weights, z, mu, -growth, shifts))));
      }
    }
  }
  return worst;
}

void report_growing_modes() {
  fmt::print(
      "\n## growing reactions, exact growth e^a a step: ln of the largest growth of all modes; of the modes that"
      " should decay by e^(-a) or more\n\n");
  const std::array growths{0.05, 0.1, 0.2, 0.4};
  fmt::print("| k |");
  for (const double a : growths) fmt::print(" a = {} |", a);
  fmt::print("\n|---|---|---|---|---|\n");
  for (int k = 1; k <= sbdf_max_order; ++k) {
    fmt::print("| {} |", k);
    for (const double a : growths) fmt::print(" {:.3f}; {:.3f} |", worst_logarithm(k, a, -a), worst_logarithm(k, a, a));
    fmt::print("\n");
  }
}

// ---------------------------------------------------------------------------------------------------- two species

// Spectral radius of the recursion of two species with diffusion z and d z, coupled by the Jacobian -L (2x2).
double coupled_radius(const StepWeights& weights, double z, double d, double mu, const Eigen::Matrix2d& reaction,
                      std::span<const double> shifts) {
  const Eigen::Matrix2d one = Eigen::Matrix2d::Identity();
  const Eigen::Matrix2d rho = Eigen::Vector2d(z, d * z).asDiagonal();
  const Eigen::Matrix2d system = one + weights.gamma * (reaction + mu * rho);
  Eigen::Matrix2d phi = one;
  for (const double g : shifts) {
    const Eigen::Matrix2d cell = one + weights.gamma * (reaction + g / 2 * rho);
    phi = (one - cell.inverse() * system) * phi;
  }
  const Eigen::Matrix2d corrected = (one - phi) * system.inverse();
  const int terms = weights.order + 1;
  Eigen::MatrixXd companion = Eigen::MatrixXd::Zero(2 * terms, 2 * terms);
  for (int i = 0; i < terms; ++i) {
    const double history = i < weights.order ? weights.history[index(i)] : 0;
    companion.block<2, 2>(0, 2 * i) = phi * weights.predictor[index(i)] + corrected * history;
    if (i > 0) companion.block<2, 2>(2 * i, 2 * (i - 1)) = one;
  }
  return companion.eigenvalues().cwiseAbs().maxCoeff();
}

void report_two_species() {
  fmt::print(
      "\n## two species, random coupling: share of unstable samples, largest modulus\n\n"
      "| k | s | 0.9 z, 45 degrees | 0.7 z, 45 degrees | 0.9 z, real | 0.7 z, real |\n|---|---|---|---|---|---|\n");
  constexpr int samples = 1500;
  for (int k = 2; k <= sbdf_max_order; ++k) {
    const StepWeights weights = constant_step_weights(k);
    for (const int s : {1, 3, 6, 12}) {
      const auto shifts = sbdf_shifts(k, s);
      fmt::print("| {} | {}", k, s);
      for (const auto& [safety, largest_degrees] : {std::pair{0.9, 45.0}, {0.7, 45.0}, {0.9, 1e-3}, {0.7, 1e-3}}) {
        std::mt19937 generator(5);
        std::normal_distribution<double> normal;
        std::uniform_real_distribution<double> uniform;
        const double z = safety * sbdf_z_limit(k, s);
        const auto mus = modes(shifts, 6);
        int unstable = 0;
        double largest = 0;
        for (int sample = 0; sample < samples;) {
          // Stiffness from 0.1 to 1000 a step, diffusion ratio from 1 down to 0.001 and exactly 0.
          Eigen::Matrix2d reaction;
          for (double& entry : reaction.reshaped()) entry = normal(generator);
          reaction *= std::pow(10.0, -1 + 4 * uniform(generator));
          double d = std::pow(10.0, -3 * uniform(generator));
          if (sample % 4 == 0) d = 0;
          // Only systems whose exact modes are damped and inside the sector.
          const auto in_sector = [&](double mu) {
            const Eigen::Matrix2d rho = Eigen::Vector2d(z, d * z).asDiagonal();
            for (const std::complex<double> value : Eigen::Matrix2d(reaction + mu * rho).eigenvalues()) {
              const double degrees = std::abs(std::arg(value)) * 180 / std::numbers::pi;
              if (degrees > largest_degrees) return false;
            }
            return true;
          };
          if (!in_sector(0) || !std::all_of(mus.begin(), mus.end(), in_sector)) continue;
          ++sample;
          double radius = 0;
          for (const double mu : mus) radius = std::max(radius, coupled_radius(weights, z, d, mu, reaction, shifts));
          if (radius > 1) ++unstable;
          largest = std::max(largest, radius);
        }
        fmt::print(" | {:.1f} %, {:.2f}", 100.0 * unstable / samples, largest);
      }
      fmt::print(" |\n");
      std::fflush(stdout);
    }
  }
}

}  // namespace

int main() {
  report_table();
  report_transients();
  report_angles();
  report_growing_modes();
  report_two_species();
  report_unequal_steps();
}
