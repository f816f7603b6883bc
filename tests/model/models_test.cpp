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
#include "stiffront/model/builtin/angiogenesis_chemotaxis.hpp"
#include "stiffront/model/builtin/brusselator.hpp"
#include "stiffront/model/builtin/bz.hpp"
#include "stiffront/model/builtin/bz2.hpp"
#include "stiffront/model/builtin/dahlquist.hpp"
#include "stiffront/model/builtin/discharge.hpp"
#include "stiffront/model/builtin/fitzhugh_nagumo.hpp"
#include "stiffront/model/builtin/flame.hpp"
#include "stiffront/model/builtin/gray_scott.hpp"
#include "stiffront/model/builtin/ignition.hpp"
#include "stiffront/model/builtin/kpp.hpp"
#include "stiffront/model/builtin/lambda_omega.hpp"
#include "stiffront/model/builtin/pulsating_flame.hpp"
#include "stiffront/model/builtin/pulse.hpp"
#include "stiffront/model/builtin/reduced_pulsating_flame.hpp"
#include "stiffront/model/builtin/slaved_oscillator.hpp"
#include "stiffront/model/builtin/van_der_pol.hpp"
#include "stiffront/solvers/model_registry.hpp"

namespace stiffront {
namespace {

template <class... M>
struct List {
  static constexpr std::size_t size = sizeof...(M);
  /// Calls f.template operator()<M>() for every model M.
  template <class F>
  static void for_each(F f) {
    const auto one = [&]<class Model>() {
      SCOPED_TRACE(Model::name);
      f.template operator()<Model>();
    };
    (one.template operator()<M>(), ...);
  }
};

using Models = List<Angiogenesis, AngiogenesisChemotaxis, Brusselator, Bz, Bz2, Dahlquist, Discharge, FitzhughNagumo, Flame, GrayScott,
                    Ignition, Kpp, LambdaOmega, PulsatingFlame, Pulse, ReducedPulsatingFlame, SlavedOscillator, VanDerPol>;

/// Models whose rates go beyond + - * /: there packs and doubles agree to a few units in the last place only.
template <class M>
constexpr bool has_elementary_functions =
    std::is_same_v<M, AngiogenesisChemotaxis> || std::is_same_v<M, PulsatingFlame> || std::is_same_v<M, ReducedPulsatingFlame> ||
    std::is_same_v<M, Flame> || std::is_same_v<M, Ignition> || std::is_same_v<M, Pulse>;

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
    if constexpr (std::is_same_v<M, Discharge>) {  // around the switching times of three pulses and the end of the electrode
      place.t = 2e-8 * place.t + 1e-6 * std::floor(3.0 * uniform_(engine_));
      place.x = 0.0095 + 0.001 * place.x;
    }
  }

  std::array<double, static_cast<std::size_t>(M::n_species)> u;
  Place<double> place;

 private:
  std::mt19937_64 engine_{12345};
  std::uniform_real_distribution<double> uniform_{0.0, 1.0};
};

template <class M>
using Matrix = std::array<std::array<double, static_cast<std::size_t>(M::n_species)>, static_cast<std::size_t>(M::n_species)>;

template <class M>
Matrix<M> dual_jacobian(const M& m, const Samples<M>& at) {
  Matrix<M> j;
  cell_jacobian(m, at.place.t, at.place.x, at.place.y, at.u.data(), j[0].data());
  return j;
}

template <class Row>
double largest(const Row& row) {
  double r = 0.0;
  for (double x : row) r = std::max(r, std::abs(x));
  return r;
}

bool same_bits(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }

// The step is far below round-off and there is no difference to cancel: exact to units in the last place of the terms summed, whose
// size is that of the row's largest entry, or, where they cancel, of its largest entry in any sample.
TEST(ModelsTest, DualJacobianIsThatOfAComplexStep) {
  Models::for_each([]<class M>() {
    constexpr std::size_t n = M::n_species;
    const M m;
    double terms[n] = {};
    Samples<M> before;
    for (int sample = 0; sample < samples; ++sample) {
      before.next();
      const Matrix<M> dual = dual_jacobian(m, before);
      for (std::size_t s = 0; s < n; ++s) terms[s] = std::max(terms[s], largest(dual[s]));
    }
    Samples<M> at;
    for (int sample = 0; sample < samples; ++sample) {
      at.next();
      const Matrix<M> dual = dual_jacobian(m, at);
      for (std::size_t k = 0; k < n; ++k) {
        std::complex<double> u[n];
        std::complex<double> du[n];
        for (std::size_t s = 0; s < n; ++s) u[s] = at.u[s];
        u[k].imag(1e-100);
        m.rates(u, du, at.place);
        for (std::size_t s = 0; s < n; ++s) {
          ASSERT_NEAR(dual[s][k], du[s].imag() * 1e100, 1e-13 * largest(dual[s]) + 4e-16 * terms[s])
              << "d rate " << s << " / d u" << k << ", sample " << sample;
        }
      }
    }
  });
}

