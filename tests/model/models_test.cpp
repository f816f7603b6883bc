// SPDX-License-Identifier: BSD-3-Clause
// Every built-in model: its Jacobian by duals against two other derivatives, its bits on packs, its profiles.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <complex>
#include <cstring>
#include <random>
#include <string>
#include <vector>

#include "stiffront/core/error.hpp"
#include "stiffront/model/builtin/angiogenesis.hpp"
#include "stiffront/model/builtin/brusselator.hpp"
#include "stiffront/model/builtin/bz.hpp"
#include "stiffront/model/builtin/bz2.hpp"
#include "stiffront/model/builtin/fitzhugh_nagumo.hpp"
#include "stiffront/model/builtin/flame.hpp"
#include "stiffront/model/builtin/gray_scott.hpp"
#include "stiffront/model/builtin/ignition.hpp"
#include "stiffront/model/builtin/kpp.hpp"
#include "stiffront/model/builtin/lambda_omega.hpp"
#include "stiffront/model/builtin/pulse.hpp"
#include "stiffront/model/builtin/slaved_oscillator.hpp"
#include "stiffront/solvers/model_registry.hpp"

namespace stiffront {
namespace {

using Models = ::testing::Types<Angiogenesis, Brusselator, Bz, Bz2, FitzhughNagumo, Flame, GrayScott, Ignition, Kpp, LambdaOmega, Pulse,
                                SlavedOscillator>;
constexpr std::size_t n_models = 12;

constexpr int samples = 1000;

/// States a run may meet, and places in time and space around the model's own scales.
template <class M>
class Samples {
 public:
  void next() {
    for (int s = 0; s < M::n_species; ++s) {
      const double scale = std::is_same_v<M, Bz> && s == 0 ? 200.0 : 1.2;  // bromide goes up to f/q
      u[static_cast<std::size_t>(s)] = scale * uniform_(engine_);
    }
    place = {uniform_(engine_), uniform_(engine_), uniform_(engine_)};
  }

  std::array<double, static_cast<std::size_t>(M::n_species)> u;
  Place<double> place;

 private:
  std::mt19937_64 engine_{12345};
  std::uniform_real_distribution<double> uniform_{0.0, 1.0};
};

template <class M>
class ModelTest : public ::testing::Test {
 protected:
  static constexpr int n = M::n_species;
  using Matrix = std::array<double, static_cast<std::size_t>(n* n)>;

