// SPDX-License-Identifier: BSD-3-Clause
// Programs and models made of expressions against built-in models, duals, and themselves in other company.
#include "stiffront/model/expression_model.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "stiffront/model/builtin/bz.hpp"
#include "stiffront/model/expression_program.hpp"

namespace stiffront {
namespace {

template <int M>
ExpressionModel<M> model_of(const std::vector<std::string>& species, const std::array<const char*, M>& texts,
                            const std::map<std::string, double>& parameters) {
  std::vector<std::string> variables = species;
  variables.insert(variables.end(), {"t", "x", "y"});
  ExpressionGraph graph(variables);
  std::array<ExpressionGraph::Node, M> rates;
  for (std::size_t s = 0; s < M; ++s) rates[s] = graph.parse(texts[s], parameters);
  return ExpressionModel<M>(graph, rates);
}

ExpressionModel<3> custom_bz(const Bz& bz) {
  return model_of<3>({"a", "b", "c"}, {"(f*c - q*a - a*b)/mu", "(q*a - a*b + b*(1 - b))/epsilon", "b - c"},
                     {{"epsilon", bz.epsilon}, {"mu", bz.mu}, {"f", bz.f}, {"q", bz.q}});
}

/// Everything an expression may contain, with rates of the size of the arguments.
struct Zoo {
  static constexpr int n_species = 4;
  static constexpr const char* name = "zoo";
  static constexpr const char* source = "this test";
  static constexpr std::array<const char*, 4> species{"a", "b", "c", "d"};
  static constexpr std::array<double, 4> diffusion{};
  static constexpr std::array<Parameter<Zoo>, 0> parameters{};
  static constexpr std::array<Profile<Zoo>, 0> profiles{};