TEST(ModelsTest, DualJacobianIsThatOfCentralDifferences) {
  Models::for_each([]<class M>() {
    constexpr std::size_t n = M::n_species;
    const M m;
    Samples<M> at;
    for (int sample = 0; sample < samples; ++sample) {
      at.next();
      const Matrix<M> dual = dual_jacobian(m, at);
      for (std::size_t k = 0; k < n; ++k) {
        const double h = 1e-5 * (at.u[k] + 1e-3);
        auto upper = at.u;
        auto lower = at.u;
        upper[k] += h;
        lower[k] -= h;
        double above[n];
        double below[n];
        m.rates(upper.data(), above, at.place);
        m.rates(lower.data(), below, at.place);
        const double step = upper[k] - lower[k];
        for (std::size_t s = 0; s < n; ++s) {
          // Differences lose what the rates lose by cancellation: one unit in the last place of the largest term over 2 h.
          const double rounding = 4e-16 * largest(dual[s]) * 200.0 / step;
          ASSERT_NEAR(dual[s][k], (above[s] - below[s]) / step, 1e-7 * largest(dual[s]) + rounding)
              << "d rate " << s << " / d u" << k << ", sample " << sample;
        }
      }
    }
  });
}

/// A pack of samples, evaluated once with plain packs and once with duals over packs.
template <class M>
struct PackOfCells {
  static constexpr std::size_t n = M::n_species;

  void set(int lane, const Samples<M>& at) {
    for (std::size_t s = 0; s < n; ++s) u[s].set(lane, at.u[s]);
    place.t.set(lane, at.place.t);
    place.x.set(lane, at.place.x);
    place.y.set(lane, at.place.y);
  }
  void evaluate() {
    const M m;
    for (std::size_t s = 0; s < n; ++s) v[s] = Dual<Pack, M::n_species>::variable(u[s], static_cast<int>(s));
    m.rates(u, du, place);
    m.rates(v, dv, place);
  }

  Pack u[n];
  Pack du[n];
  Dual<Pack, M::n_species> v[n];
  Dual<Pack, M::n_species> dv[n];
  Place<Pack> place;
};

TEST(ModelsTest, PacksGiveTheBitsOfDoubles) {
  Models::for_each([]<class M>() {
    constexpr std::size_t n = M::n_species;
    const M m;
    const auto agree = [](double a, double b) {
      return has_elementary_functions<M> ? std::abs(a - b) <= 1e-14 * (std::abs(a) + 50.0) : same_bits(a, b);
    };
    Samples<M> at;
    for (int sample = 0; sample < samples / pack_size; ++sample) {
      PackOfCells<M> cells;
      double rates[pack_size][n];
      Matrix<M> jacobian[pack_size];
      for (int l = 0; l < pack_size; ++l) {
        at.next();
        cells.set(l, at);
        m.rates(at.u.data(), rates[l], at.place);
        jacobian[l] = dual_jacobian(m, at);
      }
      cells.evaluate();
      for (int l = 0; l < pack_size; ++l) {
        for (std::size_t s = 0; s < n; ++s) {
          ASSERT_TRUE(agree(cells.du[s][l], rates[l][s])) << "rate " << s << ": " << cells.du[s][l] << " and " << rates[l][s];
          ASSERT_TRUE(same_bits(cells.dv[s].value[l], cells.du[s][l])) << "value of dual " << s;
          for (std::size_t k = 0; k < n; ++k) {
            ASSERT_TRUE(agree(cells.dv[s].derivative[k][l], jacobian[l][s][k]))
                << "d rate " << s << " / d u" << k << ": " << cells.dv[s].derivative[k][l] << " and " << jacobian[l][s][k];
          }
        }
      }
    }
  });
}

TEST(ModelsTest, ACellHasTheSameBitsInEveryLaneAndCompany) {
  Models::for_each([]<class M>() {
    constexpr std::size_t n = M::n_species;
    Samples<M> at;
    for (int sample = 0; sample < samples / pack_size; ++sample) {
      PackOfCells<M> cells;
      PackOfCells<M> turned;
      const auto last = [](int l) { return pack_size - 1 - l; };
      for (int l = 0; l < pack_size; ++l) {
        at.next();
        cells.set(l, at);
        turned.set(last(l), at);
      }
      // In the turned pack, one lane has another cell.
      at.next();
      turned.set(last(0), at);
      cells.evaluate();
      turned.evaluate();
      for (int l = 1; l < pack_size; ++l) {
        for (std::size_t s = 0; s < n; ++s) {
          ASSERT_TRUE(same_bits(cells.du[s][l], turned.du[s][last(l)])) << "rate " << s << ", lane " << l;
          for (std::size_t k = 0; k < n; ++k) {
            ASSERT_TRUE(same_bits(cells.dv[s].derivative[k][l], turned.dv[s].derivative[k][last(l)])) << s << ", " << k << ", lane " << l;
          }
        }
      }
    }
  });
}

