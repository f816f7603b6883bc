// SPDX-License-Identifier: BSD-3-Clause
//
// The stability polynomial is R(z) = w(z) p_n(z), n = s - 4, where w has degree 4 and no real zero, and p_n is the
// orthogonal polynomial of degree n for the weight w(z(x))^2 / sqrt(1 - x^2), with x = a + d z. The three-term
// recurrence of p_n is the recurrence of the stages; w is realised by the four stages of the finishing procedure.
#include "stiffront/solvers/rock4_coefficients.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "stiffront/core/error.hpp"

namespace stiffront {
namespace {

using Vector4 = std::array<double, 4>;
using Matrix4 = std::array<Vector4, 4>;

/// Taylor coefficients of z^0 .. z^4.
using Taylor = std::array<double, 5>;

/// Gaussian elimination with partial pivoting.
Vector4 solve(Matrix4 m, Vector4 rhs) {
  for (std::size_t k = 0; k < 4; ++k) {
    std::size_t pivot = k;
    for (std::size_t i = k + 1; i < 4; ++i)
      if (std::abs(m[i][k]) > std::abs(m[pivot][k])) pivot = i;
    std::swap(m[k], m[pivot]);
    std::swap(rhs[k], rhs[pivot]);
    for (std::size_t i = k + 1; i < 4; ++i) {
      const double factor = m[i][k] / m[k][k];
      for (std::size_t j = k; j < 4; ++j) m[i][j] -= factor * m[k][j];
      rhs[i] -= factor * rhs[k];
    }
  }
  for (std::size_t k = 4; k-- > 0;) {
    for (std::size_t j = k + 1; j < 4; ++j) rhs[k] -= m[k][j] * rhs[j];
    rhs[k] /= m[k][k];
  }
  return rhs;
}

/// The map x = a + d z takes z in [-l, 0] to [-1, a], with a = 1 + A/s^2 and l = L s^2.
///
/// A and L are free parameters: the order conditions hold for any of them. They are chosen so that the second ripple
/// of |R| and the largest of all later ones both equal 0.95, which makes l as large as that damping allows. The two
/// functions of 1/s^2 were fitted to the solutions of this equal-ripple problem; the ripples are 0.95 within 1.1e-6.
struct Interval {
  double a, d;
};

Interval interval_map(int stages) {
  const double s2 = static_cast<double>(stages) * stages;
  const double x = 1.0 / s2;
  double A = 0.0;
  double L = 0.0;
  switch (stages) {
    case 5:
      A = -1.0, L = 0.2399199439;
      break;  // one recurrence coefficient only: A is not determined by the ripples
    case 6:
      A = -1.137815338, L = 0.2743065535;
      break;
    case 7:
      A = -1.140728347, L = 0.2950026003;
      break;
    default:
      A = -1.0930927617 + x * (-3.01595075 + x * (2.97395 + x * 1409.749));
      L = 0.353199420166 + x * (-2.8966659798 + x * (2.4619609063 + x * (-5.38719203 + x * -347.675734)));
  }
  const double a = 1.0 + A * x;
  return {a, (1.0 + a) / (L * s2)};
}

struct Recurrence {
  std::vector<double> mu, nu, kappa;
};

/// The recurrence of p_n for the weight w = 1 + c_1 z + .. + c_4 z^4, by the discrete Stieltjes procedure.
///
/// Gauss-Chebyshev quadrature with s + 2 nodes is exact for every product that occurs. Nodal values are doubled at
/// each step because monic orthogonal polynomials on [-1, 1] shrink like 2^-j.
Recurrence orthogonal_recurrence(const Interval& map, const Vector4& c, int n) {
  const std::size_t n_nodes = static_cast<std::size_t>(n) + 6;
  std::vector<double> x(n_nodes), weight(n_nodes), current(n_nodes, 1.0), previous(n_nodes, 0.0);
  for (std::size_t k = 0; k < n_nodes; ++k) {
    x[k] = std::cos((2.0 * static_cast<double>(k) + 1.0) * std::numbers::pi / (2.0 * static_cast<double>(n_nodes)));
    const double z = (x[k] - map.a) / map.d;
    const double w = 1.0 + z * (c[0] + z * (c[1] + z * (c[2] + z * c[3])));
    weight[k] = w * w;
  }
  const double largest = *std::max_element(weight.begin(), weight.end());
  for (double& w : weight) w /= largest;

  Recurrence r;
  double norm_previous = 0.0;
  double ratio_previous = 0.0;  // q_{j-1} = pi_j(a) / pi_{j-1}(a)
  for (int j = 0; j < n; ++j) {
    double norm = 0.0;
    double moment = 0.0;
    for (std::size_t k = 0; k < n_nodes; ++k) {
      const double term = weight[k] * current[k] * current[k];
      norm += term;
      moment += x[k] * term;
    }
    const double alpha = moment / norm;
    const double beta = j == 0 ? 0.0 : norm / (4.0 * norm_previous);  // 4: the doubled values
    const double ratio = map.a - alpha - (j == 0 ? 0.0 : beta / ratio_previous);
    const double kappa = j == 0 ? 0.0 : -beta / (ratio * ratio_previous);
    // nu + kappa = 1 must hold exactly, or constants drift systematically: 1 - nu is exact because 1 <= nu <= 2.
    const double nu = 1.0 - kappa;
    r.mu.push_back(map.d / ratio);
    r.nu.push_back(nu);
    r.kappa.push_back(1.0 - nu);
    for (std::size_t k = 0; k < n_nodes; ++k) {
      const double next = 2.0 * ((x[k] - alpha) * current[k] - 2.0 * beta * previous[k]);
      previous[k] = current[k];
      current[k] = next;
    }
    norm_previous = norm;
    ratio_previous = ratio;
  }
  return r;
}

Taylor taylor_of_recurrence(const Recurrence& r) {
  Taylor previous{};
  Taylor current{1.0, 0.0, 0.0, 0.0, 0.0};
  for (std::size_t j = 0; j < r.mu.size(); ++j) {
    Taylor next;
    for (std::size_t k = 0; k < 5; ++k)
      next[k] = (k == 0 ? 0.0 : r.mu[j] * current[k - 1]) + r.nu[j] * current[k] + r.kappa[j] * previous[k];
    previous = current;
    current = next;
  }
  return current;
}

/// c_1 .. c_4 of trunc_4(e^z / p_n(z)): what w must be for R to have order 4.
Vector4 required_weight(const Recurrence& r) {
  constexpr std::array<double, 5> inverse_factorial{1.0, 1.0, 1.0 / 2.0, 1.0 / 6.0, 1.0 / 24.0};
  const Taylor t = taylor_of_recurrence(r);
  Taylor c{1.0, 0.0, 0.0, 0.0, 0.0};
  for (std::size_t k = 1; k < 5; ++k) {
    c[k] = inverse_factorial[k];
    for (std::size_t i = 1; i <= k; ++i) c[k] -= t[i] * c[k - i];
  }
  return {c[1], c[2], c[3], c[4]};
}

/// Solves w = trunc_4(e^z / p_n[w]) by Newton's method with difference quotients.
///
/// The unknowns are the coefficients of w, not its zeros: they are of order 1 and smooth in s, and one starting point
/// serves every s. A residual left here changes the damping a little, never the order.
Recurrence solve_order_conditions(const Interval& map, int n) {
  Vector4 c{0.673842, 0.232458, 0.054438, 0.0097052};  // the limit for many stages
  constexpr double increment = 1e-7;
  constexpr double converged = 1e-13;
  for (int iteration = 0; iteration < 30; ++iteration) {
    const Recurrence r = orthogonal_recurrence(map, c, n);
    const Vector4 image = required_weight(r);
    double residual = 0.0;
    Vector4 defect;
    for (std::size_t k = 0; k < 4; ++k) {
      defect[k] = c[k] - image[k];
      residual = std::max(residual, std::abs(defect[k]));
    }
    if (residual < converged) return r;
    Matrix4 jacobian;
    for (std::size_t j = 0; j < 4; ++j) {
      Vector4 shifted = c;
      shifted[j] += increment;
      const Vector4 moved = required_weight(orthogonal_recurrence(map, shifted, n));
      for (std::size_t i = 0; i < 4; ++i) jacobian[i][j] = (i == j ? 1.0 : 0.0) - (moved[i] - image[i]) / increment;
    }
    const Vector4 correction = solve(jacobian, defect);
    for (std::size_t k = 0; k < 4; ++k) c[k] -= correction[k];
  }
  throw Error(ErrorKind::bug, fmt::format("no stability polynomial found for ROCK4 with {} stages", n + 4));
}

/// Elementary weights of the trees  tau, [tau], [tau,tau], [[tau]], [tau^3], [tau,[tau]], [[tau^2]], [[[tau]]].
using Trees = std::array<double, 8>;

/// Weights of h f(g) from those of g.
Trees derivative(const Trees& g) { return {1.0, g[0], g[0] * g[0], g[1], g[0] * g[0] * g[0], g[0] * g[1], g[2], g[3]}; }

/// Weights of g_n, from the rounded coefficients, so that the finishing procedure absorbs every error made so far.
Trees weights_of_recurrence(const Recurrence& r) {
  Trees previous{};
  Trees current{};
  for (std::size_t j = 0; j < r.mu.size(); ++j) {
    const Trees f = derivative(current);
    Trees next;
    for (std::size_t k = 0; k < 8; ++k) next[k] = r.mu[j] * f[k] + r.nu[j] * current[k] + r.kappa[j] * previous[k];
    previous = current;
    current = next;
  }
  return current;
}

/// The four finishing stages, in closed form.
///
/// In the shifted nodes y_i = c_i - c_1 they are an explicit Runge-Kutta method whose order conditions have the right
/// hand sides m_k = sum b y^k and n_0 .. n_3 = sum b_i G_i, sum b_i y_i G_i, sum b_i a_ij y_j^2, sum b_i a_ij G_j, with
/// G = a y. Eight conditions leave y_3 and y_4 free; eliminating the others gives an equation bilinear in y_2 and y_4.
void finishing_procedure(const Trees& alpha, Rock4Coefficients& m) {
  constexpr Trees inverse_gamma{1.0, 1.0 / 2.0, 1.0 / 3.0, 1.0 / 6.0, 1.0 / 4.0, 1.0 / 8.0, 1.0 / 12.0, 1.0 / 24.0};
  Trees u;
  for (std::size_t k = 0; k < 8; ++k) u[k] = inverse_gamma[k] - alpha[k];
  const double c1 = alpha[0];
  const double m0 = u[0];
  const double m1 = u[1] - c1 * u[0];
  const double m2 = u[2] - 2.0 * c1 * u[1] + c1 * c1 * u[0];
  const double m3 = u[4] - 3.0 * c1 * u[2] + 3.0 * c1 * c1 * u[1] - c1 * c1 * c1 * u[0];
  const double n0 = u[3] - alpha[1] * m0 - c1 * m1;
  const double n1 = u[5] - c1 * u[3] - alpha[1] * m1 - c1 * m2;
  const double n2 = u[6] - alpha[2] * m0 - c1 * c1 * m1 - 2.0 * c1 * n0;
  const double n3 = u[7] - alpha[3] * m0 - alpha[1] * m1 - c1 * n0;

  // The free nodes: an error constant 29 % below that of 1/3 and 2/3, with all coefficients below 1 for s >= 6.
  const double y3 = 0.5 * m0;
  const double y4 = 0.75 * m0;
  const double y2 = -(n3 * m3 - n1 * n2 + y4 * (n0 * n2 - n3 * m2)) / (n0 * n1 - n3 * m2 + y4 * (n3 * m1 - n0 * n0));

  const auto weight = [&](double yi, double yj, double yk) { return (m3 - (yj + yk) * m2 + yj * yk * m1) / (yi * (yi - yj) * (yi - yk)); };
  const double b2 = weight(y2, y3, y4);
  const double b3 = weight(y3, y2, y4);
  const double b4 = weight(y4, y2, y3);
  const double sum_ba3 = (n2 - y2 * n0) / (y3 * (y3 - y2));  // sum_i b_i a_i3
  const double sum_ba2 = (n0 - sum_ba3 * y3) / y2;
  const double a32 = n3 / sum_ba3 / y2;
  const double a43 = sum_ba3 / b4;
  const double a42 = (sum_ba2 - b3 * a32) / b4;

  m.b = {m0 - b2 - b3 - b4, b2, b3, b4};
  m.a = {};
  m.a[1][0] = y2;
  m.a[2][0] = y3 - a32;
  m.a[2][1] = a32;
  m.a[3][0] = y4 - a42 - a43;
  m.a[3][1] = a42;
  m.a[3][2] = a43;
  m.c = {c1, c1 + y2, c1 + y3, c1 + y4};

  // The estimate vanishes on the four trees of order <= 3; d_i is the weight of [tau] in the argument of k_i.
  const Vector4 d{alpha[1], alpha[1] + c1 * y2, alpha[1] + c1 * y3 + a32 * y2, alpha[1] + c1 * y4 + a42 * y2 + a43 * y3};
  Matrix4 conditions;
  for (std::size_t i = 0; i < 4; ++i) {
    conditions[0][i] = 1.0;
    conditions[1][i] = m.c[i];
    conditions[2][i] = m.c[i] * m.c[i];
    conditions[3][i] = d[i];
  }
  m.e = solve(conditions, {alpha[0], alpha[1], alpha[2], alpha[3]});
  // 0.05 was calibrated on eight problems and seven tolerances: global error / tolerance 0.56 on average, 1.9 at worst.
  m.d0 = 0.05;
}

}  // namespace

Rock4Coefficients rock4_coefficients(int stages) {
  if (stages < rock4_min_stages) throw Error(ErrorKind::bug, fmt::format("ROCK4 has at least {} stages, not {}", rock4_min_stages, stages));
  const int n = stages - 4;
  const Recurrence r = solve_order_conditions(interval_map(stages), n);
  Rock4Coefficients m;
  m.stages = stages;
  m.ct.assign(static_cast<std::size_t>(n) + 1, 0.0);
  m.ct[1] = r.mu[0];
  for (std::size_t j = 2; j < m.ct.size(); ++j) m.ct[j] = r.mu[j - 1] + r.nu[j - 1] * m.ct[j - 1] + r.kappa[j - 1] * m.ct[j - 2];
  finishing_procedure(weights_of_recurrence(r), m);
  m.mu = r.mu;
  m.nu = r.nu;
  m.kappa = r.kappa;
  m.interval = rock4_interval(stages);
  return m;
}

double rock4_interval(int stages) { return 0.353199 * static_cast<double>(stages) * stages - 2.895; }

int rock4_stages(double h_rho) {
  if (!(h_rho >= 0.0 && h_rho < 3.5e15))
    throw Error(ErrorKind::bug, fmt::format("ROCK4 cannot be given enough stages for h * rho = {}", h_rho));
  int stages = std::max(rock4_min_stages, static_cast<int>(std::sqrt((h_rho + 2.895) / 0.353199)) - 1);
  while (rock4_interval(stages) < h_rho) ++stages;
  return stages;
}

int rock4_max_stages(double tolerance) {
  return std::clamp(static_cast<int>(290.0 * std::pow(std::min(tolerance, 1.0), 0.125)), rock4_min_stages, 150);
}

const Rock4Coefficients& Rock4Table::operator[](int stages) {
  const auto found = methods_.find(stages);
  if (found != methods_.end()) return found->second;
  return methods_.emplace(stages, rock4_coefficients(stages)).first->second;
}

}  // namespace stiffront