  template <class T, class P>
  void rates(const T* u, T* du, const P& place) const {
    const T a = u[0];
    const T b = u[1];
    const T c = u[2];
    const T d = u[3];
    du[0] = 2.5 * a * b / (a + 0.3) - pow(a, 2.5) + 0.7 * sin(b) * cos(c) + place.x * tanh(d);
    du[1] = exp(-b / (1.0 + c * c)) - log(1.0 + a * a) + sqrt(d + 0.1) / (1.0 + b) + atan(c) * place.t;
    du[2] = select(a < b, a * a - c, b * c) + max(a, d) * min(b, c) - abs(c - d) + pow(a, b);
    du[3] = (a - b) * (c + d) * 3.0 - (1.0 - d) * d + log10(2.0 + c) + asin(0.3 * a) - acos(0.3 * b) + sinh(c) * cosh(0.5 * d) +
            tan(0.2 * a) * place.y;
  }
};

ExpressionModel<4> custom_zoo() {
  return model_of<4>(
      {"a", "b", "c", "d"},
      {"k*a*b/(a + 0.3) - a^2.5 + 0.7*sin(b)*cos(c) + x*tanh(d)", "exp(-b/(1 + c*c)) - log(1 + a*a) + sqrt(d + 0.1)/(1 + b) + atan(c)*t",
       "if(a < b, a*a - c, b*c) + max(a, d)*min(b, c) - abs(c - d) + a^b",
       "(a - b)*(c + d)*3 - (1 - d)*d + log10(2 + c) + asin(0.3*a) - acos(0.3*b) + sinh(c)*cosh(0.5*d) + tan(0.2*a)*y"},
      {{"k", 2.5}});
}

/// Rates and Jacobian of M and of a custom model differ by rounding, relative to the largest term that may have cancelled.
template <class M, int m>
void expect_same(const M& built_in, const ExpressionModel<m>& custom, const std::function<void(std::mt19937_64&, Pack*)>& next,
                 const double (&rate_size)[m]) {
  std::mt19937_64 engine(7);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (int sample = 0; sample < 1000; ++sample) {
    Pack u[m];
    next(engine, u);
    const Place<Pack> place{Pack(uniform(engine)), Pack(uniform(engine)), Pack(uniform(engine))};
    Pack du[m], custom_du[m], plain_du[m];
    Pack jacobian[m][m], custom_jacobian[m][m];
    rates_and_jacobian(built_in, u, du, jacobian, place);
    rates_and_jacobian(custom, u, custom_du, custom_jacobian, place);
    custom.rates(u, plain_du, place);
    for (int l = 0; l < pack_size; ++l) {
      for (int i = 0; i < m; ++i) {
        EXPECT_NEAR(custom_du[i][l], du[i][l], 2e-14 * rate_size[i]) << "rate " << i;
        EXPECT_EQ(custom_du[i][l], plain_du[i][l]) << "with and without Jacobian: rate " << i;
        for (int j = 0; j < m; ++j) {
          EXPECT_NEAR(custom_jacobian[i][j][l], jacobian[i][j][l], 1e-13 * std::max(std::abs(jacobian[i][j][l]), rate_size[i]))
              << "entry " << i << ", " << j;
        }
      }
    }
  }
}

TEST(ExpressionModelTest, BzAsTextIsTheBuiltInModel) {
  const Bz bz;
  // The largest terms of the rates for the states below
  const double size[3] = {240.0 / bz.mu, 240.0 / bz.epsilon, 2.0};
  expect_same(
      bz, custom_bz(bz),
      [](std::mt19937_64& engine, Pack* u) {
        std::uniform_real_distribution<double> uniform(0.0, 1.0);
        for (int l = 0; l < pack_size; ++l) {
          u[0].set(l, 200.0 * uniform(engine));
          u[1].set(l, 1.2 * uniform(engine));
          u[2].set(l, 1.2 * uniform(engine));
        }
      },
      size);
}

void next_zoo(std::mt19937_64& engine, Pack* u) {
  std::uniform_real_distribution<double> uniform(0.05, 2.0);
  for (int s = 0; s < 4; ++s) {
    for (int l = 0; l < pack_size; ++l) u[s].set(l, uniform(engine));
  }
}

TEST(ExpressionModelTest, AllFunctionsHaveTheJacobianOfDuals) {
  const double size[4] = {10.0, 10.0, 10.0, 50.0};
  expect_same(Zoo(), custom_zoo(), next_zoo, size);
}

TEST(ExpressionModelTest, DualsFollowTheChainRule) {
  const ExpressionModel<4> custom = custom_zoo();
  std::mt19937_64 engine(3);
  Pack u[4];
  next_zoo(engine, u);
  const Place<Pack> place{0.3, 0.4, 0.5};
  // Two directions at once, neither of them a variable
  Dual<Pack, 2> v[4], dv[4], expected[4];
  for (int s = 0; s < 4; ++s) {
    v[s] = u[s];
    v[s].derivative[0] = Pack(0.3 - 0.2 * s);
    v[s].derivative[1] = Pack(s == 2 ? -2.0 : 0.0);
  }
  custom.rates(v, dv, place);
  Zoo().rates(v, expected, place);
  for (int s = 0; s < 4; ++s) {
    for (int k = 0; k < 2; ++k) {
      for (int l = 0; l < pack_size; ++l) EXPECT_NEAR(dv[s].derivative[k][l], expected[s].derivative[k][l], 1e-11) << s << ", " << k;
    }
  }
}

TEST(ExpressionModelTest, DoublesGiveTheJacobianToo) {
  const Bz bz;
  const ExpressionModel<3> custom = custom_bz(bz);
  const double u[3] = {20.0, 0.4, 0.2};
  double jacobian[9], expected[9];
  cell_jacobian(custom, 0.0, 0.0, 0.0, u, jacobian);
  cell_jacobian(bz, 0.0, 0.0, 0.0, u, expected);
  for (int k = 0; k < 9; ++k) EXPECT_NEAR(jacobian[k], expected[k], 1e-14 * std::abs(expected[k]));
}

TEST(ExpressionModelTest, BitsDependNeitherOnLanesNorOnCompany) {
  const ExpressionModel<4> custom = custom_zoo();
  constexpr int n = ExpressionModel<4>::packs_together;
  std::mt19937_64 engine(11);
  Pack u[n][4];
  Place<Pack> places[n];
  for (int p = 0; p < n; ++p) {
    next_zoo(engine, u[p]);
    places[p] = {Pack(0.1 * p), Pack(0.2 * p), Pack(1.0 - 0.1 * p)};
  }
  ExpressionModel<4>::Evaluation<Pack, n> together(custom);
  for (int p = 0; p < n; ++p) {
    for (int s = 0; s < 4; ++s) together.u(s, p) = u[p][s];
  }
  together.run(places);
  for (int p = 0; p < n; ++p) {
    for (int l = 0; l < pack_size; ++l) {
      Pack alone[4], du[4];
      Pack jacobian[4][4];
      for (int s = 0; s < 4; ++s) alone[s] = Pack(u[p][s][l]);
      rates_and_jacobian(custom, alone, du, jacobian, places[p]);
      const auto same_bits = [](double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; };
      for (int i = 0; i < 4; ++i) {
        EXPECT_TRUE(same_bits(together.values(p).output(i)[l], du[i][0])) << p << ", " << l << ", " << i;
        for (int j = 0; j < 4; ++j)
          EXPECT_TRUE(same_bits(together.values(p).output(4 + 4 * i + j)[l], jacobian[i][j][0])) << p << ", " << l;
      }
    }
  }
}

TEST(ExpressionModelTest, RatesOfSeveralPacksHaveTheBitsOfEach) {
  const ExpressionModel<4> custom = custom_zoo();
  std::mt19937_64 engine(5);
  Pack u[3][4], together[3][4];
  Place<Pack> places[3];
  for (int p = 0; p < 3; ++p) {
    next_zoo(engine, u[p]);
    places[p] = {Pack(0.1 * p), Pack(0.2 * p), Pack(1.0 - 0.1 * p)};
  }
  custom.rates_of_several<3>(u, together, places);
  for (int p = 0; p < 3; ++p) {
    Pack alone[4];
    custom.rates(u[p], alone, places[p]);
    EXPECT_EQ(std::memcmp(alone, together[p], sizeof alone), 0) << p;
  }
}

TEST(ExpressionModelTest, WithoutExpressionsNothingReacts) {
  const ExpressionModel<2> still;
  const Pack u[2] = {Pack(1.0), Pack(2.0)};
  Pack du[2];
  still.rates(u, du, Place<Pack>{0.0, 0.0, 0.0});
  EXPECT_EQ(du[0][0], 0.0);
  EXPECT_EQ(du[1][0], 0.0);
}

TEST(ExpressionProgramTest, BzTakesThirteenInstructionsForRatesAndJacobian) {
  ExpressionGraph graph({"a", "b", "c"});
  const std::map<std::string, double> parameters = {{"epsilon", 1e-2}, {"mu", 1e-5}, {"f", 1.6}, {"q", 2e-3}};
  std::vector<ExpressionGraph::Node> values;
  for (const char* text : {"(f*c - q*a - a*b)/mu", "(q*a - a*b + b*(1 - b))/epsilon", "b - c"})
    values.push_back(graph.parse(text, parameters));
  values = contract(graph, values);
  std::vector<ExpressionGraph::Node> all = values;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) all.push_back(graph.differentiate(values[static_cast<std::size_t>(i)], j));
  }
  const ExpressionProgram program(graph, contract(graph, all, values));
  EXPECT_EQ(program.n_instructions(), 13);
  EXPECT_LE(program.n_registers(), 14);
}

