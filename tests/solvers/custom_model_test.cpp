// SPDX-License-Identifier: BSD-3-Clause
// Models written as text, compiled to kernels: against built-in models, exact and published solutions, and their own mistakes.
#include "stiffront/solvers/custom_model.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "stiffront/core/entry_error.hpp"
#include "stiffront/model/builtin/bz.hpp"
#include "stiffront/solvers/model_registry.hpp"
#include "stiffront/space/conserved_totals.hpp"

namespace stiffront {
namespace {

CustomModel bz_text() {
  CustomModel model;
  model.species = {"a", "b", "c"};
  model.parameters = {{"epsilon", 1e-2}, {"mu", 1e-5}, {"f", 1.6}, {"q", 2e-3}};
  model.diffusion = {{"a", 2.5e-3}, {"b", "2.5*mu*100"}, {"c", "1.5e-3"}};
  model.reaction = {{"a", "(f*c - q*a - a*b)/mu"}, {"c", "b - c"}, {"b", "(q*a - a*b + b*(1 - b))/epsilon"}};
  return model;
}

Grid line(int n) {
  Grid grid;
  grid.points = {n, 1};
  return grid;
}

class CustomModelTest : public ::testing::Test {
 protected:
  /// Integrates every cell of a field from 0 to t.
  static void integrate(const ModelKernels& kernels, Field& u, double t, double tolerance, double t_begin = 0.0) {
    CellTolerances tolerances;
    tolerances.relative = tolerance;
    tolerances.absolute.assign(static_cast<std::size_t>(kernels.n_species()), 1e-4 * tolerance);
    const auto solver = kernels.make_radau5(tolerances);
    std::vector<double> hint(static_cast<std::size_t>(u.n_x()), 0.0);
    std::vector<float> cost(hint.size());
    Work work;
    const auto failure = solver->advance(t_begin, t - t_begin, u, u, FreeBox{0, u.n_x(), 0, 1}, hint, cost, work);
    ASSERT_FALSE(failure.has_value()) << failure->reason;
  }

