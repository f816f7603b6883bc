// SPDX-License-Identifier: BSD-3-Clause
// Whatever the characters, an expression or a reaction equation is understood or refused with its column; nothing else happens.
#include <gtest/gtest.h>

#include "stiffront/model/expression.hpp"
#include "stiffront/model/expression_program.hpp"
#include "stiffront/model/reaction_network.hpp"
#include "support/mutation.hpp"
#include "support/temporary_folder.hpp"

namespace stiffront {
namespace {

const std::vector<std::string> fragments = {"(",         ")",
                                            "))))",      "((((",
                                            "+",         "-",
                                            "*",         "/",
                                            "^",         "^^",
                                            ",",         "<=",
                                            "==",        "if(",
                                            "pow(",      "exp(",
                                            "log(0)",    "sqrt(-1)",
                                            "u",         "v",
                                            "k",         "t",
                                            "pi",        "e",
                                            "1e999",     "1e-999",
                                            "0",         "1.",
                                            ".5",        "0x1",
                                            "nan",       "inf",
                                            " ",         "\t",
                                            "\n",        "\xc3\xa4",
                                            "\xff",      std::string(1, '\0'),
                                            "->",        "<->",
                                            "2 u",       "-3 u",
                                            "min(u, v)", "99999999999999999999"};

/// One expression a line.
std::vector<std::string> corpus(const std::string& name) {
  std::vector<std::string> lines;
  std::istringstream in(testing::content_of(std::string(STIFFRONT_SOURCE_DIR "/tests/corpus/") + name));
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

TEST(ExpressionMutation, AnyTextIsUnderstoodOrRefusedWithItsColumn) {
  const std::vector<std::string> starts = corpus("expressions.txt");
  ASSERT_GT(starts.size(), 10U);
  int understood = 0;
  int refused = 0;
  for (std::uint64_t seed = 0; seed < testing::mutation_rounds(6000); ++seed) {
    testing::Mutation mutation(seed);
    const std::string text = mutation.of(starts[seed % starts.size()], fragments);
    try {
      ExpressionGraph graph({"u", "v", "t"});
      const ExpressionGraph::Node node = graph.parse(text, {{"k", 2.0}, {"zero", 0.0}});
      for (int v = 0; v < 2; ++v) graph.reachable({node, graph.differentiate(node, v)});
      ++understood;
    } catch (const ExpressionError& e) {
      ++refused;
      EXPECT_GE(e.column(), 1) << "seed " << seed;
      EXPECT_LE(e.column(), static_cast<int>(text.size()) + 1) << "seed " << seed;
      EXPECT_EQ(e.kind(), ErrorKind::input) << "seed " << seed;
    } catch (const Error& e) {
      ++refused;
      EXPECT_EQ(e.kind(), ErrorKind::input) << "seed " << seed << ": " << e.what();
    }
  }
  EXPECT_GT(understood, 300);
  EXPECT_GT(refused, 300);
}

}  // namespace
}  // namespace stiffront
