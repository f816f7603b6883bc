// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/model/reaction_network.hpp"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

#include "stiffront/core/entry_error.hpp"
#include "stiffront/model/conserved_sums.hpp"
#include "stiffront/model/expression_program.hpp"

namespace stiffront {
namespace {

const std::vector<std::string> species = {"A", "B", "C"};

std::string error(const std::string& text) {
  try {
    parse_reaction_equation(text, species);
  } catch (const ExpressionError& e) {
    return e.what();
  }
  return "no error";
}

TEST(ReactionEquationTest, CoefficientsAreExact) {
  const ReactionEquation e = parse_reaction_equation("A + 2 B -> 1.5C", species);
  EXPECT_EQ(e.left, (std::vector<Rational>{1, 2, 0}));
  EXPECT_EQ(e.right, (std::vector<Rational>{0, 0, {3, 2}}));
  EXPECT_FALSE(e.reversible);
  EXPECT_EQ(parse_reaction_equation("2*A+A<->3A", species).left[0], Rational(3));
  EXPECT_TRUE(parse_reaction_equation("A <-> B", species).reversible);
}

TEST(ReactionEquationTest, ASideMayBeEmptyOrZero) {
  for (const char* text : {"A -> 0", "A ->", " A->  "}) {
    EXPECT_EQ(parse_reaction_equation(text, species).left, (std::vector<Rational>{1, 0, 0})) << text;
    EXPECT_EQ(parse_reaction_equation(text, species).right, (std::vector<Rational>{0, 0, 0})) << text;
  }
  EXPECT_EQ(parse_reaction_equation("-> B", species).right, (std::vector<Rational>{0, 1, 0}));
  EXPECT_EQ(parse_reaction_equation("0 -> B", species).right, (std::vector<Rational>{0, 1, 0}));
}

TEST(ReactionEquationTest, MistakesHaveColumnAndRemedy) {
  EXPECT_EQ(error("A + 2 b -> C"), "column 7: unknown species \"b\"; did you mean B? Allowed: A, B, C");
  EXPECT_EQ(error("A + B"), "column 6: an arrow is missing: -> or <->");
  EXPECT_EQ(error("A + B => C"), "column 7: expected an arrow: -> for one direction, <-> for both");
  EXPECT_EQ(error("A B -> C"), "column 3: expected + or an arrow, -> or <->");
  EXPECT_EQ(error("A -> B C"), "column 8: expected +, or the end of the equation");
  EXPECT_EQ(error("A -> B -> C"), "column 8: expected +, or the end of the equation");
  EXPECT_EQ(error("A + -> C"), "column 5: a species is missing");
  EXPECT_EQ(error("2 -> C"), "column 3: a species is missing");
  EXPECT_EQ(error("0*A -> C"), "column 1: a coefficient must be positive");
  EXPECT_EQ(error("-A -> C"), "column 1: expected an arrow: -> for one direction, <-> for both");
  EXPECT_EQ(error("1234567890 A -> C"), "column 1: a coefficient has at most 9 digits");
  EXPECT_EQ(error(". A -> C"), "column 1: a coefficient needs a digit");
  EXPECT_EQ(error(""), "column 1: an arrow is missing: -> or <->");
}

TEST(ReactionEquationTest, MutationsAreReadOrRefused) {
  const std::vector<std::string> pieces = {"A", "B", "C", "2", "1.5", "0", "+",    "->",       "<->",
                                           "*", " ", "-", ">", ".",   "D", "\xc3", "999999999"};
  std::mt19937_64 engine(5);
  int read = 0;
  for (int iteration = 0; iteration < 20000; ++iteration) {
    std::string text = "A + 2 B -> 1.5 C";
    for (int k = 0; k < 2; ++k) {
      const std::size_t at = engine() % (text.size() + 1);
      if (engine() % 2 == 0) {
        text.insert(at, pieces[engine() % pieces.size()]);
      } else {
        text.erase(at, 1);
      }
    }
    try {
      parse_reaction_equation(text, species);
      ++read;
    } catch (const ExpressionError& e) {
      EXPECT_LE(e.column(), static_cast<int>(text.size()) + 1);
    }
  }
  EXPECT_GT(read, 1000);
  EXPECT_LT(read, 19000);
}

class NetworkTest : public ::testing::Test {
 protected:
  std::vector<double> rates(const std::vector<Reaction>& reactions, const std::vector<double>& u) {
    ExpressionGraph graph({"A", "B", "C", "t", "x", "y"});
    const ExpressionProgram program(graph, network_rates(graph, species, reactions, {{"k1", 2.0}, {"k2", 0.5}}).rates);
    ExpressionProgram::Frame<double, 1> frame(program);
    for (int k = 0; k < 3; ++k) frame.input(k) = u[static_cast<std::size_t>(k)];
    for (int k = 3; k < 6; ++k) frame.input(k) = 0.25;
    frame.run();
    return {frame.output(0), frame.output(1), frame.output(2)};
  }