TEST(ExpressionProgramTest, WhatIsNotNeededIsNotThere) {
  ExpressionGraph graph({"u", "v"});
  graph.parse("exp(u)*sin(v)", {});
  const ExpressionProgram program(graph, {graph.parse("2*u", {}), graph.constant(7.0)});
  EXPECT_EQ(program.n_instructions(), 1);
  EXPECT_TRUE(program.uses_input(0));
  EXPECT_FALSE(program.uses_input(1));
}

TEST(ExpressionProgramTest, RegistersAreUsedAgain) {
  ExpressionGraph graph({"u"});
  auto node = graph.variable(0);
  for (int k = 0; k < 200; ++k) node = graph.make(Operation::sine, graph.make(Operation::multiply, node, graph.variable(0)));
  EXPECT_EQ(ExpressionProgram(graph, {node}).n_registers(), 2);
}

TEST(ExpressionProgramTest, ManyRegistersAreNoLimit) {
  // Two hundred values that are all needed at the end, in both orders.
  ExpressionGraph graph({"u"});
  std::vector<ExpressionGraph::Node> parts;
  for (int k = 0; k < 200; ++k)
    parts.push_back(graph.make(Operation::sine, graph.make(Operation::multiply, graph.constant(k + 1.0), graph.variable(0))));
  const ExpressionProgram program(graph, parts);
  EXPECT_GE(program.n_registers(), 200);
  ExpressionProgram::Frame<Pack, 8> frame(program);
  for (int p = 0; p < 8; ++p) frame.input(0, p) = Pack(0.01 * p);
  frame.run();
  for (int p = 0; p < 8; ++p) {
    for (int k = 0; k < 200; ++k) EXPECT_NEAR(frame.output(k, p)[0], std::sin((k + 1) * 0.01 * p), 1e-14);
  }
}

