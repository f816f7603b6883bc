// SPDX-License-Identifier: BSD-3-Clause
// Expressions: what they mean, what they refuse and with which words, their derivatives.
#include "stiffront/model/expression.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "stiffront/model/expression_contraction.hpp"
#include "stiffront/model/expression_program.hpp"

namespace stiffront {
namespace {

const std::map<std::string, double> parameters = {{"k1", 2.5}, {"epsilon", 1e-2}, {"zero", 0.0}, {"n", 3.0}};

ExpressionGraph graph_of_tests() { return ExpressionGraph({"u", "v", "t", "x", "y"}); }

double evaluate(const ExpressionGraph& graph, ExpressionGraph::Node node, const std::vector<double>& inputs) {
  const ExpressionProgram program(graph, {node});
  ExpressionProgram::Frame<double, 1> frame(program);
  for (std::size_t k = 0; k < inputs.size(); ++k) frame.input(static_cast<int>(k)) = inputs[k];
  frame.run();
  return frame.output(0);
}

const std::vector<double> inputs = {0.7, -1.3, 2.0, 0.25, 0.5};

double value(const std::string& text) {
  ExpressionGraph graph = graph_of_tests();
  return evaluate(graph, graph.parse(text, parameters), inputs);
}

std::string error(const std::string& text) {
  ExpressionGraph graph = graph_of_tests();
  try {
    graph.parse(text, parameters);
  } catch (const ExpressionError& e) {
    return e.what();
  }
  return "no error";
}

TEST(ExpressionTest, OperatorsHaveTheirUsualPrecedence) {
  const double u = inputs[0];
  const double v = inputs[1];
  EXPECT_EQ(value("1 + 2*3"), 7.0);
  EXPECT_EQ(value("u - v - 1"), (u - v) - 1.0);
  EXPECT_EQ(value("u/v/4"), (u / v) / 4.0);
  EXPECT_EQ(value("-u^2"), -(u * u));
  EXPECT_EQ(value("2^3^2"), 512.0);
  EXPECT_EQ(value("2^-1"), 0.5);
  EXPECT_EQ(value("-2^-u"), -std::pow(2.0, -u));
  EXPECT_EQ(value("(u + v)*(u - v)"), (u + v) * (u - v));
  EXPECT_EQ(value("- - u"), u);
  EXPECT_EQ(value("+u"), u);
  EXPECT_EQ(value("u*-v"), u * -v);
  EXPECT_EQ(value("1.5e3*u"), 1500.0 * u);
  EXPECT_EQ(value(".5*u"), 0.5 * u);
  EXPECT_EQ(value("\tu\n+ v "), u + v);
}

TEST(ExpressionTest, ComparisonsAndChoicesAreOneOrZero) {
  EXPECT_EQ(value("u < 1"), 1.0);
  EXPECT_EQ(value("u + 1 <= v*2"), 0.0);
  EXPECT_EQ(value("u > v"), 1.0);
  EXPECT_EQ(value("u >= 0.7"), 1.0);
  EXPECT_EQ(value("u == 0.7"), 1.0);
  EXPECT_EQ(value("u != 0.7"), 0.0);
  EXPECT_EQ(value("u > 0 && v > 0"), 0.0);
  EXPECT_EQ(value("u > 0 && v < 0 && x < y"), 1.0);
  EXPECT_EQ(value("v > 0 || v < -1"), 1.0);
  EXPECT_EQ(value("u && v"), 1.0);
  EXPECT_EQ(value("u*0 || zero"), 0.0);
  EXPECT_EQ(value("!(u < 1)"), 0.0);
  EXPECT_EQ(value("!v"), 0.0);
  EXPECT_EQ(value("if(u < 1, v, 5)"), -1.3);
  EXPECT_EQ(value("if(u > 1, v, 5)"), 5.0);
  EXPECT_EQ(value("if(t - 2, 1, 2)"), 2.0);
  EXPECT_EQ(value("min(u, v)"), -1.3);
  EXPECT_EQ(value("max(u, v)"), 0.7);
}

TEST(ExpressionTest, FunctionsAndConstantsAreThoseOfTheirNames) {
  const double u = inputs[0];
  EXPECT_EQ(value("abs(v)"), 1.3);
  EXPECT_EQ(value("sqrt(u)"), std::sqrt(u));
  EXPECT_EQ(value("exp(u)"), std::exp(u));
  EXPECT_EQ(value("log(u)"), std::log(u));
  EXPECT_EQ(value("log10(u)"), std::log10(u));
  EXPECT_EQ(value("sin(u)"), std::sin(u));
  EXPECT_EQ(value("cos(u)"), std::cos(u));
  EXPECT_EQ(value("tan(u)"), std::tan(u));
  EXPECT_EQ(value("asin(u)"), std::asin(u));
  EXPECT_EQ(value("acos(u)"), std::acos(u));
  EXPECT_EQ(value("atan(u)"), std::atan(u));
  EXPECT_EQ(value("sinh(u)"), std::sinh(u));
  EXPECT_EQ(value("cosh(u)"), std::cosh(u));
  EXPECT_EQ(value("tanh(u)"), std::tanh(u));
  EXPECT_EQ(value("pow(u, v)"), std::pow(u, -1.3));
  EXPECT_EQ(value("u^v"), std::pow(u, -1.3));
  EXPECT_EQ(value("pi"), std::numbers::pi);
  EXPECT_EQ(value("e"), std::numbers::e);
  EXPECT_EQ(value("k1*u"), 2.5 * u);
  EXPECT_DOUBLE_EQ(value("arrhenius(3, 5000, 300*t)"), 3.0 * std::exp(-5000.0 / (8.31446261815324 * 600.0)));
  EXPECT_DOUBLE_EQ(value("arrhenius(3, -0.5, 5000, 300*t)"), 3.0 / std::sqrt(600.0) * std::exp(-5000.0 / (8.31446261815324 * 600.0)));
}

TEST(ExpressionTest, IntegerPowersOfNegativeNumbersAreExact) {
  EXPECT_EQ(value("v^2"), 1.3 * 1.3);
  EXPECT_EQ(value("v^3"), -1.3 * (1.3 * 1.3));
  EXPECT_EQ(value("v^-1"), 1.0 / -1.3);
  EXPECT_EQ(value("v^0"), 1.0);
  EXPECT_NEAR(value("v^33"), std::pow(-1.3, 33), 1e-12 * std::pow(1.3, 33));
  EXPECT_EQ(value("v^n"), value("v^3"));
}

TEST(ExpressionTest, NamesGivenHideTheConstants) {
  ExpressionGraph graph({"e"});
  EXPECT_EQ(evaluate(graph, graph.parse("2*e", {}), {3.0}), 6.0);
  EXPECT_EQ(evaluate(graph, graph.parse("2*pi", {{"pi", 4.0}}), {3.0}), 8.0);
}

TEST(ExpressionTest, EqualPartsAreOneNode) {
  ExpressionGraph graph = graph_of_tests();
  EXPECT_EQ(graph.parse("u*v + sin(u*v)", parameters), graph.parse("sin(v*u) + v*u", parameters));
  EXPECT_EQ(graph.parse("2*3 + u", parameters), graph.parse("u + 6", parameters));
  EXPECT_EQ(graph.parse("u - u", parameters), graph.constant(0.0));
  EXPECT_EQ(graph.parse("--u + 0*v", parameters), graph.variable(0));
}

TEST(ExpressionTest, DependsOnItsVariablesOnly) {
  ExpressionGraph graph = graph_of_tests();
  const auto node = graph.parse("exp(u) + if(x > 0.5, y, zero*t)", parameters);
  EXPECT_TRUE(graph.depends_on(node, 0));
  EXPECT_FALSE(graph.depends_on(node, 1));
  EXPECT_FALSE(graph.depends_on(node, 2));
  EXPECT_TRUE(graph.depends_on(node, 3));
  EXPECT_TRUE(graph.depends_on(node, 4));
}

TEST(ExpressionErrorTest, NamesColumnAndRemedy) {
  EXPECT_EQ(error("k1*u + epsilom"),
            "column 8: unknown name \"epsilom\"; did you mean epsilon? Allowed: u, v, t, x, y, epsilon, k1, n, zero, pi, e");
  EXPECT_EQ(error("w"), "column 1: unknown name \"w\"; allowed: u, v, t, x, y, epsilon, k1, n, zero, pi, e");
  EXPECT_EQ(error("2*sinn(u)"),
            "column 3: unknown function \"sinn\"; did you mean sin? Allowed: if, min, max, pow, abs, sqrt, exp, log, log10, sin, cos, "
            "tan, asin, acos, atan, sinh, cosh, tanh, arrhenius");
  EXPECT_EQ(error("exp + 1"), "column 1: \"exp\" is a function; it is written exp(...)");
  EXPECT_EQ(error("u (v + 1)"), "column 1: \"u\" is no function; a product is written with *");
  EXPECT_EQ(error("2u"), "column 2: unexpected \"u\"; expected an operator or the end of the expression; a product is written with *");
  EXPECT_EQ(error("(u)(v)"), "column 4: unexpected \"(\"; expected an operator or the end of the expression; a product is written with *");
  EXPECT_EQ(error("u**2"), "column 2: \"**\" is no operator; a power is written with ^");
  EXPECT_EQ(error("u = 2"), "column 3: \"=\" is no operator; equality is \"==\"");
  EXPECT_EQ(error("0 < u < 1"), "column 7: comparisons cannot be chained; write a < b && b < c");
  EXPECT_EQ(error("min(u)"), "column 1: min takes 2 arguments, got 1");
  EXPECT_EQ(error("1 + sin()"), "column 5: sin takes 1 argument, got 0");
  EXPECT_EQ(error("sin(u, v)"), "column 1: sin takes 1 argument, got 2");
  EXPECT_EQ(error("arrhenius(1, 2)"), "column 1: arrhenius takes (A, Ea, T) or (A, b, Ea, T), got 2 arguments");
  EXPECT_EQ(error("sin(u"), "column 6: \",\" or \")\" is missing");
  EXPECT_EQ(error("(u + v"), "column 7: \")\" is missing");
  EXPECT_EQ(error("u + v)"), "column 6: unexpected \")\"; expected an operator or the end of the expression");
  EXPECT_EQ(error(""), "column 1: the expression ends where a number, a name or ( is expected");
  EXPECT_EQ(error("  "), "column 3: the expression ends where a number, a name or ( is expected");
  EXPECT_EQ(error("u +"), "column 4: the expression ends where a number, a name or ( is expected");
  EXPECT_EQ(error("u + * v"), "column 5: unexpected \"*\"; expected a number, a name or (");
  EXPECT_EQ(error("."), "column 1: a number needs a digit");
}

TEST(ExpressionErrorTest, CountsCharactersNotBytes) {
  EXPECT_EQ(error("u \xe2\x88\x92 v"), "column 3: unexpected \"\xe2\x88\x92\"; expected an operator or the end of the expression");
  EXPECT_EQ(error("\xc3\xa4*u"), "column 1: unexpected \"\xc3\xa4\"; expected a number, a name or (");
  EXPECT_EQ(error(std::string("u\x01", 2)), "column 2: unexpected character of code 1; expected an operator or the end of the expression");
  EXPECT_EQ(error(std::string("u\0v", 3)), "column 2: unexpected character of code 0; expected an operator or the end of the expression");
  EXPECT_EQ(error("\xff"), "column 1: unexpected \"\xff\"; expected a number, a name or (");
}

TEST(ExpressionErrorTest, RefusesWhatCanHaveNoValue) {
  EXPECT_EQ(error("u + 1/zero"), "column 6: division by zero");
  EXPECT_EQ(error("u/(n - 3)"), "column 2: division by zero");
  EXPECT_EQ(error("u*log(zero)"), "column 3: this has no finite value");
  EXPECT_EQ(error("sqrt(-n)*u"), "column 1: this has no finite value");
  EXPECT_EQ(error("u*1e308*(10*1e308)"), "column 12: this has no finite value");
  EXPECT_EQ(error("1e400"), "column 1: this number is outside the range of double precision");
  EXPECT_EQ(error("0^-1 + u"), "column 2: this has no finite value");
}

TEST(ExpressionErrorTest, ABranchThatIsNeverTakenMayBeNonsense) {
  EXPECT_EQ(value("if(zero == 0, u, u/zero)"), 0.7);
  EXPECT_EQ(value("if(n > 0, n, 1/zero)"), 3.0);
  EXPECT_EQ(error("if(u > 0, u, 1/zero)"), "column 15: division by zero");
}

TEST(ExpressionErrorTest, DeepAndLongTextsAreRefusedOrEvaluatedNeverACrash) {
  const int deep = 100000;
  for (const std::string& open : {std::string("("), std::string("-"), std::string("!"), std::string("sin("), std::string("u^"),
                                  std::string("if(u<"), std::string("min(u,")}) {
    std::string text;
    while (text.size() + open.size() < static_cast<std::size_t>(deep)) text += open;
    EXPECT_NE(error(text).find("nested too deeply"), std::string::npos) << open;
  }
  EXPECT_NE(error(std::string(1000000, ' ')).find("more than 100000 characters"), std::string::npos);
  // A long chain of operations is a deep graph, but nothing recurses on it.
  std::string sum = "u";
  for (int k = 0; k < 20000; ++k) sum += "*v+u";
  ExpressionGraph graph = graph_of_tests();
  const auto node = graph.parse(sum, parameters);
  EXPECT_TRUE(graph.depends_on(node, 1));
  EXPECT_FALSE(graph.depends_on(node, 2));
  const auto slope = graph.differentiate(node, 1);
  const auto contracted = contract(graph, {node, slope});
  EXPECT_NEAR(evaluate(graph, contracted[0], {1.0, 0.5, 0, 0, 0}), 1.0 + 20000 * 0.5, 1e-9);
  EXPECT_NEAR(evaluate(graph, contracted[1], {1.0, 0.5, 0, 0, 0}), 20000.0, 1e-9);
}

TEST(ExpressionErrorTest, DerivativesOfNestedProductsStaySmall) {
  // As trees, the derivatives of u^64^64... or of a tower of products would have 2^depth leaves.
  std::string text = "u";
  for (int k = 0; k < 60; ++k) text = "(" + text + ")*sin(" + (k % 2 == 0 ? "u" : "v") + ")";
  ExpressionGraph graph = graph_of_tests();
  auto node = graph.parse(text, parameters);
  for (int k = 0; k < 30; ++k) node = graph.make(Operation::multiply, node, graph.make(Operation::sine, node));
  const auto slope = graph.differentiate(node, 0);
  EXPECT_LT(graph.reachable({slope}).size(), 1000U);
}

TEST(ExpressionErrorTest, GraphsBeyondAnySensibleModelAreRefused) {
  ExpressionGraph graph = graph_of_tests();
  auto node = graph.variable(0);
  EXPECT_THROW(
      {
        for (int k = 0; k < 1000000; ++k) node = graph.make(Operation::add, node, graph.constant(k + 0.5));
      },
      Error);
}

/// Every kind of part, over the inputs' neighbourhood in which it is smooth.
const std::vector<std::string> smooth = {"u + v",
                                         "u - v",
                                         "u*v",
                                         "u/v",
                                         "-u",
                                         "u^2",
                                         "u^7",
                                         "v^-3",
                                         "u^2.5",
                                         "u^0.3",
                                         "u^v",
                                         "3^v",
                                         "pow(u, v*v)",
                                         "min(u, v)",
                                         "max(u*u, v)",
                                         "abs(v)",
                                         "abs(u)",
                                         "sqrt(u)",
                                         "sqrt(1 + v^2)",
                                         "exp(v)",
                                         "log(u)",
                                         "log10(u + 2)",
                                         "sin(v)",
                                         "cos(v)",
                                         "tan(u)",
                                         "asin(u/2)",
                                         "acos(u/2)",
                                         "atan(v)",
                                         "sinh(v)",
                                         "cosh(v)",
                                         "tanh(v)",
                                         "if(u > v, u^2*v, v)",
                                         "if(u < v, u, u*sin(v))",
                                         "u < v",
                                         "u >= v && v",
                                         "!u",
                                         "arrhenius(k1, 4000, 300 + 100*u)",
                                         "arrhenius(k1, 1.5, 4000, 300 + 100*u)",
                                         "u*v/(u + k1)",
                                         "1/(1 + exp(-v/epsilon*0.01))",
                                         "u - v*(u - v*(u - 3*v))",
                                         "k1*(k1 - u)*(2 + v)",
                                         "(u*u - v)/(v*v + u)",
                                         "exp(-u/(1 + v*v))*tanh(u*v)"};

TEST(ExpressionDerivativeTest, AgreeWithFiniteDifferences) {
  for (const std::string& text : smooth) {
    for (bool contracted : {false, true}) {
      ExpressionGraph graph = graph_of_tests();
      auto node = graph.parse(text, parameters);
      if (contracted) node = contract(graph, {node})[0];
      for (int k = 0; k < 2; ++k) {
        auto slope = graph.differentiate(node, k);
        if (contracted) slope = contract(graph, {slope}, {node})[0];
        const double h = 1e-3;
        const auto at = [&](double shift) {
          std::vector<double> moved = inputs;
          moved[static_cast<std::size_t>(k)] += shift;
          return evaluate(graph, node, moved);
        };
        // Eighth-order differences: truncation about 1e-24 times a derivative of order 9, rounding about 1e-13.
        const double difference = (4.0 / 5.0 * (at(h) - at(-h)) - 1.0 / 5.0 * (at(2 * h) - at(-2 * h)) +
                                   4.0 / 105.0 * (at(3 * h) - at(-3 * h)) - 1.0 / 280.0 * (at(4 * h) - at(-4 * h))) /
                                  h;
        const double exact = evaluate(graph, slope, inputs);
        EXPECT_NEAR(exact, difference, 1e-10 * (1.0 + std::abs(exact) + std::abs(at(0.0)) / h * 1e-3)) << text << " by "
                                                                                                       << "uv"[k];
      }
    }
  }
}

TEST(ExpressionDerivativeTest, AreFiniteWhereTheFormulaIsNot) {
  ExpressionGraph graph = graph_of_tests();
  const std::vector<double> origin = {0.0, 0.0, 0.0, 0.0, 0.0};
  for (const char* text : {"sqrt(u)", "u^0.3", "sqrt(u*u + v*v)", "u*sqrt(u)", "if(u > 0, log(u), 0)"}) {
    const auto slope = graph.differentiate(graph.parse(text, parameters), 0);
    EXPECT_EQ(evaluate(graph, slope, origin), 0.0) << text;
  }
  // A part that does not vary contributes nothing, even where it is not finite.
  EXPECT_EQ(evaluate(graph, graph.differentiate(graph.parse("u + 1/t", parameters), 0), origin), 1.0);
}

TEST(ExpressionDerivativeTest, OfOneSidedFunctionsIsThatOfTheSideTaken) {
  ExpressionGraph graph = graph_of_tests();
  const std::vector<double> equal = {0.5, 0.5, 0.0, 0.0, 0.0};
  // min(a, b) is b and max(a, b) is b where they are equal
  EXPECT_EQ(evaluate(graph, graph.differentiate(graph.parse("min(u, v)", parameters), 0), equal), 0.0);
  EXPECT_EQ(evaluate(graph, graph.differentiate(graph.parse("max(u, v)", parameters), 1), equal), 1.0);
  EXPECT_EQ(evaluate(graph, graph.differentiate(graph.parse("abs(u - v)", parameters), 0), equal), 1.0);
}

TEST(ExpressionContractionTest, ChangesValuesByRoundingOnly) {
  std::mt19937_64 engine(1);
  std::uniform_real_distribution<double> uniform(0.1, 1.5);
  for (const std::string& text : smooth) {
    ExpressionGraph graph = graph_of_tests();
    const auto written = graph.parse(text, parameters);
    const auto contracted = contract(graph, {written})[0];
    for (int k = 0; k < 20; ++k) {
      const std::vector<double> at = {uniform(engine), -uniform(engine), uniform(engine), uniform(engine), uniform(engine)};
      const double exact = evaluate(graph, written, at);
      EXPECT_NEAR(evaluate(graph, contracted, at), exact, 1e-14 * (1.0 + std::abs(exact))) << text;
    }
  }
}

TEST(ExpressionContractionTest, SavesInstructions) {
  ExpressionGraph graph = graph_of_tests();
  const auto node = graph.parse("-(k1*(u/epsilon))/7 + u*v", parameters);
  EXPECT_EQ(ExpressionProgram(graph, contract(graph, {node})).n_instructions(), 2);  // scale, fma
}

TEST(ExpressionContractionTest, LeavesWhatIsKeptAsItIs) {
  ExpressionGraph graph = graph_of_tests();
  const auto kept = graph.parse("u*v + x", parameters);
  const auto roots = contract(graph, {kept, graph.parse("u*v + y", parameters)}, {kept});
  EXPECT_EQ(roots[0], kept);
}

TEST(ExpressionFuzzTest, MutatedTextsGiveAValueOrAnExpressionError) {
  const std::vector<std::string> pieces = {
      "u", "v",   "t",    "x",    "k1",   "zero", "1",    "1e308", "1e-308", "0",          ".",  "e",    "pi",           "+",  "-",
      "*", "/",   "^",    "**",   "(",    ")",    ",",    "<",     "<=",     "==",         "!=", "&&",   "||",           "!",  "=",
      " ", "if(", "sin(", "exp(", "log(", "min(", "pow(", "sqrt(", "tan(",   "arrhenius(", "uu", "\xc3", "\xe2\x88\x92", "1e", "e5",
      "_", "#",   "\"",   "\\",   "\n"};
  std::vector<std::string> seeds = smooth;
  std::mt19937_64 engine(20240607);
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(engine() % n); };
  int values = 0;
  int errors = 0;
  for (int iteration = 0; iteration < 20000; ++iteration) {
    std::string text = seeds[below(seeds.size())];
    const std::size_t changes = 1 + below(3);
    for (std::size_t k = 0; k < changes; ++k) {
      const std::size_t at = below(text.size() + 1);
      switch (below(5)) {
        case 0:
          text.insert(at, pieces[below(pieces.size())]);
          break;
        case 1:
          text.erase(at, 1);
          break;
        case 2:
          text.replace(at, 1, pieces[below(pieces.size())]);
          break;
        case 3:
          text.insert(at, text.substr(below(text.size() + 1), below(10)));
          break;
        default:
          text.insert(at, 1, static_cast<char>(below(256)));
          break;
      }
    }
    ExpressionGraph graph = graph_of_tests();
    try {
      const auto node = graph.parse(text, parameters);
      const auto values_and_slopes = contract(graph, {node, graph.differentiate(node, 0), graph.differentiate(node, 1)});
      const ExpressionProgram program(graph, values_and_slopes);
      ExpressionProgram::Frame<Pack, 1> frame(program);
      for (int k = 0; k < 5; ++k) frame.input(k) = Pack(inputs[static_cast<std::size_t>(k)]);
      frame.run();
      ++values;
    } catch (const ExpressionError& e) {
      ++errors;
      EXPECT_GE(e.column(), 1) << text;
      EXPECT_LE(e.column(), static_cast<int>(text.size()) + 1) << text;
    }
  }
  // Both ways are well travelled.
  EXPECT_GT(values, 1000);
  EXPECT_GT(errors, 1000);
}

}  // namespace
}  // namespace stiffront