  std::string error(const Reaction& reaction) {
    try {
      rates({{"A -> B", "k1", {}, true}, reaction}, {1, 1, 1});
    } catch (const EntryError& e) {
      return e.what();
    }
    return "no error";
  }
};

TEST_F(NetworkTest, FollowsTheLawOfMassAction) {
  EXPECT_EQ(rates({{"A + 2 B -> C", "k1", {}, true}}, {3, 2, 1}), (std::vector<double>{-24, -48, 24}));
  EXPECT_EQ(rates({{"A <-> 2 B", "k1", "k2", true}}, {3, 2, 1}), (std::vector<double>{-4, 8, 0}));
  EXPECT_EQ(rates({{"A + B -> 2 B", 1.0, {}, true}}, {3, 2, 1}), (std::vector<double>{-6, 6, 0}));
  EXPECT_EQ(rates({{"0 -> C", 7.0, {}, true}, {"C -> 0", 1.0, {}, true}}, {3, 2, 1}), (std::vector<double>{0, 0, 6}));
  EXPECT_EQ(rates({{"A -> C", "k1*C*(1 + x)", {}, true}}, {3, 2, 1}), (std::vector<double>{-7.5, 0, 7.5}));
}

TEST_F(NetworkTest, TakesWholeRates) {
  EXPECT_EQ(rates({{"A -> 2 C", "k1*A/(A + k2 + 0.5)", {}, false}}, {3, 2, 1}), (std::vector<double>{-1.5, 0, 3}));
  EXPECT_EQ(rates({{"A <-> C", "A - C", {}, false}}, {3, 2, 1}), (std::vector<double>{-2, 0, 2}));
  EXPECT_EQ(rates({{"A <-> C", "A", "2*C", false}}, {3, 2, 1}), (std::vector<double>{-1, 0, 1}));
}

TEST_F(NetworkTest, MistakesNameTheEntry) {
  EXPECT_EQ(error({"A -> D", "k1", {}, true}), "model.reactions[1].equation: column 6: unknown species \"D\"; allowed: A, B, C");
  EXPECT_EQ(error({"A -> B", "k3", {}, true}),
            "model.reactions[1].rate: column 1: unknown name \"k3\"; did you mean k1? Allowed: A, B, C, t, x, y, k1, k2, pi, e");
  EXPECT_EQ(error({"A <-> B", "k1", {}, true}), "model.reactions[1].reverse_rate: missing: the coefficient of the backward direction");
  EXPECT_EQ(error({"A -> B", "k1", "k2", true}), "model.reactions[1].reverse_rate: only for an equation with <->");
  EXPECT_EQ(error({"A <-> B", "k1", "k2 +", true}),
            "model.reactions[1].reverse_rate: column 5: the expression ends where a number, a name or ( is expected");
}

std::vector<std::string> conserved(const std::vector<std::string>& names, const std::vector<std::string>& equations) {
  std::vector<std::vector<Rational>> changes;
  for (const std::string& text : equations) {
    const ReactionEquation e = parse_reaction_equation(text, names);
    changes.emplace_back();
    for (std::size_t s = 0; s < names.size(); ++s) changes.back().push_back(e.right[s] - e.left[s]);
  }
  std::vector<std::string> texts;
  for (const ConservedSum& sum : conserved_sums(names, changes)) {
    texts.push_back(sum.text);
    for (const auto& change : changes) {
      double total = 0.0;
      for (std::size_t s = 0; s < names.size(); ++s) total += sum.weights[s] * change[s].value();
      EXPECT_EQ(total, 0.0);
    }
  }
  return texts;
}

TEST(ConservedSumsTest, AreTheLeftNullSpace) {
  using Texts = std::vector<std::string>;
  EXPECT_EQ(conserved(species, {"A -> B", "B -> C"}), (Texts{"A + B + C"}));
  EXPECT_EQ(conserved(species, {"A + B <-> C"}), (Texts{"A + C", "B + C"}));
  EXPECT_EQ(conserved(species, {"A + 2 B -> C"}), (Texts{"A + C", "B + 2 C"}));
  EXPECT_EQ(conserved(species, {"2 A -> 3 B"}), (Texts{"3 A + 2 B", "C"}));
  EXPECT_EQ(conserved(species, {"A -> 0", "0 -> B"}), (Texts{"C"}));
  EXPECT_EQ(conserved(species, {"A + B -> 0"}), (Texts{"A - B", "C"}));
  EXPECT_EQ(conserved(species, {"A -> B", "B -> A"}), (Texts{"A + B", "C"}));
  EXPECT_EQ(conserved(species, {"A -> 0.125 B"}), (Texts{"A + 8 B", "C"}));
  // Michaelis-Menten: enzyme and substrate
  EXPECT_EQ(conserved({"E", "S", "ES", "P"}, {"E + S <-> ES", "ES -> E + P"}), (Texts{"E + ES", "S + ES + P"}));
  EXPECT_TRUE(conserved({"X", "Y"}, {"0 -> X", "X -> Y", "2 X + Y -> 3 X", "X -> 0"}).empty());
}

TEST(ConservedSumsTest, RefusesWhatDoesNotFitExactArithmetic) {
  std::vector<std::string> names;
  std::vector<std::vector<Rational>> changes;
  std::mt19937_64 engine(1);
  for (int s = 0; s < 8; ++s) names.push_back(std::string(1, static_cast<char>('a' + s)));
  for (int r = 0; r < 7; ++r) {
    changes.emplace_back();
    for (int s = 0; s < 8; ++s)
      changes.back().push_back({static_cast<std::int64_t>(engine() % 1000000000), static_cast<std::int64_t>(engine() % 1000 + 1)});
  }
  try {
    conserved_sums(names, changes);
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::input);
  }
}

TEST(RationalTest, IsExactAndInLowestTerms) {
  EXPECT_EQ(Rational(6, -4), Rational(-3, 2));
  EXPECT_EQ(Rational(1, 3) + Rational(1, 6), Rational(1, 2));
  EXPECT_EQ(Rational(1, 3) - Rational(1, 3), Rational(0));
  EXPECT_EQ(Rational(2, 3) / Rational(-4, 9), Rational(-3, 2));
  EXPECT_THROW(Rational(INT64_MAX) * Rational(2), Error);
  EXPECT_THROW(Rational(INT64_MIN, -1), Error);
}

}  // namespace
}  // namespace stiffront
