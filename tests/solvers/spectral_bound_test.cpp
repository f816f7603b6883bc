// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/solvers/spectral_bound.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>
#include <random>

namespace stiffront {
namespace {

template <int m>
double bound(const Eigen::Matrix<double, m, m>& a) {
  Pack packs[m][m];
  for (int i = 0; i < m; ++i) {
    for (int j = 0; j < m; ++j) packs[i][j] = Pack(a(i, j));
  }
  return spectral_bound<m>(packs)[pack_size - 1];
}

template <int m>
double radius(const Eigen::Matrix<double, m, m>& a) {
  return Eigen::EigenSolver<Eigen::Matrix<double, m, m>>(a).eigenvalues().cwiseAbs().maxCoeff();
}

TEST(SpectralBound, IsNeverBelowTheSpectralRadiusAndRarelyFarAbove) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> decade(-6.0, 6.0);
  for (int repeat = 0; repeat < 1000; ++repeat) {
    Eigen::Matrix3d a;
    Eigen::Vector3d units;
    for (int i = 0; i < 3; ++i) units[i] = std::pow(10.0, decade(random) / 3.0);
    for (int i = 0; i < 9; ++i) a(i / 3, i % 3) = normal(random);
    a = units.asDiagonal() * a * units.cwiseInverse().asDiagonal();  // species in wildly different units
    const double rho = radius<3>(a);
    EXPECT_GE(bound<3>(a), rho * (1 - 1e-12));
    EXPECT_LE(bound<3>(a), 1.6 * rho);
  }
}

TEST(SpectralBound, SeesThroughAStrongOneWayCoupling) {
  Eigen::Matrix3d bz;  // at the peak of a Belousov-Zhabotinsky wave
  bz << -9.2e4, -7.2e6, 1.6e5, -91.8, -7.3e3, 0.0, 0.0, 1.0, -1.0;
  EXPECT_LE(bound<3>(bz), 1.3 * radius<3>(bz));
}

TEST(SpectralBound, HandlesZeroNilpotentAndNonFiniteMatrices) {
  EXPECT_EQ(bound<2>(Eigen::Matrix2d::Zero()), 0.0);
  Eigen::Matrix2d nilpotent;
  nilpotent << 0.0, 1e8, 0.0, 0.0;
  EXPECT_EQ(bound<2>(nilpotent), 0.0);
  Eigen::Matrix2d bad = Eigen::Matrix2d::Identity();
  bad(0, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(std::isfinite(bound<2>(bad)));
}

}  // namespace
}  // namespace stiffront