/// The value of a node by the graph's definition, one operation at a time.
double reference(const ExpressionGraph& graph, ExpressionGraph::Node node, double u, double v) {
  const auto& d = graph.data(node);
  const auto of = [&](ExpressionGraph::Node n) { return reference(graph, n, u, v); };
  switch (d.operation) {
    case Operation::constant:
      return d.value;
    case Operation::variable:
      return d.value == 0.0 ? u : v;
    case Operation::add:
      return of(d.a) + of(d.b);
    case Operation::subtract:
      return of(d.a) - of(d.b);
    case Operation::multiply:
      return of(d.a) * of(d.b);
    case Operation::divide:
      return of(d.a) / of(d.b);
    case Operation::negate:
      return -of(d.a);
    case Operation::multiply_add:
      return mul_add(of(d.a), of(d.b), of(d.c));
    case Operation::less:
      return of(d.a) < of(d.b) ? 1.0 : 0.0;
    case Operation::less_equal:
      return of(d.a) <= of(d.b) ? 1.0 : 0.0;
    case Operation::greater:
      return of(d.a) > of(d.b) ? 1.0 : 0.0;
    case Operation::greater_equal:
      return of(d.a) >= of(d.b) ? 1.0 : 0.0;
    case Operation::equal:
      return of(d.a) == of(d.b) ? 1.0 : 0.0;
    case Operation::not_equal:
      return of(d.a) != of(d.b) ? 1.0 : 0.0;
    case Operation::select:
      return of(d.a) != 0.0 ? of(d.b) : of(d.c);
    case Operation::minimum:
      return min(of(d.a), of(d.b));
    case Operation::maximum:
      return max(of(d.a), of(d.b));
    case Operation::absolute:
      return abs(of(d.a));
    default:
      ADD_FAILURE() << "operation " << static_cast<int>(d.operation);
      return 0.0;
  }
}

TEST(ExpressionProgramTest, InstructionsHaveTheBitsOfTheirOperations) {
  // Random graphs of arithmetic and choices: every instruction is chosen many times, in all company.
  std::mt19937_64 engine(99);
  const auto below = [&](int n) { return static_cast<int>(engine() % static_cast<unsigned>(n)); };
  constexpr Operation operations[] = {Operation::add,          Operation::subtract,      Operation::multiply, Operation::add,
                                      Operation::subtract,     Operation::multiply,      Operation::divide,   Operation::negate,
                                      Operation::multiply_add, Operation::multiply_add,  Operation::less,     Operation::less_equal,
                                      Operation::greater,      Operation::greater_equal, Operation::equal,    Operation::not_equal,
                                      Operation::select,       Operation::select,        Operation::minimum,  Operation::maximum,
                                      Operation::absolute};
  for (int round = 0; round < 3000; ++round) {
    ExpressionGraph graph({"u", "v"});
    std::vector<ExpressionGraph::Node> nodes = {graph.variable(0), graph.variable(1), graph.constant(0.3), graph.constant(-1.7),
                                                graph.constant(3.0)};
    for (int k = 0; k < 10; ++k) {
      const Operation operation = operations[below(static_cast<int>(std::size(operations)))];
      const auto any = [&] { return nodes[static_cast<std::size_t>(below(static_cast<int>(nodes.size())))]; };
      const bool unary = operation == Operation::negate || operation == Operation::absolute;
      const bool ternary = operation == Operation::select || operation == Operation::multiply_add;
      nodes.push_back(graph.make(operation, any(), unary ? -1 : any(), ternary ? any() : -1));
    }
    const std::vector<ExpressionGraph::Node> outputs = {nodes[nodes.size() - 1], nodes[nodes.size() - 2]};
    const ExpressionProgram program(graph, outputs);
    ExpressionProgram::Frame<Pack, 1> frame(program);
    frame.input(0) = Pack(0.7);
    frame.input(1) = Pack(-0.45);
    frame.input(0).set(1, 2.25);
    frame.run();
    for (int k = 0; k < 2; ++k) {
      for (int l = 0; l < 2; ++l) {
        const double expected = reference(graph, outputs[static_cast<std::size_t>(k)], l == 0 ? 0.7 : 2.25, -0.45);
        const double got = frame.output(k)[l];
        EXPECT_TRUE(got == expected || (std::isnan(got) && std::isnan(expected))) << got << " and " << expected << " in round " << round;
      }
    }
  }
}

}  // namespace
}  // namespace stiffront
