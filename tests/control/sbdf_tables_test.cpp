// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/sbdf_tables.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <random>
#include <span>
#include <stdexcept>
#include <vector>

#include "stiffront/control/sbdf_stability.hpp"

namespace stiffront::sbdf_stability {
namespace {

constexpr double damping = 0.98;

std::vector<double> random_steps(std::mt19937& generator) {
  std::uniform_real_distribution<double> step(0.5, 1.5);
  std::vector<double> steps(max_order + 1);
  for (double& h : steps) h = step(generator);
  return steps;
}

// ------------------------------------------------------------------------------------------------------ the core

TEST(SbdfStability, WeightsAreExactForPolynomialsOfTheirDegreeOnUnequalSteps) {
  std::mt19937 generator(1);
  for (int order = 1; order <= max_order; ++order) {
    const auto steps = random_steps(generator);
    const StepWeights weights = step_weights(order, steps);
    for (int degree = 0; degree <= order; ++degree) {
      // p(t) = (t + 0.3)^degree, the new time at 0 and times in units of the new step.
      const auto p = [&](double t) { return std::pow(t + 0.3, degree); };
      const double slope = degree == 0 ? 0 : degree * std::pow(0.3, degree - 1);
      double predicted = 0;
      double history = 0;
      double t = 0;
      for (std::size_t i = 0; i <= static_cast<std::size_t>(order); ++i) {
        t -= steps[i] / steps[0];
        predicted += weights.predictor[i] * p(t);
        if (i < static_cast<std::size_t>(order)) history += weights.history[i] * p(t);
      }
      EXPECT_NEAR(predicted, p(0), 1e-9) << "order " << order << " degree " << degree;
      EXPECT_NEAR(history + weights.gamma * slope, p(0), 1e-9) << "order " << order << " degree " << degree;
    }
  }
}

TEST(SbdfStability, EqualStepsGiveTheWellKnownBdfCoefficients) {
  const std::array expected{1.0, 2.0 / 3, 6.0 / 11, 12.0 / 25, 60.0 / 137};
  for (int order = 1; order <= max_order; ++order) {
    EXPECT_NEAR(constant_step_weights(order).gamma, expected[static_cast<std::size_t>(order - 1)], 1e-15);
  }
  EXPECT_NEAR(constant_step_weights(2).history[0], 4.0 / 3, 1e-15);
  EXPECT_NEAR(constant_step_weights(2).predictor[2], 1.0, 1e-15);  // 3, -3, 1
}

// The recursion against the scheme it stands for: s sweeps, one after the other, on v' = -L v - z mu v.
TEST(SbdfStability, RecursionIsWhatTheSweepsDoToOneMode) {
  std::mt19937 generator(2);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int order = 1; order <= max_order; ++order) {
    for (const int sweeps : {1, 4, 9}) {
      const auto steps = random_steps(generator);
      const StepWeights weights = step_weights(order, steps);
      const double z = 0.8 * sbdf_z_limit(order, sweeps);
      const double mu = 0.5 * (1 + uniform(generator));
      const double reaction = 2;
      std::array<double, max_order + 1> past{};
      for (double& v : past) v = uniform(generator);

      double v = 0;
      double r = 0;
      for (std::size_t i = 0; i <= static_cast<std::size_t>(order); ++i) {
        v += weights.predictor[i] * past[i];
        if (i < static_cast<std::size_t>(order)) r += weights.history[i] * past[i];
      }
      for (const double g : sbdf_shifts(order, sweeps)) {
        const double residual = r - v + weights.gamma * (-reaction * v - z * mu * v);
        v += residual / (1 + weights.gamma * reaction + weights.gamma * z * g / 2);
      }

      const auto step = mode_recursion(weights, z, mu, reaction, sbdf_shifts(order, sweeps));
      double expected = 0;
      for (std::size_t i = 0; i < static_cast<std::size_t>(step.length); ++i) expected += step.c[i] * past[i];
      EXPECT_NEAR(v, expected, 1e-11) << "order " << order << " sweeps " << sweeps;
    }
  }
}

TEST(SbdfStability, RootTestFindsTheLargestOfKnownRoots) {
  std::mt19937 generator(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int sample = 0; sample < 200; ++sample) {
    std::vector<std::complex<double>> polynomial{1};
    double largest = 0;
    const int degree = 1 + sample % 6;
    for (int i = 0; i < degree; ++i) {
      const std::complex<double> root(1.5 * uniform(generator), 1.5 * uniform(generator));
      largest = std::max(largest, std::abs(root));
      polynomial.push_back(0);
      for (std::size_t j = polynomial.size() - 1; j > 0; --j) polynomial[j] -= root * polynomial[j - 1];
    }
    Recursion<std::complex<double>> recursion;
    recursion.length = degree;
    for (std::size_t i = 1; i < polynomial.size(); ++i) recursion.c[i - 1] = -polynomial[i];
    EXPECT_NEAR(largest_root(recursion), largest, 1e-7);
    EXPECT_TRUE(roots_within(recursion, 1.001 * largest));
    EXPECT_FALSE(roots_within(recursion, 0.999 * largest));
  }
}

TEST(SbdfStability, RealAndComplexRootTestsAgree) {
  const StepWeights weights = constant_step_weights(4);
  for (double mu = 0.05; mu <= 1; mu += 0.05) {
    const auto shifts = sbdf_shifts(4, 5);
    const double real = largest_root(mode_recursion(weights, 15.0, mu, 1.0, shifts));
    const double complex = largest_root(mode_recursion(weights, 15.0, mu, std::complex<double>(1), shifts));
    EXPECT_NEAR(real, complex, 1e-7);
  }
}

TEST(SbdfStability, ManySweepsNearAModeLeavePlainBdf) {
  // phi = 0 at mu = g/2: the mode is solved exactly, and BDF2 there has the roots of (1 + y) zeta^2 - 4/3 zeta + 1/3.
  const StepWeights weights = constant_step_weights(2);
  const std::array shifts{1.0};
  const double y = weights.gamma * 0.6 * 0.5;
  const double expected = (2 + std::sqrt(4 - 3 * (1 + y))) / (3 * (1 + y));
  EXPECT_NEAR(largest_root(mode_recursion(weights, 0.6, 0.5, 0.0, shifts)), expected, 1e-8);
}

// One sweep without shift, predictor through k points: known closed forms 4/3 (k = 2), 20/21 (k = 3); with k + 1 points
// the mode mu = 1 leaves the disk at zeta = -1, where sum e_i (-1)^i = 1 - 2^(k+1) (up to sign), which gives z.
TEST(SbdfStability, OneSweepBecomesUnstableWhereTheAlternatingModeDoes) {
  for (int order = 1; order <= max_order; ++order) {
    const StepWeights weights = constant_step_weights(order);
    double predictor = 0;
    double history = 0;
    for (std::size_t i = 0; i <= static_cast<std::size_t>(order); ++i) {
      const double sign = i % 2 == 0 ? -1 : 1;  // (-1)^(i+1)
      predictor += sign * weights.predictor[i];
      if (i < static_cast<std::size_t>(order)) history += sign * weights.history[i];
    }
    // 1 = -gamma z P + H  (phi = -gamma z, 1/(1 + y) (1 - phi) = 1)
    const double z = (history - 1) / (weights.gamma * predictor);
    EXPECT_LT(largest_root(mode_recursion(weights, 0.999 * z, 1.0, 0.0, sbdf_shifts(order, 1))), 1) << order;
    EXPECT_GT(largest_root(mode_recursion(weights, 1.001 * z, 1.0, 0.0, sbdf_shifts(order, 1))), 1) << order;
    EXPECT_LT(sbdf_z_limit(order, 1), z) << order;
    EXPECT_GT(sbdf_z_limit(order, 1), 0.96 * z) << order;
  }
}

// ---------------------------------------------------------------------------------------------------- the tables

class SbdfTables : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Orders, SbdfTables, ::testing::Range(1, sbdf_max_order + 1));

