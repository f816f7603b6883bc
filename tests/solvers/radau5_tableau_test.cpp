// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/solvers/radau5_tableau.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace stiffront {
namespace {

namespace tab = radau5_tableau;

/// The matrix of Radau IIA in its closed form.
struct RadauIia {
  const double q = std::sqrt(6.0);
  const double a[3][3] = {{(88 - 7 * q) / 360, (296 - 169 * q) / 1800, (-2 + 3 * q) / 225},
                          {(296 + 169 * q) / 1800, (88 + 7 * q) / 360, (-2 - 3 * q) / 225},
                          {(16 - q) / 36, (16 + q) / 36, 1.0 / 9}};
};

double t(int i, int j) { return tab::t[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)]; }
double t_inverse(int i, int j) { return tab::t_inverse[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)]; }
double c(int i) { return tab::c[static_cast<std::size_t>(i)]; }

TEST(Radau5Tableau, TransformationDiagonalisesTheMatrixInBlocks) {
  const RadauIia r;
  const double lambda[3][3] = {{tab::gamma, 0, 0}, {0, tab::alpha, -tab::beta}, {0, tab::beta, tab::alpha}};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      double identity = 0.0;
      double product = 0.0;  // A T Lambda = T
      for (int k = 0; k < 3; ++k) {
        identity += t_inverse(i, k) * t(k, j);
        for (int l = 0; l < 3; ++l) product += r.a[i][k] * t(k, l) * lambda[l][j];
      }
      EXPECT_NEAR(identity, i == j ? 1.0 : 0.0, 2e-15);
      EXPECT_NEAR(product, t(i, j), 2e-15);
    }
  }
}

TEST(Radau5Tableau, EigenvaluesAreThoseOfTheClosedForm) {
  const double a = std::cbrt(9.0);
  const double b = std::cbrt(3.0);
  EXPECT_NEAR(tab::gamma, 3.0 + a - b, 1e-15);
  EXPECT_NEAR(tab::alpha, 3.0 - (a - b) / 2.0, 1e-15);
  EXPECT_NEAR(tab::beta, std::sqrt(3.0) / 2.0 * (a + b), 1e-15);
}

TEST(Radau5Tableau, CollocatesWithOrderFive) {
  const RadauIia r;
  for (int i = 0; i < 3; ++i) {
    for (int k = 1; k <= 3; ++k) {
      double sum = 0.0;
      for (int j = 0; j < 3; ++j) sum += r.a[i][j] * std::pow(c(j), k - 1);
      EXPECT_NEAR(sum, std::pow(c(i), k) / k, 1e-15) << "simplifying condition C(" << k << ") of stage " << i;
    }
  }
  for (int k = 1; k <= 5; ++k) {
    double sum = 0.0;
    for (int j = 0; j < 3; ++j) sum += r.a[2][j] * std::pow(c(j), k - 1);
    EXPECT_NEAR(sum, 1.0 / k, 1e-15) << "quadrature condition " << k;
  }
}

TEST(Radau5Tableau, DerivedRowsFollowFromTheTransformation) {
  const double q = std::sqrt(6.0);
  const double e[3] = {(-13 - 7 * q) / 3, (-13 + 7 * q) / 3, -1.0 / 3};
  for (int i = 0; i < 3; ++i) {
    const std::size_t k = static_cast<std::size_t>(i);
    EXPECT_NEAR(tab::error_weights[k], e[0] * t(0, i) + e[1] * t(1, i) + e[2] * t(2, i), 1e-14);
    EXPECT_NEAR(t_inverse(1, i), (i == 2 ? 1.0 : 0.0) - t_inverse(0, i), 1e-15);
  }
}

TEST(Radau5Tableau, ErrorEstimateVanishesToOrderThree) {
  // For u' = t^(k-1) the stages z_i = c_i^k/k are exact; f(0) + sum e_i z_i must vanish for k <= 3, with f(0) = 1 for k = 1.
  const double q = std::sqrt(6.0);
  const double e[3] = {(-13 - 7 * q) / 3, (-13 + 7 * q) / 3, -1.0 / 3};
  for (int k = 1; k <= 4; ++k) {
    double sum = k == 1 ? 1.0 : 0.0;
    for (int i = 0; i < 3; ++i) sum += e[i] * std::pow(c(i), k) / k;
    EXPECT_NEAR(sum, k <= 3 ? 0.0 : -1.0 / 40, 1e-14) << k;
  }
}

}  // namespace
}  // namespace stiffront
