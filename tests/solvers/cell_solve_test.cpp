// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/solvers/cell_solve.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <random>
#include <vector>

namespace stiffront {
namespace {

using Complex = std::complex<double>;

/// Matrices whose natural pivots are tiny or zero in some lanes and fine in others.
template <int m>
void draw(std::mt19937_64& random, Pack (&a)[m][m]) {
  std::uniform_real_distribution<double> entry(-1.0, 1.0);
  for (int l = 0; l < pack_size; ++l) {
    for (int i = 0; i < m; ++i) {
      for (int j = 0; j < m; ++j) a[i][j].set(l, entry(random));
      if (l % 3 == 1) a[i][i].set(l, 0.0);
      if (l % 3 == 2) a[i][i].set(l, a[i][i][l] * 1e-14);
    }
  }
}

/// |A x - b| in units of eps |A| |x|, which partial pivoting keeps moderate whatever the condition.
template <int m>
double residual(const Pack (&a)[m][m], const Pack (&x)[m], const Pack (&b)[m], int lane) {
  double worst = 0.0;
  for (int i = 0; i < m; ++i) {
    double r = -b[i][lane];
    double size = std::abs(b[i][lane]);
    for (int j = 0; j < m; ++j) {
      r += a[i][j][lane] * x[j][lane];
      for (int k = 0; k < m; ++k) size = std::max(size, std::abs(a[i][k][lane] * x[j][lane]));
    }
    worst = std::max(worst, std::abs(r) / (size * 2.2e-16));
  }
  return worst;
}

template <int m>
void expect_small_residuals() {
  std::mt19937_64 random(m);
  for (int repeat = 0; repeat < 300; ++repeat) {
    Pack a[m][m];
    Pack b[m];
    draw(random, a);
    for (Pack& v : b) {
      for (int l = 0; l < pack_size; ++l) v.set(l, std::uniform_real_distribution<double>(-1.0, 1.0)(random));
    }
    CellLu<Pack, m, true> lu;
    for (int i = 0; i < m; ++i) {
      for (int j = 0; j < m; ++j) lu(i, j) = a[i][j];
    }
    lu.factor();
    Pack x[m];
    for (int i = 0; i < m; ++i) x[i] = b[i];
    lu.solve(x);
    for (int l = 0; l < pack_size; ++l) {
      if (m == 1 && l % 3 == 1) continue;  // the matrix 0
      EXPECT_LT(residual(a, x, b, l), 20.0 * m) << "lane " << l;
    }
  }
}

TEST(CellSolve, ResidualsAreSmallWhateverTheNaturalPivots) {
  expect_small_residuals<1>();
  expect_small_residuals<2>();
  expect_small_residuals<3>();
  expect_small_residuals<4>();
  expect_small_residuals<9>();
}

template <int m>
void expect_small_complex_residuals() {
  std::mt19937_64 random(m);
  std::uniform_real_distribution<double> entry(-1.0, 1.0);
  for (int repeat = 0; repeat < 300; ++repeat) {
    Pack re[m][m];
    Pack im[m][m];
    draw(random, re);
    draw(random, im);
    ComplexCellLu<Pack, m, true> lu;
    for (int i = 0; i < m; ++i) {
      for (int j = 0; j < m; ++j) {
        lu.re(i, j) = re[i][j];
        lu.im(i, j) = im[i][j];
      }
    }
    lu.factor();
    Pack b_re[m];
    Pack b_im[m];
    for (int i = 0; i < m; ++i) {
      b_re[i] = Pack(entry(random));
      b_im[i] = Pack(entry(random));
    }
    Pack x_re[m];
    Pack x_im[m];
    for (int i = 0; i < m; ++i) {
      x_re[i] = b_re[i];
      x_im[i] = b_im[i];
    }
    lu.solve(x_re, x_im);
    for (int l = 0; l < pack_size; ++l) {
      if (m == 1 && l % 3 == 1) continue;
      for (int i = 0; i < m; ++i) {
        Complex r(-b_re[i][l], -b_im[i][l]);
        double size = std::abs(r);
        for (int j = 0; j < m; ++j) {
          const Complex x(x_re[j][l], x_im[j][l]);
          r += Complex(re[i][j][l], im[i][j][l]) * x;
          size = std::max(size, 1.5 * std::abs(x));
        }
        EXPECT_LT(std::abs(r) / (size * 2.2e-16), 20.0 * m) << "lane " << l;
      }
    }
  }
}

TEST(CellSolve, ComplexResidualsAreSmallWhateverTheNaturalPivots) {
  expect_small_complex_residuals<1>();
  expect_small_complex_residuals<2>();
  expect_small_complex_residuals<3>();
  expect_small_complex_residuals<5>();
}

TEST(CellSolve, ALaneDoesNotFeelItsNeighboursExchanges) {
  constexpr int m = 4;
  std::mt19937_64 random(17);
  Pack a[m][m];
  draw(random, a);
  const auto solve = [&](auto entry) {
    CellLu<Pack, m, true> real;
    ComplexCellLu<Pack, m, true> complex;
    for (int i = 0; i < m; ++i) {
      for (int j = 0; j < m; ++j) {
        real(i, j) = complex.re(i, j) = entry(i, j);
        complex.im(i, j) = Pack(i == j ? 0.3 : 0.0);
      }
    }
    real.factor();
    complex.factor();
    std::vector<Pack> x{1.0, 2.0, 3.0, 4.0, 1.0, 2.0, 3.0, 4.0, -1.0, 0.5, 0.0, 1.0};
    real.solve(x.data());
    complex.solve(x.data() + m, x.data() + 2 * m);
    return x;
  };
  const std::vector<Pack> together = solve([&](int i, int j) { return a[i][j]; });
  for (int l = 0; l < pack_size; ++l) {
    const std::vector<Pack> alone = solve([&](int i, int j) { return Pack(a[i][j][l]); });
    for (std::size_t i = 0; i < together.size(); ++i) EXPECT_EQ(together[i][l], alone[i][(l + 1) % pack_size]);
  }
}

/// Diagonally dominant: no lane needs an exchange.
template <class Lu, class ComplexLu>
std::vector<Pack> solve_dominant(Lu& real, ComplexLu& complex) {
  constexpr int m = 3;
  for (int i = 0; i < m; ++i) {
    for (int j = 0; j < m; ++j) {
      Pack x;
      for (int l = 0; l < pack_size; ++l) x.set(l, i == j ? 3.0 + 0.1 * l : std::sin(1.0 + i + 3 * j + 7 * l));
      real(i, j) = complex.re(i, j) = x;
      complex.im(i, j) = Pack(i == j ? 0.3 : 0.0);
    }
  }
  EXPECT_TRUE(real.factor());
  EXPECT_TRUE(complex.factor());
  std::vector<Pack> x{1.0, 2.0, 3.0, 1.0, 2.0, 3.0, -1.0, 0.5, 0.0};
  real.solve(x.data());
  complex.solve(x.data() + m, x.data() + 2 * m);
  return x;
}

TEST(CellSolve, BothKindsGiveTheSameBitsWhereNothingIsExchanged) {
  CellLu<Pack, 3, true> real_with;
  CellLu<Pack, 3, false> real_without;
  ComplexCellLu<Pack, 3, true> complex_with;
  ComplexCellLu<Pack, 3, false> complex_without;
  const std::vector<Pack> a = solve_dominant(real_with, complex_with);
  const std::vector<Pack> b = solve_dominant(real_without, complex_without);
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_TRUE(all(a[i] == b[i])) << i;
}

TEST(CellSolve, ALaneThatNeedsAnExchangeIsNoticed) {
  for (int lane = 0; lane < pack_size; ++lane) {
    CellLu<Pack, 2, false> real;
    ComplexCellLu<Pack, 2, false> complex;
    for (int i = 0; i < 2; ++i) {
      for (int j = 0; j < 2; ++j) {
        real(i, j) = complex.re(i, j) = Pack(i == j ? 1.0 : -7.0);
        complex.im(i, j) = Pack(0.0);
      }
    }
    real(1, 0).set(lane, 9.0);
    complex.im(1, 0).set(lane, -2.0);
    EXPECT_FALSE(real.factor());
    EXPECT_FALSE(complex.factor());
  }
}

TEST(CellSolve, ASingularMatrixGivesNumbersThatAreNotFinite) {
  CellLu<double, 2, false> lu;
  lu(0, 0) = lu(1, 1) = lu(0, 1) = lu(1, 0) = 1.0;
  lu.factor();
  double x[2] = {1.0, 2.0};
  lu.solve(x);
  EXPECT_FALSE(is_finite(x[0]));
}

}  // namespace
}  // namespace stiffront