TEST_P(SbdfTables, EveryModeIsDampedUpToTheLimit) {
  const int order = GetParam();
  const StepWeights weights = constant_step_weights(order);
  std::mt19937 generator(4);
  std::uniform_real_distribution<double> uniform;
  for (int sweeps : sbdf_sweep_counts) {
    const auto shifts = sbdf_shifts(order, sweeps);
    const double limit = sbdf_z_limit(order, sweeps);
    // On the scan's own grid, and at random in between.
    EXPECT_TRUE(all_modes_damped(order, shifts, limit, sweeps > 12 ? damping + 1e-4 : damping, sweeps > 12 ? 4 : 12)) << sweeps;
    for (int sample = 0; sample < (sweeps > 12 ? 4000 : 20000); ++sample) {
      const double z = limit * std::sqrt(uniform(generator));
      const double mu = std::pow(uniform(generator), 2);
      const double reaction = sample % 2 == 0 ? 0 : std::pow(10.0, -3 + 7 * uniform(generator));
      const double allowed = required_modulus(z * mu + reaction, damping);
      ASSERT_TRUE(roots_within(mode_recursion(weights, z, mu, reaction, shifts), allowed + 2e-4))
          << "sweeps " << sweeps << " z " << z << " mu " << mu << " L " << reaction;
    }
  }
}