  Communicator comm{MPI_COMM_SELF};
  Grid grid = line(101);
  Decomposition d{comm, grid, {0, 0}, 1};
};

TEST_F(CustomModelTest, IsDescribedLikeABuiltInModel) {
  const auto kernels = make_custom_model(bz_text());
  const ModelDescription& description = kernels->description();
  EXPECT_EQ(description.name, "custom");
  EXPECT_EQ(description.species, (std::vector<std::string>{"a", "b", "c"}));
  EXPECT_EQ(description.diffusion, (std::vector<double>{2.5e-3, 2.5e-3, 1.5e-3}));
  ASSERT_EQ(description.parameters.size(), 4U);
  EXPECT_EQ(description.parameters[1].name, "mu");
  EXPECT_EQ(description.parameters[1].value, 1e-5);
  EXPECT_TRUE(description.conserved.empty());
}

TEST_F(CustomModelTest, BzHasTheKernelsOfTheBuiltInModel) {
  const auto custom = make_custom_model(bz_text());
  const ModelKernelsOf<Bz> built_in(std::map<std::string, double>{});
  Field u(d, 3, 1), direction(d, 3, 1), du(d, 3, 1), du_custom(d, 3, 1), product(d, 3, 1), product_custom(d, 3, 1);
  built_in.initialise("bz-front", u);
  for (int s = 0; s < 3; ++s) {
    for (int i = 0; i < 101; ++i) direction.at(s, i) = std::sin(0.3 * i + s);
  }
  const FreeBox box{0, 101, 0, 1};
  built_in.add_rates(0.0, u, du, box);
  custom->add_rates(0.0, u, du_custom, box);
  built_in.add_jacobian_product(0.0, u, direction, product, box);
  custom->add_jacobian_product(0.0, u, direction, product_custom, box);
  for (int s = 0; s < 3; ++s) {
    for (int i = 0; i < 101; ++i) {
      const double term = u.at(0, i) * (1.0 + u.at(1, i)) + u.at(2, i);
      const double size = term * (s == 0 ? 1e5 : s == 1 ? 1e2 : 1.0);
      EXPECT_NEAR(du_custom.at(s, i), du.at(s, i), 1e-14 * size);
      EXPECT_NEAR(product_custom.at(s, i), product.at(s, i), 1e-14 * (1.0 + u.at(0, i)) * 1e6);
    }
  }
  EXPECT_NEAR(custom->jacobian_bound(0.0, u, box), built_in.jacobian_bound(0.0, u, box), 1e-13 * built_in.jacobian_bound(0.0, u, box));
}

TEST_F(CustomModelTest, BzIsIntegratedLikeTheBuiltInModel) {
  const auto custom = make_custom_model(bz_text());
  const ModelKernelsOf<Bz> built_in(std::map<std::string, double>{});
  Field u(d, 3, 1), v(d, 3, 1);
  built_in.initialise("bz-front", u);
  v.copy_interior(u);
  integrate(built_in, u, 0.05, 1e-8);
  integrate(*custom, v, 0.05, 1e-8);
  for (int s = 0; s < 3; ++s) {
    for (int i = 0; i < 101; ++i) EXPECT_NEAR(v.at(s, i), u.at(s, i), 1e-9 * (1.0 + std::abs(u.at(s, i)))) << s << ", " << i;
  }
}

TEST_F(CustomModelTest, RobertsonsNetworkHasItsKnownSolution) {
  CustomModel model;
  model.species = {"A", "B", "C"};
  model.parameters = {{"k1", 0.04}, {"k2", 3e7}, {"k3", 1e4}};
  model.reactions = {{"A -> B", "k1", {}, true}, {"2 B -> B + C", "k2", {}, true}, {"B + C -> A + C", "k3", {}, true}};
  const auto kernels = make_custom_model(model);
  ASSERT_EQ(kernels->description().conserved.size(), 1U);
  EXPECT_EQ(kernels->description().conserved[0].text, "A + B + C");
  Field u(d, 3, 1);
  for (int i = 0; i < 101; ++i) u.at(0, i) = 1.0;
  const double total = conserved_totals(kernels->description().conserved, u)[0];
  EXPECT_NEAR(total, 1.0, 1e-15);  // the grid is the unit interval
  integrate(*kernels, u, 40.0, 1e-11);
  // Robertson 1966, whose figures agree with these; the digits are from Radau IIA in a program of its own, with 400 and 800 graded
  // steps that agree to 1e-12.
  EXPECT_NEAR(u.at(0, 50), 0.7158270687194, 1e-10);
  EXPECT_NEAR(u.at(1, 50), 9.185534764575e-6, 1e-15);
  EXPECT_NEAR(u.at(2, 50), 0.2841637457459, 1e-10);
  EXPECT_NEAR(conserved_totals(kernels->description().conserved, u)[0], total, 1e-13);
}

TEST_F(CustomModelTest, ExpressionsAndNetworkAddUp) {
  CustomModel network;
  network.species = {"X", "Y"};
  network.parameters = {{"A", 1.0}, {"B", 3.0}};
  network.reactions = {{"0 -> X", "A", {}, true}, {"X -> Y", "B", {}, true}, {"2 X + Y -> 3 X", 1.0, {}, true}};
  network.reaction = {{"X", "-X"}};
  CustomModel expressions = network;
  expressions.reactions.clear();
  expressions.reaction = {{"X", "A + X^2*Y - (B + 1)*X"}, {"Y", "B*X - X^2*Y"}};
  const auto a = make_custom_model(network);
  const auto b = make_custom_model(expressions);
  const double u[max_custom_species] = {1.3, 2.7};
  double da[max_custom_species], db[max_custom_species];
  a->rates_at(0, 0, 0, u, da);
  b->rates_at(0, 0, 0, u, db);
  for (int s = 0; s < 2; ++s) EXPECT_NEAR(da[s], db[s], 1e-14);
  EXPECT_TRUE(a->description().conserved.empty());
}

TEST_F(CustomModelTest, RatesMayDependOnTimeAndPlace) {
  // u' = (1 + x) cos(t) u and a species that is left alone
  CustomModel model;
  model.species = {"u", "v"};
  model.parameters = {{"k", 1.0}};
  model.reaction = {{"u", "(k + x)*cos(t)*u"}, {"v", "0"}};
  const auto kernels = make_custom_model(model);
  Field u(d, 2, 1);
  for (int i = 0; i < 101; ++i) u.at(0, i) = u.at(1, i) = 1.0;
  integrate(*kernels, u, 2.5, 1e-10, 0.5);
  for (int i = 0; i < 101; ++i) {
    EXPECT_NEAR(u.at(0, i), std::exp((1.0 + grid.position(0, i)) * (std::sin(2.5) - std::sin(0.5))), 1e-9);
    EXPECT_EQ(u.at(1, i), 1.0);
  }
}

TEST_F(CustomModelTest, EightSpeciesWithArrheniusRatesReachTheirEquilibrium) {
  // A ring of isomers at different temperatures of one place: detailed balance gives the equilibrium exactly.
  CustomModel model;
  model.parameters = {{"Ea", 2e4}, {"T", 1000.0}};
  for (int s = 0; s < 8; ++s) {
    model.species.push_back(fmt::format("s{}", s));
    model.reactions.push_back({fmt::format("s{} <-> s{}", s, (s + 1) % 8), "arrhenius(1e3, Ea, T)", "arrhenius(1e3, Ea, T)", true});
  }
  model.reactions.push_back({"s0 <-> s4", "arrhenius(3e2, 0.5, Ea*2, T)", "arrhenius(3e2, 0.5, Ea*2, T)", true});
  const auto kernels = make_custom_model(model);
  Field u(d, 8, 1);
  for (int i = 0; i < 101; ++i) u.at(3, i) = 8.0 * (1.0 + i);
  integrate(*kernels, u, 10.0, 1e-8);
  for (int s = 0; s < 8; ++s) {
    for (int i = 0; i < 101; ++i) EXPECT_NEAR(u.at(s, i), 1.0 + i, 1e-7 * (1.0 + i));
  }
}

TEST_F(CustomModelTest, EverySizeUpToEightIsThere) {
  for (int n = 1; n <= max_custom_species; ++n) {
    CustomModel model;
    for (int s = 0; s < n; ++s) {
      model.species.push_back(fmt::format("u{}", s));
      model.reaction.emplace_back(model.species.back(), fmt::format("-{}*u{}", s + 1, s));
    }
    const auto kernels = make_custom_model(model);
    EXPECT_EQ(kernels->n_species(), n);
    Field u(d, n, 1);
    for (int s = 0; s < n; ++s) {
      for (int i = 0; i < 101; ++i) u.at(s, i) = 1.0;
    }
    integrate(*kernels, u, 1.0, 1e-9);
    for (int s = 0; s < n; ++s) EXPECT_NEAR(u.at(s, 100), std::exp(-(s + 1.0)), 1e-9);
  }
}

class CustomModelErrorTest : public ::testing::Test {
 protected:
  template <class Change>
  static std::string error(Change change) {
    CustomModel model = bz_text();
    change(model);
    try {
      make_custom_model(model);
    } catch (const EntryError& e) {
      EXPECT_EQ(e.kind(), ErrorKind::input);
      EXPECT_EQ(std::string(e.what()), e.key() + ": " + e.detail());
      return e.what();
    }
    return "no error";
  }
};

TEST_F(CustomModelErrorTest, NamesTheEntryAndTheColumn) {
  EXPECT_EQ(error([](CustomModel& m) { m.reaction[0].second = "(f*c - q*a - a*bb)/mu"; }),
            "model.reaction.a: column 16: unknown name \"bb\"; did you mean b? Allowed: a, b, c, t, x, y, epsilon, f, mu, q, pi, e");
  EXPECT_EQ(error([](CustomModel& m) { m.reaction.erase(m.reaction.begin() + 1); }),
            "model.reaction: no expression for c; every species needs one");
  EXPECT_EQ(error([](CustomModel& m) { m.reaction[1].first = "d"; }), "model.reaction.d: unknown species; allowed: a, b, c");
  EXPECT_EQ(error([](CustomModel& m) { m.reaction.emplace_back("a", "1"); }), "model.reaction.a: a is there twice");
  EXPECT_EQ(error([](CustomModel& m) { m.diffusion[0].second = "muh"; }),
            "model.diffusion.a: column 1: unknown name \"muh\"; did you mean mu? Allowed: epsilon, f, mu, q, pi, e");
  EXPECT_EQ(error([](CustomModel& m) { m.diffusion[0].second = -1.0; }), "model.diffusion.a: expected a number not below 0, got -1");
  EXPECT_EQ(error([](CustomModel& m) { m.diffusion[0].first = "A"; }),
            "model.diffusion.A: unknown species; did you mean a? Allowed: a, b, c");
  EXPECT_EQ(error([](CustomModel& m) {
              m.reactions = {{"a -> d", 1.0, {}, true}};
            }),
            "model.reactions[0].equation: column 6: unknown species \"d\"; allowed: a, b, c");
}

TEST_F(CustomModelErrorTest, NamesStandForOneThingEach) {
  EXPECT_EQ(error([](CustomModel& m) { m.species.clear(); }), "model.species: missing: the names of the species");
  EXPECT_EQ(error([](CustomModel& m) { m.species.resize(9, "s"); }), "model.species: expected at most 8 species, got 9");
  EXPECT_EQ(error([](CustomModel& m) { m.species[1] = "a"; }), "model.species[1]: a is there twice");
  EXPECT_EQ(error([](CustomModel& m) { m.species[1] = "x"; }), "model.species[1]: x stands for time or place; choose another name");
  EXPECT_EQ(error([](CustomModel& m) { m.species[2] = "2c"; }),
            "model.species[2]: \"2c\" is no name: letters, digits and _, not beginning with a digit");
  EXPECT_EQ(error([](CustomModel& m) { m.parameters[0].first = "a"; }), "model.parameters.a: a is there twice");
  EXPECT_EQ(error([](CustomModel& m) { m.parameters[0].second = NAN; }), "model.parameters.epsilon: expected a finite number");
}

}  // namespace
}  // namespace stiffront
