// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/spectral_deferred_correction.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <functional>

#include "stiffront/control/evolve.hpp"
#include "stiffront/core/error.hpp"
#include "support/order_fit.hpp"

namespace stiffront {
namespace {

using Options = SpectralDeferredCorrectionOptions;

/// Ordinary differential equations of two unknowns, the same at the two points of a grid.
class Equations final : public RightHandSide {
 public:
  using Function = std::function<std::array<double, 2>(double t, double u, double v)>;
  Equations(const Grid& grid, Function f) : boundary_(Boundary::natural(grid)), f_(std::move(f)) {}
  void evaluate(double t, Field& u, Field& du) override {
    for (int i = 0; i < u.n_x(); ++i) {
      const auto [a, b] = f_(t, u.at(0, i), u.at(1, i));
      du.at(0, i) = a;
      du.at(1, i) = b;
    }
  }
  const Boundary& boundary() const override { return boundary_; }

 private:
  Boundary boundary_;
  Function f_;
};

/// P = decay.
class Decay final : public ImplicitPart {
 public:
  explicit Decay(double rate) : rate_(rate) {}
  void solve(double, double h, const Field&, Field& b, Work&) override {
    for (int s = 0; s < b.n_species(); ++s) {
      for (int i = 0; i < b.n_x(); ++i) b.at(s, i) /= 1.0 + h * rate_;
    }
  }

 private:
  double rate_;
};

class SpectralDeferredCorrectionTest : public ::testing::Test {
 protected:
  SpectralDeferredCorrectionTest() : comm_(MPI_COMM_SELF), decomposition_(comm_, Grid{1, {2, 1}}, {1, 1}, 1) {}

  struct Result {
    double u, v;
    std::int64_t evaluations;
    Progress progress;
  };

  Result solve(Equations::Function f, double decay, double u0, double v0, double end, int steps, Options o) {
    Equations equations(decomposition_.grid(), std::move(f));
    Decay part(decay);
    if (steps > 0) o.fixed_step = end / steps;
    Field u(decomposition_, 2, 0);
    for (int i = 0; i < 2; ++i) u.at(0, i) = u0, u.at(1, i) = v0;
    SpectralDeferredCorrection method(u, equations, part, nullptr, o);
    Schedule schedule;
    schedule.end = end;
    Result r{};
    Observer nobody;
    evolve(method, schedule, u, r.progress, nobody);
    EXPECT_EQ(u.at(0, 0), u.at(0, 1));
    r.u = u.at(0, 0), r.v = u.at(1, 0);
    r.evaluations = method.evaluations();
    return r;
  }

  /// u' = (-1/20 - 2 pi i) u to t = 20 from 1, the decay implicit: equation (4-1).
  double dahlquist_error(int steps, Options o) {
    constexpr double alpha = -0.05, beta = -2.0 * M_PI;
    const Result r = solve(
        [](double, double u, double v) {
          return std::array{alpha * u - beta * v, beta * u + alpha * v};
        },
        -alpha, 1.0, 0.0, 20.0, steps, o);
    return std::abs(std::complex<double>(r.u, r.v) - std::exp(std::complex<double>(alpha, beta) * 20.0));
  }

  double dahlquist_order(Options o) {
    const double coarse = dahlquist_error(120, o), fine = dahlquist_error(160, o);
    return std::log(coarse / fine) / std::log(160.0 / 120.0);
  }

  /// Van der Pol's equation (4-4), (4-5) to t = 4, explicit: largest error, and evaluations.
  std::pair<double, std::int64_t> van_der_pol(int steps, Options o) {
    const Result r = solve(
        [](double, double u, double v) {
          return std::array{v, -u + (1.0 - u * u) * v};
        },
        0.0, 2.0, 2.0 / 3.0, 4.0, steps, o);
    evaluations_ = r.evaluations;
    progress_ = r.progress;
    return {std::max(std::abs(r.u + 1.91423981220481877556), std::abs(r.v - 0.448031279557519709566)), r.evaluations};
  }

