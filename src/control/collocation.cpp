// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/collocation.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "stiffront/control/lagrange.hpp"
#include "stiffront/core/error.hpp"

namespace stiffront {
namespace {

// Extended precision, so that what is rounded to double at the end is correct to the last place.
using Real = long double;

/// Legendre polynomial P_n and its derivative at x, by the three-term recurrence.
struct Legendre {
  Real value;
  Real derivative;
};

Legendre legendre(int n, Real x) {
  Real p0 = 1, p1 = x, d0 = 0, d1 = 1;
  if (n == 0) return {p0, d0};
  for (int k = 1; k < n; ++k) {
    const Real kk = k;
    const Real p2 = ((2 * kk + 1) * x * p1 - kk * p0) / (kk + 1);
    const Real d2 = d0 + (2 * kk + 1) * p1;
    p0 = p1, p1 = p2, d0 = d1, d1 = d2;
  }
  return {p1, d1};
}

/// The polynomial on [-1, 1] whose zeros are the free nodes of a family, and its derivative.
///   Legendre: P_m.   Right Radau: (P_{m-1} - P_m)/(1 - x) has the zeros besides 1; the quotient is avoided by deflating 1.
///   Lobatto: P'_{m-1}, through (1 - x^2) P'' = 2 x P' - n (n + 1) P.
Legendre nodal(NodeFamily family, int m, Real x) {
  switch (family) {
    case NodeFamily::gauss_legendre:
      return legendre(m, x);
    case NodeFamily::gauss_radau: {
      const Legendre a = legendre(m - 1, x), b = legendre(m, x);
      return {a.value - b.value, a.derivative - b.derivative};
    }
    case NodeFamily::gauss_lobatto: {
      const int n = m - 1;
      const Legendre p = legendre(n, x);
      return {p.derivative, (2 * x * p.derivative - Real(n) * (n + 1) * p.value) / (1 - x * x)};
    }
  }
  throw Error(ErrorKind::bug, "unknown family of nodes");
}

/// Nodes on [-1, 1], ascending. Newton's method from cosine guesses with the roots found so far deflated.
std::vector<Real> nodes(NodeFamily family, int m) {
  const Real pi = std::numbers::pi_v<Real>;
  std::vector<Real> roots;
  std::vector<Real> fixed;
  int free = m;
  if (family == NodeFamily::gauss_radau) {
    fixed = {1};
    free = m - 1;
  } else if (family == NodeFamily::gauss_lobatto) {
    fixed = {-1, 1};
    free = m - 2;
  }
  for (int i = 0; i < free; ++i) {
    Real x = 0;
    switch (family) {
      case NodeFamily::gauss_legendre:
        x = -std::cos(pi * (i + Real(0.75)) / (m + Real(0.5)));
        break;
      case NodeFamily::gauss_radau:
        x = -std::cos(pi * (2 * i + Real(1.5)) / (2 * m - Real(0.5)));
        break;
      case NodeFamily::gauss_lobatto:
        x = -std::cos(pi * (i + 1) / (m - 1));
        break;
    }
    for (int iteration = 0; iteration < 50; ++iteration) {
      const Legendre f = nodal(family, m, x);
      Real deflation = 0;
      for (Real r : roots) deflation += 1 / (x - r);
      if (family == NodeFamily::gauss_radau) deflation += 1 / (x - 1);
      const Real step = f.value / (f.derivative - f.value * deflation);
      x -= step;
      if (std::abs(step) < Real(1e-18)) break;
    }
    roots.push_back(x);
  }
  std::vector<Real> all;
  if (family == NodeFamily::gauss_lobatto) all.push_back(-1);
  all.insert(all.end(), roots.begin(), roots.end());
  if (!fixed.empty()) all.push_back(1);
  if (family != NodeFamily::gauss_radau) {
    for (int i = 0; i < m / 2; ++i) {  // exact symmetry
      const auto lower = static_cast<std::size_t>(i), upper = static_cast<std::size_t>(m - 1 - i);
      const Real x = (all[upper] - all[lower]) / 2;
      all[lower] = -x;
      all[upper] = x;
    }
    if (m % 2 == 1) all[static_cast<std::size_t>(m / 2)] = 0;
  }
  return all;
}

/// Integral over [0, upper] of each Lagrange polynomial, by Gauss-Legendre quadrature that is exact for their degree.
std::vector<Real> integrate(const std::vector<Real>& c, Real upper) {
  const int points = static_cast<int>(c.size()) / 2 + 1;
  std::vector<Real> integral(c.size(), 0);
  for (Real x : nodes(NodeFamily::gauss_legendre, points)) {
    const Legendre p = legendre(points, x);
    const Real weight = 2 / ((1 - x * x) * p.derivative * p.derivative);
    const std::vector<Real> l = lagrange(c, upper * (x + 1) / 2);
    for (std::size_t a = 0; a < c.size(); ++a) integral[a] += upper / 2 * weight * l[a];
  }
  return integral;
}

std::vector<double> rounded(const std::vector<Real>& v) {
  std::vector<double> r;
  for (Real x : v) r.push_back(static_cast<double>(x));
  return r;
}

}  // namespace

CollocationNodes collocation_nodes(NodeFamily family, int m) {
  const int least = family == NodeFamily::gauss_lobatto ? 2 : 1;
  if (m < least || m > 16) throw Error(ErrorKind::input, fmt::format("expected {} to 16 collocation nodes, got {}", least, m));
  std::vector<Real> c;
  for (Real x : nodes(family, m)) c.push_back((x + 1) / 2);
  CollocationNodes n;
  n.c = rounded(c);
  for (Real x : c) n.s.push_back(rounded(integrate(c, x)));
  n.w = rounded(integrate(c, 1));
  n.end = rounded(lagrange(c, Real{1}));
  n.quadrature_order = family == NodeFamily::gauss_legendre ? 2 * m : (family == NodeFamily::gauss_radau ? 2 * m - 1 : 2 * m - 2);
  return n;
}

}  // namespace stiffront