TEST_P(SbdfTables, SomeModeGrowsNotFarAboveTheLimit) {
  const int order = GetParam();
  for (int sweeps : sbdf_sweep_counts) {
    const double limit = sbdf_z_limit(order, sweeps);
    EXPECT_FALSE(all_modes_damped(order, sbdf_shifts(order, sweeps), 1.15 * limit, 1 + 1e-9, 24)) << sweeps;
    EXPECT_FALSE(all_modes_damped(order, sbdf_shifts(order, sweeps), 1.01 * limit, damping, 24)) << sweeps;
  }
}

TEST_P(SbdfTables, OneSweepHasNoShiftTheFirstOfShortSequencesAndAllLieInTheSpectrum) {
  for (int sweeps : sbdf_sweep_counts) {
    const auto shifts = sbdf_shifts(GetParam(), sweeps);
    ASSERT_EQ(shifts.size(), static_cast<std::size_t>(sweeps));
    EXPECT_EQ(std::count(shifts.begin(), shifts.end(), 0.0), 1);
    if (sweeps <= 12) {
      EXPECT_EQ(shifts[0], 0);
    }
    for (const double g : shifts) {
      EXPECT_GE(g, 0);
      EXPECT_LT(g, 2);
    }
  }
}

TEST_P(SbdfTables, LimitGrowsWithTheSquareOfTheSweepsAndFallsWithTheOrder) {
  const int order = GetParam();
  double before = 0;
  for (int sweeps : sbdf_sweep_counts) {
    const double per_square = sbdf_z_limit(order, sweeps) / (sweeps * sweeps);
    EXPECT_GT(per_square, (sweeps > 12 ? 0.99 : 0.999) * before) << sweeps;
    before = per_square;
  }
  for (int sweeps : sbdf_sweep_counts) {
    if (order == 1) break;
    EXPECT_LT(sbdf_z_limit(order, sweeps), sbdf_z_limit(order - 1, sweeps)) << sweeps;
  }
}

TEST_P(SbdfTables, NoSweepOfAShortSequenceAmplifiesMoreThanTheFirstHasDone) {
  const int order = GetParam();
  const double gamma = constant_step_weights(order).gamma;
  for (int sweeps = 2; sweeps <= 12; ++sweeps) {
    const auto shifts = sbdf_shifts(order, sweeps);
    const double z = sbdf_z_limit(order, sweeps);
    for (double mu = 0.005; mu <= 1; mu += 0.005) {
      for (std::size_t done = 2; done <= shifts.size(); ++done) {
        EXPECT_LT(std::abs(sweep_remainder(gamma, z, mu, 0.0, shifts.first(done))), gamma * z);
      }
    }
  }
}

TEST_P(SbdfTables, LongSequencesAmplifyLittleOnTheWay) {
  // Shift 0 first would amplify the roughest mode gamma z times, up to 11000; with the order of the table neither what
  // a beginning leaves of the predictor's error nor what an end leaves of an earlier sweep's gets near that.
  const int order = GetParam();
  const double gamma = constant_step_weights(order).gamma;
  for (int sweeps : sbdf_sweep_counts) {
    if (sweeps <= 12) continue;
    const auto shifts = sbdf_shifts(order, sweeps);
    const double z = sbdf_z_limit(order, sweeps);
    double largest = 0;
    for (int i = 0; i <= 400; ++i) {
      const double mu = std::pow(i / 400.0, 2);
      double before = 1;
      double after = 1;
      for (std::size_t j = 0; j < shifts.size(); ++j) {
        before *= sweep_remainder(gamma, z, mu, 0.0, shifts.subspan(j, 1));
        after *= sweep_remainder(gamma, z, mu, 0.0, shifts.subspan(shifts.size() - 1 - j, 1));
        largest = std::max({largest, std::abs(before), std::abs(after)});
      }
    }
    EXPECT_LT(largest, 7.0 * sweeps) << sweeps;
    EXPECT_LT(largest, 0.2 * gamma * z) << sweeps;
  }
}