TEST(ModelsTest, AreRegisteredUnderTheirNamesAndEveryParameterCounts) {
  ModelRegistry registry;
  register_builtin_models(registry);
  Models::for_each([&]<class M>() {
    ASSERT_TRUE(registry.contains(M::name));
    EXPECT_EQ(std::string(M::name).find('_'), std::string::npos) << "names in case files have hyphens";
    const auto kernels = registry.make(M::name, {});
    EXPECT_EQ(kernels->description().n_species(), M::n_species);
    EXPECT_EQ(kernels->description().diffusion.size(), static_cast<std::size_t>(M::n_species));
    const M fresh;
    for (const auto& p : kernels->description().parameters) {
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
        if constexpr (ModelWithTransport<M>) {
          M other;
          for (const Parameter<M>& q : M::parameters) {
            if (p.name == q.name) other.*q.member *= 1.01;
          }
          const double* u = at.u.data();
          other.transport(u, u, u, du, at.place);
          fresh.transport(u, u, u, du_fresh, at.place);
          for (int s = 0; s < M::n_species; ++s) differs |= du[s] != du_fresh[s];
        }
      }
      EXPECT_TRUE(differs) << p.name;
    }
  });
}

TEST(ModelsTest, ProfilesAreFiniteAndOfTheModelsScale) {
  Models::for_each([]<class M>() {
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
                ASSERT_LE(std::abs(u[s]), (std::is_same_v<M, Discharge> ? 1e14
                                           : std::is_same_v<M, Bz>      ? 1e3
                                                                        : 10.0))
                    << p.name << " at " << i << ", " << j;
                if (i + j == 0) first[s] = u[s];
                uniform &= u[s] == first[s];
              }
            }
          }
          EXPECT_EQ(uniform, std::string(p.name).ends_with("-uniform")) << p.name;
        }
      }
    }
  });
}

TEST(ModelsTest, TheseTestsCoverEveryBuiltInModel) {
  ModelRegistry registry;
  register_builtin_models(registry);
  EXPECT_EQ(registry.descriptions().size(), Models::size) << "list the new model at the top of this file";
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
  // 0 <= 20 x - 0.05 < 0.15 on 4001 points: x from 1/400 to below 1/100.
  Grid grid;
  grid.points = {4001, 1};
  const Bz m;
  for (std::int64_t i = 0; i <= 400; ++i) {
    double u[3];
    Bz::front(m, grid, i, 0, u);
    const double rest = m.q * (m.f + 1.0) / (m.f - 1.0);
    EXPECT_EQ(u[1], i >= 200 ? 0.0 : (i >= 10 && i < 40 ? 0.8 : rest)) << i;
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

TEST(ModelsTest, DischargeHasTheRatesOfMorrowAndLowkeAtFortyKilovoltsPerCentimetre) {
  const Discharge m;
  EXPECT_NEAR(m.ionisation_rate(), 1.047754e9, 1e3);
  EXPECT_NEAR(m.attachment_rate(), 1.820465e8, 1e2);
}

TEST(ModelsTest, DischargeSwitchesAtTheEndsOfPulsesAndPeriodsWhateverTheRounding) {
  const Discharge m;
  const double u[3] = {1.0, 0.0, 0.0};
  double du[3];
  const auto on = [&](double t, double x) {
    cell_rates(m, t, x, 0.0, u, du);
    return du[2] > 0.0;
  };
  for (int k = 0; k < 100; ++k) {
    const double start = k * m.period;
    const double end = start + m.pulse;
    for (double x : {0.0, 20 * (0.5 / 1000), std::nextafter(0.01, 1.0)}) {
      for (double rounding : {-4e-16, 0.0, 4e-16}) {
        EXPECT_FALSE(on(start * (1.0 + rounding), x)) << k;
        EXPECT_TRUE(on(end * (1.0 + rounding), x)) << k;
      }
      EXPECT_TRUE(on(start + 1e-6 * m.pulse, x)) << k;
      EXPECT_TRUE(on(end - 1e-6 * m.pulse, x)) << k;
      EXPECT_FALSE(on(end + 1e-6 * m.pulse, x)) << k;
      EXPECT_FALSE(on(start + 0.5 * m.period, x)) << k;
    }
    EXPECT_FALSE(on(0.5 * (start + end), 21 * (0.5 / 1000))) << k;
  }
}

TEST(ModelsTest, DischargeConservesChargeWithAndWithoutField) {
  const Discharge m;
  for (double t : {0.5 * m.pulse, 2.0 * m.pulse}) {
    const double u[3] = {3e14, 5e14, 1e14};
    double du[3];
    cell_rates(m, t, 0.0, 0.0, u, du);
    EXPECT_NE(du[0], 0.0);
    EXPECT_NEAR(du[1] - du[0] - du[2], 0.0, 1e-15 * 1.2e9 * u[1]);
  }
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