  static Matrix dual_jacobian(const M& m, const Samples<M>& at) {
    Matrix j;
    cell_jacobian(m, at.place.t, at.place.x, at.place.y, at.u.data(), j.data());
    return j;
  }
  static double largest(const Matrix& j, int row) {
    double r = 0.0;
    for (int k = 0; k < n; ++k) r = std::max(r, std::abs(j[static_cast<std::size_t>(row * n + k)]));
    return r;
  }
};

class ModelNames {
 public:
  template <class M>
  static std::string GetName(int) {
    std::string name = M::name;
    for (char& c : name) c = c == '-' ? '_' : c;
    return name;
  }
};

TYPED_TEST_SUITE(ModelTest, Models, ModelNames);

// The step is far below round-off and there is no difference to cancel: exact to units in the last place of the terms summed, whose
// size is that of the row's largest entry, or, where they cancel, of its largest entry in any sample.
TYPED_TEST(ModelTest, DualJacobianIsThatOfAComplexStep) {
  using M = TypeParam;
  constexpr int n = M::n_species;
  const M m;
  double terms[n] = {};
  Samples<M> before;
  for (int sample = 0; sample < samples; ++sample) {
    before.next();
    const auto dual = TestFixture::dual_jacobian(m, before);
    for (int s = 0; s < n; ++s) terms[s] = std::max(terms[s], TestFixture::largest(dual, s));
  }
  Samples<M> at;
  for (int sample = 0; sample < samples; ++sample) {
    at.next();
    const auto dual = TestFixture::dual_jacobian(m, at);
    for (int k = 0; k < n; ++k) {
      std::complex<double> u[n];
      std::complex<double> du[n];
      for (int s = 0; s < n; ++s) u[s] = at.u[static_cast<std::size_t>(s)];
      u[k].imag(1e-100);
      m.rates(u, du, at.place);
      for (int s = 0; s < n; ++s) {
        ASSERT_NEAR(dual[static_cast<std::size_t>(s * n + k)], du[s].imag() * 1e100, 1e-13 * TestFixture::largest(dual, s) + 4e-16 * terms[s])
            << "d rate " << s << " / d u" << k << ", sample " << sample;
      }
    }
  }
}

TYPED_TEST(ModelTest, DualJacobianIsThatOfCentralDifferences) {
  using M = TypeParam;
  constexpr int n = M::n_species;
  const M m;
  Samples<M> at;
  for (int sample = 0; sample < samples; ++sample) {
    at.next();
    const auto dual = TestFixture::dual_jacobian(m, at);
    for (int k = 0; k < n; ++k) {
      double u[n];
      double above[n];
      double below[n];
      std::copy(at.u.begin(), at.u.end(), u);
      const double h = 1e-5 * (u[k] + 1e-3);
      u[k] = at.u[static_cast<std::size_t>(k)] + h;
      const double upper = u[k];
      m.rates(u, above, at.place);
      u[k] = at.u[static_cast<std::size_t>(k)] - h;
      const double lower = u[k];
      m.rates(u, below, at.place);
      for (int s = 0; s < n; ++s) {
        // Differences lose what the rates lose by cancellation: one unit in the last place of the largest term over 2 h.
        const double rounding = 4e-16 * TestFixture::largest(dual, s) * 200.0 / (upper - lower);
        ASSERT_NEAR(dual[static_cast<std::size_t>(s * n + k)], (above[s] - below[s]) / (upper - lower),
                    1e-7 * TestFixture::largest(dual, s) + rounding)
            << "d rate " << s << " / d u" << k << ", sample " << sample;
      }
    }
  }
}

TYPED_TEST(ModelTest, PacksGiveTheBitsOfDoublesInEveryLane) {
  using M = TypeParam;
  constexpr int n = M::n_species;
  const M m;
  Samples<M> at;
  for (int sample = 0; sample < samples / pack_size; ++sample) {
    Pack u[n];
    Dual<Pack, n> v[n];
    Place<Pack> place;
    double rates[pack_size][n];
    typename TestFixture::Matrix jacobians[pack_size];
    for (int l = 0; l < pack_size; ++l) {
      at.next();
      for (int s = 0; s < n; ++s) u[s].set(l, at.u[static_cast<std::size_t>(s)]);
      place.t.set(l, at.place.t);
      place.x.set(l, at.place.x);
      place.y.set(l, at.place.y);
      m.rates(at.u.data(), rates[l], at.place);
      jacobians[l] = TestFixture::dual_jacobian(m, at);
    }
    for (int s = 0; s < n; ++s) v[s] = Dual<Pack, n>::variable(u[s], s);
    Pack du[n];
    Dual<Pack, n> dv[n];
    m.rates(u, du, place);
    m.rates(v, dv, place);
    for (int l = 0; l < pack_size; ++l) {
      for (int s = 0; s < n; ++s) {
        const double x = du[s][l];
        const double y = dv[s].value[l];
        ASSERT_EQ(std::memcmp(&x, &rates[l][s], sizeof x), 0) << "rate " << s << ", lane " << l << ": " << x << " and " << rates[l][s];
        ASSERT_EQ(std::memcmp(&y, &rates[l][s], sizeof y), 0) << "value of dual " << s << ", lane " << l;
        for (int k = 0; k < n; ++k) {
          const double d = dv[s].derivative[k][l];
          ASSERT_EQ(std::memcmp(&d, &jacobians[l][static_cast<std::size_t>(s * n + k)], sizeof d), 0)
              << "d rate " << s << " / d u" << k << ", lane " << l;
        }
      }
    }
  }
}

TYPED_TEST(ModelTest, IsRegisteredUnderItsNameWithItsDefaults) {
  using M = TypeParam;
  ModelRegistry registry;
  register_builtin_models(registry);
  ASSERT_TRUE(registry.contains(M::name));
  EXPECT_EQ(std::string(M::name).find('_'), std::string::npos) << "names in case files have hyphens";
  const auto kernels = registry.make(M::name, {});
  EXPECT_EQ(kernels->description().n_species(), M::n_species);
  EXPECT_EQ(kernels->description().diffusion.size(), static_cast<std::size_t>(M::n_species));
  const M fresh;
  for (const auto& p : kernels->description().parameters) {
    EXPECT_TRUE(std::isfinite(p.value)) << p.name;
    // A parameter that changes no rate anywhere would be a parameter that is not there.
    const auto changed = registry.make(M::name, {{p.name, 1.01 * p.value}});
    Samples<M> at;
    bool differs = false;
    for (int sample = 0; sample < samples && !differs; ++sample) {
      at.next();
      double du[M::n_species];
      double du_fresh[M::n_species];
      changed->rates_at(at.place.t, at.place.x, at.place.y, at.u.data(), du);
      fresh.rates(at.u.data(), du_fresh, at.place);
      for (int s = 0; s < M::n_species; ++s) differs |= du[s] != du_fresh[s];
    }
    EXPECT_TRUE(differs) << p.name;
  }
}

TYPED_TEST(ModelTest, ProfilesAreFiniteAndOfTheModelsScale) {
  using M = TypeParam;
  const M m;
  for (const Profile<M>& p : M::profiles) {
    for (int dimension = p.dimension; dimension <= 2; ++dimension) {
      for (const bool periodic : {false, true}) {
        Grid grid;
        grid.dimension = dimension;
        grid.points = {97, dimension == 2 ? 61 : 1};
        grid.periodic = {periodic, periodic && dimension == 2};
        grid.upper = {10.0, 10.0};
        bool uniform = true;
        double first[M::n_species] = {};
        for (std::int64_t j = 0; j < grid.points[1]; ++j) {
          for (std::int64_t i = 0; i < grid.points[0]; ++i) {
            double u[M::n_species];
            p.evaluate(m, grid, i, j, u);
            for (int s = 0; s < M::n_species; ++s) {
              ASSERT_TRUE(std::isfinite(u[s])) << p.name << " at " << i << ", " << j;
              ASSERT_LE(std::abs(u[s]), (std::is_same_v<M, Bz> ? 1e3 : 10.0)) << p.name << " at " << i << ", " << j;
              if (i + j == 0) first[s] = u[s];
              uniform &= u[s] == first[s];
            }
          }
        }
        EXPECT_EQ(uniform, std::string(p.name).ends_with("-uniform")) << p.name;
      }
    }
  }
}

TEST(ModelsTest, TheseTestsCoverEveryBuiltInModel) {
  ModelRegistry registry;
  register_builtin_models(registry);
  EXPECT_EQ(registry.descriptions().size(), n_models) << "list the new model at the top of this file";
}

TEST(ModelsTest, UnknownNamesAreInputErrorsThatSayWhichKey) {
  ModelRegistry registry;
  register_builtin_models(registry);
  const auto expect = [](auto&& f, const std::string& part) {
    try {
      f();
      ADD_FAILURE() << "no error about " << part;
    } catch (const Error& e) {
      EXPECT_EQ(e.kind(), ErrorKind::input);
      EXPECT_NE(std::string(e.what()).find(part), std::string::npos) << e.what();
    }
  };
  expect([&] { registry.make("bzz", {}); }, "model.name");
  expect([&] { registry.make("bz", {{"nu", 1.0}}); }, "model.parameters.nu");
  const Communicator comm(MPI_COMM_SELF);
  Grid grid;
  grid.points = {11, 1};
  const Decomposition d(comm, grid, {0, 0}, 1);
  const auto bz = registry.make("bz", {});
  Field u(d, 3, 1);
  expect([&] { bz->initialise("bz-fronts", u); }, "initial.profile");
  expect([&] { bz->initialise("bz-spiral", u); }, "2 dimensions");
}

TEST(ModelsTest, BzIgnitesTheStripOfItsPaperByIndex) {
  // 0 <= 20 x - 0.05 <= 0.15 on 4001 points: x from 1/400 to 1/100.
  Grid grid;
  grid.points = {4001, 1};
  const Bz m;
  for (std::int64_t i = 0; i <= 400; ++i) {
    double u[3];
    Bz::front(m, grid, i, 0, u);
    const double rest = m.q * (m.f + 1.0) / (m.f - 1.0);
    EXPECT_EQ(u[1], i >= 200 ? 0.0 : (i >= 10 && i <= 40 ? 0.8 : rest)) << i;
    // a is in balance: f c = (q + b) a.
    EXPECT_NEAR(u[0] * (m.q + u[1]), m.f * u[2], 1e-15) << i;
  }
}

TEST(ModelsTest, Bz2IsTheLimitOfBz) {
  const Bz full;
  const Bz2 reduced;
  const double b = 0.3;
  const double c = 0.1;
  const double abc[3] = {full.f * c / (full.q + b), b, c};
  double rate3[3];
  double rate2[2];
  cell_rates(full, 0.0, 0.0, 0.0, abc, rate3);
  cell_rates(reduced, 0.0, 0.0, 0.0, abc + 1, rate2);
  EXPECT_NEAR(rate3[0] * full.mu, 0.0, 1e-15);
  EXPECT_NEAR(rate3[1], rate2[0], 1e-12 * std::abs(rate2[0]));
  EXPECT_EQ(rate3[2], rate2[1]);
}

TEST(ModelsTest, KppFrontIsTheTravellingWave) {
  // u = 1 / (1 + exp(z)), z = k (x - c t) / sqrt 2, D = 1/k: -c u' = D u'' + k u^2 (1-u) with u' = -(k/sqrt 2) u (1-u).
  for (const double k : {1.0, 10.0, 100.0}) {
    Kpp m;
    m.k = k;
    Grid grid;
    grid.points = {5001, 1};
    grid.lower[0] = -70.0;
    grid.upper[0] = 70.0;
    const double slope = k / std::sqrt(2.0);
    for (std::int64_t i = 0; i < grid.points[0]; i += 7) {
      double u = 0.0;
      Kpp::front(m, grid, i, 0, &u);
      const double du = -slope * u * (1.0 - u);
      const double ddu = slope * slope * u * (1.0 - u) * (1.0 - 2.0 * u);
      double rate = 0.0;
      cell_rates(m, 0.0, 0.0, 0.0, &u, &rate);
      ASSERT_NEAR(-std::sqrt(0.5) * du, ddu / k + rate, 1e-13 * k);
      if (2 * i + 1 == grid.points[0]) {
        ASSERT_NEAR(u, 0.5, 1e-12 * k);
      }
    }
    double ends[2];
    Kpp::front(m, grid, 0, 0, &ends[0]);
    Kpp::front(m, grid, 5000, 0, &ends[1]);
    EXPECT_GT(ends[0], 1.0 - 1e-15);
    EXPECT_GE(ends[1], 0.0);
    EXPECT_LT(ends[1], 1e-15);
  }
}

TEST(ModelsTest, GrayScottSquareHasTwentyPointsOf256AndIsCentred) {
  const GrayScott m;
  Grid grid;
  grid.dimension = 2;
  grid.points = {256, 256};
  grid.periodic = {true, true};
  int ignited = 0;
  for (std::int64_t j = 0; j < 256; ++j) {
    for (std::int64_t i = 0; i < 256; ++i) {
      double u[2];
      GrayScott::square(m, grid, i, j, u);
      const bool inside = i >= 118 && i <= 137 && j >= 118 && j <= 137;
      ASSERT_EQ(u[0], inside ? 0.5 : 1.0) << i << ", " << j;
      ASSERT_EQ(u[1], inside ? 0.25 : 0.0) << i << ", " << j;
      ignited += inside;
    }
  }
  EXPECT_EQ(ignited, 400);
}

TEST(ModelsTest, PulseFeedsAfterOnAndUntilOff) {
  const Pulse m;
  const double u[2] = {0.0, 0.0};
  double du[2];
  for (const double t : {0.0, 0.3, std::nextafter(0.6, 1.0), 1.0}) {
    cell_rates(m, t, 0.5, 0.0, u, du);
    EXPECT_EQ(du[0], 0.0) << t;
  }
  for (const double t : {std::nextafter(0.3, 1.0), 0.45, 0.6}) {
    cell_rates(m, t, 0.5, 0.0, u, du);
    EXPECT_EQ(du[0], 50.0) << t;
  }
  // Lanes of different times do not disturb each other.
  Pack v[2] = {0.0, 0.0};
  Pack dv[2];
  Place<Pack> place{0.0, 0.5, 0.0};
  place.t.set(1, 0.45);
  m.rates(v, dv, place);
  for (int l = 0; l < pack_size; ++l) EXPECT_EQ(dv[0][l], l == 1 ? 50.0 : 0.0);
}

TEST(ModelsTest, ConservedSumsAreConserved) {
  // Fuel and heat turn into each other.
  Samples<Flame> at;
  for (int sample = 0; sample < samples; ++sample) {
    at.next();
    double du[2];
    Flame{}.rates(at.u.data(), du, at.place);
    ASSERT_EQ(du[0], -du[1]);
    Ignition{}.rates(at.u.data(), du, at.place);
    ASSERT_EQ(du[0], -du[1]);
  }
}

}  // namespace
}  // namespace stiffront