  static Options legendre(int m, int k, int corrections) {
    Options o;
    o.nodes = NodeFamily::gauss_legendre;
    o.node_count = m;
    o.starting_order = k;
    o.corrections = corrections;
    return o;
  }
  static Options radau(int m, int k, int corrections) {
    Options o = legendre(m, k, corrections);
    o.nodes = NodeFamily::gauss_radau;
    return o;
  }
  static Options inconsistent(Options o) {
    o.consistent = false;
    return o;
  }
  static Options ending(Options o, Options::FinalUpdate final_update) {
    o.final_update = final_update;
    return o;
  }

  Communicator comm_;
  Decomposition decomposition_;
  std::int64_t evaluations_ = 0;
  Progress progress_;
};

TEST_F(SpectralDeferredCorrectionTest, SixLegendreNodesHaveOrderTwelve) {
  for (int k = 1; k <= 5; ++k) {
    const Options o = ending(legendre(6, k, 12 - k), Options::FinalUpdate::extrapolation);
    EXPECT_NEAR(dahlquist_order(o), 12.0, 0.9) << "consistent, k = " << k;
    EXPECT_NEAR(dahlquist_order(inconsistent(o)), 12.0, 0.25) << "inconsistent, k = " << k;
  }
}

TEST_F(SpectralDeferredCorrectionTest, SixRadauNodesHaveOrderEleven) {
  for (int k = 1; k <= 5; ++k) {
    const Options o = radau(6, k, 11 - k);
    EXPECT_NEAR(dahlquist_order(o), 11.0, 0.6) << "consistent, k = " << k;
    EXPECT_NEAR(dahlquist_order(inconsistent(o)), 11.0, 0.25) << "inconsistent, k = " << k;
  }
}

TEST_F(SpectralDeferredCorrectionTest, ErrorsOfTheDahlquistProblemAreThoseOfAnIndependentImplementation) {
  // Theirs have exact history data instead of a ramp, hence the tolerance.
  const auto expect = [&](double theirs, int steps, Options o) {
    const double ours = dahlquist_error(steps, o);
    EXPECT_NEAR(ours / theirs, 1.0, 0.1) << "N = " << steps << ": " << ours << " and " << theirs;
  };
  using enum Options::FinalUpdate;
  expect(2.42e-8, 80, ending(legendre(6, 3, 9), extrapolation));
  expect(1.52e-10, 120, ending(legendre(6, 3, 9), extrapolation));
  expect(1.04e-6, 80, inconsistent(ending(legendre(6, 3, 9), extrapolation)));
  expect(1.06e-6, 80, inconsistent(ending(legendre(6, 1, 11), extrapolation)));
  expect(1.82e-8, 80, legendre(6, 3, 9));
  expect(8.46e-7, 80, radau(6, 3, 8));
  expect(7.35e-9, 120, radau(6, 3, 8));
  expect(1.43e-7, 120, inconsistent(radau(6, 3, 8)));
  expect(4.19e-7, 80, radau(6, 1, 10));
}

TEST_F(SpectralDeferredCorrectionTest, EveryCorrectionAddsAnOrderUpToTheQuadratures) {
  // Four Radau nodes, q = 7: min(k + L, 7) with the last node, one more with quadrature.
  using enum Options::FinalUpdate;
  const auto order = [&](Options o, int n) { return std::log(van_der_pol(n, o).first / van_der_pol(2 * n, o).first) / std::log(2.0); };
  for (int corrections = 1; corrections <= 8; ++corrections) {
    const int n = corrections < 4 ? 320 : 32;  // above round-off, in the asymptotic range
    const double last = std::min(1 + corrections, 7);
    const double quadrature_order = std::min(2 + corrections, 7);
    EXPECT_NEAR(order(ending(radau(4, 1, corrections), last_node), n), last, 0.5) << corrections;
    EXPECT_NEAR(order(ending(radau(4, 1, corrections), quadrature), n), quadrature_order, 0.5) << corrections;
  }
}

TEST_F(SpectralDeferredCorrectionTest, VanDerPolErrorsAndCountsAreThoseOfAnIndependentImplementation) {
  struct Row {
    Options o;
    std::int64_t evaluations;
    double error;
    bool legendre;
  };
  const std::vector<Row> rows = {{legendre(2, 1, 3), 289, 8.1e-6, true}, {legendre(3, 1, 5), 609, 2.1e-8, true},
                                 {legendre(4, 1, 7), 529, 1.1e-8, true}, {legendre(6, 1, 11), 585, 1.3e-9, true},
                                 {radau(3, 1, 4), 481, 1.8e-6, false},   {radau(4, 1, 6), 897, 6.9e-10, false},
                                 {radau(6, 1, 10), 529, 1.9e-8, false},  {radau(6, 3, 8), 877, 1.54e-11, false}};
  for (const Row& row : rows) {
    const int each = row.o.node_count * (row.o.corrections + 1) + (row.legendre ? 1 : 0);
    const int extra = row.o.node_count * (row.o.starting_order - 1);  // of the first step
    const int steps = static_cast<int>((row.evaluations - 1 - (row.o.starting_order > 1 ? extra : 0)) / each);
    const auto [error, evaluations] = van_der_pol(steps, row.o);
    EXPECT_NEAR(static_cast<double>(evaluations), static_cast<double>(row.evaluations), 1.0 + extra) << row.o.node_count;
    EXPECT_NEAR(std::log10(error / row.error), 0.0, 0.15) << "m = " << row.o.node_count << ": " << error << " and " << row.error;
  }
}

TEST_F(SpectralDeferredCorrectionTest, TheAlternativeCorrectionIsTheSameOneForLinearProblems) {
  Options o = radau(4, 1, 6);
  const double standard = dahlquist_error(60, o);
  o.correction = Options::Correction::alternative;
  EXPECT_NEAR(dahlquist_error(60, o), standard, 1e-12);
}

TEST_F(SpectralDeferredCorrectionTest, TheAlternativeCorrectionIsRefusedWhereItDoesNotConverge) {
  for (Options o : {radau(4, 2, 5), inconsistent(radau(4, 1, 6))}) {
    o.correction = Options::Correction::alternative;
    try {
      dahlquist_error(60, o);
      FAIL();
    } catch (const Error& e) {
      EXPECT_EQ(e.kind(), ErrorKind::input);
      EXPECT_NE(std::string(e.what()).find("starting_order = 1"), std::string::npos);
    }
  }
}

TEST_F(SpectralDeferredCorrectionTest, AccelerationReachesCollocationInAsManyCorrectionsAsThereAreUnknowns) {
  // Linear, so this is GMRES: a scalar equation on m nodes is solved after m corrections. Half of the decay is implicit.
  const auto result = [&](int corrections, bool accelerate) {
    Options o = radau(6, 1, corrections);
    o.accelerate = accelerate;
    return solve([](double, double u, double v) { return std::array{-20.0 * u, -20.0 * v}; }, 10.0, 1.0, 1.0, 1.0, 1, o).u;
  };
  const double collocation = result(300, false);
  EXPECT_NEAR(result(7, true), collocation, 1e-11);
  EXPECT_GT(std::abs(result(7, false) - collocation), 1e-6);
}

TEST_F(SpectralDeferredCorrectionTest, AdaptiveErrorsFollowTheTolerance) {
  double before = 1.0;
  for (double tolerance : {1e-4, 1e-6, 1e-8, 1e-10}) {
    Options o = radau(4, 2, 5);
    o.tolerance = tolerance;
    o.initial_step = 1e-2;
    const double error = van_der_pol(0, o).first;
    EXPECT_LT(error, 30.0 * tolerance) << tolerance;
    EXPECT_GT(error, 1e-4 * tolerance) << tolerance;
    EXPECT_LT(error, before);
    EXPECT_LE(progress_.rejected, progress_.accepted / 3 + 2) << tolerance;
    before = error;
  }
}

TEST_F(SpectralDeferredCorrectionTest, AnUnstableStepIsAnErrorThatNamesTheKey) {
  // Explicit, far outside the region of stability.
  try {
    solve([](double, double u, double v) { return std::array{-1e4 * u, -1e4 * v}; }, 0.0, 1.0, 1.0, 100.0, 100, radau(4, 1, 6));
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::numerics);
    EXPECT_NE(std::string(e.what()).find("method.step"), std::string::npos);
  }
}

}  // namespace
}  // namespace stiffront
