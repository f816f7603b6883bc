// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/collocation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>
#include <string>

#include "stiffront/core/error.hpp"

namespace stiffront {
namespace {

NodeFamily family_of(const std::string& name) {
  if (name == "legendre") return NodeFamily::gauss_legendre;
  return name == "radau" ? NodeFamily::gauss_radau : NodeFamily::gauss_lobatto;
}

void expect_row(std::istream& in, const std::vector<double>& row, const std::string& what) {
  for (double x : row) {
    double expected = 0.0;
    ASSERT_TRUE(in >> expected);
    EXPECT_NEAR(x, expected, 1e-15) << what;
  }
}

TEST(Collocation, AgreesWithTwentyFiveDigitTables) {
  std::ifstream file(std::string(STIFFRONT_SOURCE_DIR) + "/tests/data/collocation_nodes.txt");
  std::string line;
  ASSERT_TRUE(std::getline(file, line));
  std::string name;
  int m = 0;
  int tables = 0;
  while (file >> name >> m) {
    const CollocationNodes n = collocation_nodes(family_of(name), m);
    const std::string what = name + " " + std::to_string(m);
    expect_row(file, n.c, what + " c");
    expect_row(file, n.w, what + " w");
    for (const auto& row : n.s) expect_row(file, row, what + " S");
    ++tables;
  }
  EXPECT_EQ(tables, 27);
}

TEST(Collocation, IntegratesPolynomialsUpToItsOrder) {
  for (NodeFamily family : {NodeFamily::gauss_legendre, NodeFamily::gauss_radau, NodeFamily::gauss_lobatto}) {
    for (int m = 2; m <= 10; ++m) {
      const CollocationNodes n = collocation_nodes(family, m);
      for (int p = 0; p < n.quadrature_order; ++p) {
        double sum = 0.0;
        for (int a = 0; a < m; ++a) sum += n.w[static_cast<std::size_t>(a)] * std::pow(n.c[static_cast<std::size_t>(a)], p);
        EXPECT_NEAR(sum, 1.0 / (p + 1), 1e-14);
      }
      for (int k = 0; k < m; ++k) {
        for (int p = 0; p < m; ++p) {
          double sum = 0.0;
          for (int a = 0; a < m; ++a)
            sum += n.s[static_cast<std::size_t>(k)][static_cast<std::size_t>(a)] * std::pow(n.c[static_cast<std::size_t>(a)], p);
          EXPECT_NEAR(sum, std::pow(n.c[static_cast<std::size_t>(k)], p + 1) / (p + 1), 2e-15);
        }
      }
    }
  }
}

TEST(Collocation, RadauIsTheTableauOfRadauIIA) {
  const CollocationNodes n = collocation_nodes(NodeFamily::gauss_radau, 3);
  const double r = std::sqrt(6.0);
  EXPECT_NEAR(n.c[0], (4 - r) / 10, 1e-16);
  EXPECT_NEAR(n.s[0][0], (88 - 7 * r) / 360, 1e-16);
  EXPECT_NEAR(n.s[1][2], (-2 - 3 * r) / 225, 1e-16);
  EXPECT_NEAR(n.s[2][1], (16 + r) / 36, 1e-16);
  EXPECT_EQ(n.s[2], n.w);
}

TEST(Collocation, EndsWhereItsFamilySays) {
  for (int m = 2; m <= 10; ++m) {
    EXPECT_FALSE(collocation_nodes(NodeFamily::gauss_legendre, m).ends_at_one());
    const CollocationNodes radau = collocation_nodes(NodeFamily::gauss_radau, m);
    EXPECT_TRUE(radau.ends_at_one());
    EXPECT_FALSE(radau.starts_at_zero());
    const CollocationNodes lobatto = collocation_nodes(NodeFamily::gauss_lobatto, m);
    EXPECT_TRUE(lobatto.ends_at_one());
    EXPECT_TRUE(lobatto.starts_at_zero());
    EXPECT_EQ(lobatto.s.back(), lobatto.w);
    for (double x : lobatto.s.front()) EXPECT_EQ(x, 0.0);
  }
}

TEST(Collocation, RefusesNumbersOfNodesItDoesNotHave) {
  EXPECT_THROW(collocation_nodes(NodeFamily::gauss_lobatto, 1), Error);
  EXPECT_THROW(collocation_nodes(NodeFamily::gauss_radau, 17), Error);
}

}  // namespace
}  // namespace stiffront