TEST_P(SbdfTables, ReactionSectorAtTheRecommendedPartOfTheLimitIsNearThatOfBdf) {
  const int order = GetParam();
  const std::array angles{89.0, 89.0, 75.0, 73.0, 51.0};  // BDF alone: 90, 90, 86.0, 73.3, 51.8
  const auto direction = std::polar(1.0, angles[static_cast<std::size_t>(order - 1)] * std::acos(-1.0) / 180);
  const StepWeights weights = constant_step_weights(order);
  for (int sweeps : sbdf_sweep_counts) {
    const double limit = sbdf_z_safety(order) * sbdf_z_limit(order, sweeps);
    for (const double z : {limit, 0.8 * limit, 0.4 * limit}) {
      for (double mu = 0; mu <= 1; mu += 0.02) {
        for (double size = 0.05; size < 500; size *= 1.3) {
          const auto step = mode_recursion(weights, z, mu, size * direction, sbdf_shifts(order, sweeps));
          ASSERT_TRUE(roots_within(step, 1 + 1e-6)) << "sweeps " << sweeps << " mu " << mu << " L " << size;
        }
      }
    }
  }
}

// What the step control does: ratios in [0.5, g], a changed step is held for order + 1 steps, never more than the
// recommended part of the limit, and the fewest sweeps that allow the step.
TEST_P(SbdfTables, ModesStayBoundedUnderRandomAdmissibleStepSequences) {
  const int order = GetParam();
  const double growth = std::array{4.0, 2.2, 1.7, 1.45, 1.35}[static_cast<std::size_t>(order - 1)];
  const auto k = static_cast<std::size_t>(order);
  constexpr std::size_t steps = 600;
  for (unsigned seed = 0; seed < 3; ++seed) {
    std::mt19937 generator(seed);
    std::uniform_real_distribution<double> log2_target(-6, 1);
    const double z_max = sbdf_z_safety(order) * sbdf_z_limit(order, sbdf_max_sweeps);
    std::vector<double> z(steps);  // the step, in units of 1/rho
    double step = 1e-2 * z_max;
    for (std::size_t n = 0; n < steps; ++n) {
      if (n % (k + 1) == 0) {
        step = std::clamp(z_max * std::exp2(log2_target(generator)), 0.5 * step, std::min(z_max, growth * step));
      }
      z[n] = step;
    }
    std::vector<StepWeights> weights(steps);
    std::vector<std::span<const double>> shifts(steps);
    for (std::size_t n = k; n < steps; ++n) {
      std::vector<double> history;
      for (std::size_t i = 0; i <= k; ++i) history.push_back(z[n - i]);
      weights[n] = step_weights(order, history);
      int sweeps = 1;
      for (int s : sbdf_sweep_counts) {
        sweeps = s;
        if (sbdf_z_safety(order) * sbdf_z_limit(order, s) >= z[n] * (1 - 1e-12)) break;
      }
      shifts[n] = sbdf_shifts(order, sweeps);
    }
    for (int m = 1; m <= 40; ++m) {
      const double mu = m / 40.0;
      for (const double reaction : {0.0, 0.02, 1.0}) {  // per unit of z
        std::array<double, max_order + 1> v{1, -1, 1, -1, 1, -1};
        double late = 0;
        for (std::size_t n = k; n < steps; ++n) {
          const auto recursion = mode_recursion(weights[n], z[n], mu, reaction * z[n], shifts[n]);
          double next = 0;
          for (std::size_t i = 0; i <= k; ++i) next += recursion.c[i] * v[i];
          std::shift_right(v.begin(), v.end(), 1);
          v[0] = next;
          ASSERT_LT(std::abs(next), 20) << "mu " << mu << " step " << n;
          if (n > steps - 50) late = std::max(late, std::abs(next));
        }
        EXPECT_LT(late, 1e-6) << "mu " << mu;
      }
    }
  }
}

TEST(SbdfTables, AccessOutsideOfTheTableIsAnError) {
  EXPECT_THROW(sbdf_z_limit(0, 1), std::out_of_range);
  EXPECT_THROW(sbdf_z_limit(sbdf_max_order + 1, 1), std::out_of_range);
  EXPECT_THROW(sbdf_shifts(3, 0), std::out_of_range);
  EXPECT_THROW(sbdf_shifts(3, 13), std::out_of_range);
  EXPECT_THROW(sbdf_shifts(3, sbdf_max_sweeps + 1), std::out_of_range);
}

}  // namespace
}  // namespace stiffront::sbdf_stability
