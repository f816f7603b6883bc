// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "plane_level.hpp"
#include "species_count.hpp"
#include "stiffront/core/error.hpp"
#include "stiffront/solvers/coarse_grids.hpp"
#include "stiffront/solvers/implicit_part.hpp"

namespace stiffront {
namespace {

// Weights of the damped cell-Jacobi steps before and after the correction on the coarser grid. Together they are the Chebyshev
// polynomial of degree 2 for the upper three quarters of the spectrum.
constexpr double weight_before = 1.389;
constexpr double weight_after = 0.562;
// A grid on which the coupling is this weak needs no coarser one: three cell-Jacobi steps do.
constexpr double weak_coupling = 0.25;
// A basis vector of which less than this part (squared) is new is made orthogonal twice.
constexpr double least_rest = 1e-2;
constexpr std::size_t basis_size = 10;
constexpr int most_iterations = 60;
// Changes below this part of a species' largest value are round-off.
constexpr double round_off = 1e-15;

template <int m>
class PlanePart final : public ImplicitPart {
 public:
  PlanePart(const Field& shape, const DiffusionOperator& diffusion, const ReactionTerm& reaction, ImplicitTerms terms, double tolerance)
      : reaction_(&reaction),
        terms_(terms),
        tolerance_(tolerance),
        comm_(&shape.comm()),
        fixed_points_(diffusion.boundary().has_dirichlet()),
        jacobian_(shape.decomposition(), m * m, 1),
        agreement_(static_cast<int>(basis_size) + 1, m) {
    double strongest = 0.0;
    int leading = 0;
    for (int s = 0; s < m; ++s) {
      k_x_[s] = terms.gamma_diffusion * diffusion.k_x(s);
      k_y_[s] = terms.gamma_diffusion * diffusion.k_y(s);
      if (k_x_[s] > strongest) strongest = k_x_[s], leading = s;
    }
    grids_ = coarse_grids(shape.decomposition(), diffusion.boundary(), k_x_[leading], k_y_[leading]);
    levels_.reserve(grids_.size());
    const PlaneView finest = view(jacobian_);
    for (std::size_t l = 0; l < grids_.size(); ++l) levels_.emplace_back(shape.decomposition(), grids_[l], l == 0 ? &finest : nullptr);
    for (std::size_t k = 0; k <= basis_size; ++k) basis_.emplace_back(m, grids_[0].n[0], grids_[0].n[1]);
    solution_.emplace_back(m, grids_[0].n[0], grids_[0].n[1]);
  }

  void solve(double t, double h, const Field& at, Field& b, Work& work) override {
    if (terms_.reaction) {
      if (terms_.stiff_rates_only) {
        reaction_->stiff_jacobian(t, at, jacobian_, grids_[0].free);
      } else {
        reaction_->jacobian(t, at, jacobian_, grids_[0].free);
      }
      work.reaction_jacobians +=
          static_cast<std::int64_t>(grids_[0].free.i_end - grids_[0].free.i_begin) * (grids_[0].free.j_end - grids_[0].free.j_begin);
    }
    set_matrices(h);
    ++solves_;
    PlaneLevel<m>& fine = levels_[0];
    const PlaneView u = solution_[0];
    // At first the solution is what is known of it: zero, and the values of Dirichlet points.
    copy_known(b, u);
    double left = 0.0;
    int iterations = 0;
    do {
      begin_residual(b, u, iterations > 0 || fixed_points_);
      cycle(0);
      copy_cells(fine.x, basis_[0]);
      if (iterations == 0) choose_weights(at);
      left = std::sqrt(products(1, basis_[0]).back());
      if (!(left > tolerance_) || !std::isfinite(left)) {
        add_to(u, 1.0, basis_[0]);
        break;
      }
      scale(basis_[0], 1.0 / left);
      left = krylov(left, iterations);
      for (std::size_t k = 0; k < coefficients_.size(); ++k) add_to(u, coefficients_[k], basis_[k]);
    } while (left > tolerance_ && iterations < most_iterations);
    if (left > tolerance_) ++unfinished_;
    work.linear_iterations += iterations;
    copy_cells(u, view(b));
  }

  std::string closing_note() const override {
    if (unfinished_ == 0) return {};
    return fmt::format(
        "{} of {} implicit solves of sdc stopped after {} iterations, before method.linear_tolerance was reached; a smaller step "
        "makes them easier",
        unfinished_, solves_, most_iterations);
  }

 private:
  void set_matrices(double h) {
    double k_x[m];
    double k_y[m];
    for (int s = 0; s < m; ++s) k_x[s] = h * k_x_[s], k_y[s] = h * k_y_[s];
    n_levels_ = 1;
    levels_[0].set_matrix(h, k_x, k_y);
    while (levels_[n_levels_ - 1].coupling() > weak_coupling && n_levels_ < levels_.size()) {
      PlaneLevel<m>& fine = levels_[n_levels_ - 1];
      PlaneLevel<m>& coarse = levels_[n_levels_];
      if (terms_.reaction) {
        fine.exchange(fine.jacobian(), m * m);
        fine.restrict_to(coarse, fine.jacobian(), coarse.jacobian(), m * m);
        if (is_first_whole(n_levels_)) coarse.gather(coarse.jacobian(), m * m);
      }
      coarse.set_matrix(h, k_x, k_y);
      ++n_levels_;
    }
  }
  bool is_first_whole(std::size_t l) const { return !grids_[l].contributions.empty(); }

  /// One V-cycle for A x = b on a level, from x = 0.
  void cycle(std::size_t l) {
    PlaneLevel<m>& level = levels_[l];
    if (l + 1 == n_levels_) {
      level.begin(1.0);
      if (l > 0 && level.coupling() > 0.0) level.smooth(1.0), level.smooth(1.0);
      return;
    }
    PlaneLevel<m>& coarse = levels_[l + 1];
    level.begin(weight_before);
    level.exchange(level.x, m);
    level.residual(level.b, level.x, level.r);
    level.exchange(level.r, m);
    level.restrict_to(coarse, level.r, coarse.b, m);
    if (is_first_whole(l + 1)) coarse.gather(coarse.b, m);
    cycle(l + 1);
    coarse.exchange(coarse.x, m);
    level.add_from(coarse);
    level.smooth(weight_after);
  }

  /// The right side of the finest level becomes b - A u.
  void begin_residual(Field& b, const PlaneView& u, bool u_is_not_zero) {
    PlaneLevel<m>& fine = levels_[0];
    if (u_is_not_zero) {
      fine.exchange(u, m);
      fine.residual(view(b), u, fine.b);
    } else {
      copy_cells(view(b), fine.b);
    }
  }

  /// Arnoldi's process and the least-squares problem, from the first basis vector on. @return the norm of the residual
  double krylov(double norm, int& iterations) {
    PlaneLevel<m>& fine = levels_[0];
    std::array<std::array<double, basis_size>, basis_size + 1> h{};
    std::array<double, basis_size> cosine{}, sine{};
    std::array<double, basis_size + 1> g{};
    g[0] = norm;
    std::size_t k = 0;
    double left = norm;
    while (k < basis_size && iterations < most_iterations && left > tolerance_) {
      fine.exchange(basis_[k], m);
      fine.apply(basis_[k], fine.b);
      cycle(0);
      ++iterations;
      // Of the new vector the old one is the larger part by far; without it the others are orthogonal to all digits.
      subtract(fine.x, basis_[k], basis_[k + 1]);
      h[k][k] = 1.0;
      double rest = 0.0;
      for (int pass = 0; pass < 2; ++pass) {
        const std::vector<double>& c = products(k + 2, basis_[k + 1]);
        rest = c[k + 1];
        for (std::size_t i = 0; i <= k; ++i) {
          h[i][k] += c[i];
          rest -= c[i] * c[i];
        }
        subtract_projections(k + 1, c);
        // Little was left: what was taken away has left round-off of its own size behind.
        if (rest > least_rest * c[k + 1]) break;
      }
      h[k + 1][k] = std::sqrt(std::max(rest, 0.0));
      if (h[k + 1][k] > 0.0) scale(basis_[k + 1], 1.0 / h[k + 1][k]);
      for (std::size_t i = 0; i < k; ++i) rotate(cosine[i], sine[i], h[i][k], h[i + 1][k]);
      const double length = std::hypot(h[k][k], h[k + 1][k]);
      cosine[k] = h[k][k] / length, sine[k] = h[k + 1][k] / length;
      const bool breaks_down = h[k + 1][k] <= 1e-14 * length;
      rotate(cosine[k], sine[k], h[k][k], h[k + 1][k]);
      rotate(cosine[k], sine[k], g[k], g[k + 1]);
      left = std::abs(g[k + 1]);
      ++k;
      // That can be the solution; the residual itself will tell.
      if (breaks_down) left = std::numeric_limits<double>::infinity();
      if (!std::isfinite(left)) break;
    }
    coefficients_.assign(g.begin(), g.begin() + static_cast<std::ptrdiff_t>(k));
    for (std::size_t i = k; i-- > 0;) {
      for (std::size_t q = i + 1; q < k; ++q) coefficients_[i] -= h[i][q] * coefficients_[q];
      coefficients_[i] /= h[i][i];
    }
    return left;
  }
  static void rotate(double c, double s, double& x, double& y) {
    const double a = c * x + s * y;
    y = c * y - s * x;
    x = a;
  }

  /// Each species counts relative to the size of its part of the first approximation, which then has the norm sqrt(m).
  void choose_weights(const Field& at) {
    PlaneLevel<m>& fine = levels_[0];
    agreement_.sums.assign(m, ReproducibleSum());
    agreement_.maxima.assign(m, 0.0);
    for (std::size_t s = 0; s < m; ++s) {
      const int species = static_cast<int>(s);
      Pack largest(0.0);
      fine.for_cells([&](int i, int j, int n) {
        const Pack v = Pack::load(basis_[0].row(species, j) + i);
        agreement_.sums[s].add(v * v, Mask::first(n));
        largest = max(largest, abs(Pack::load_partial(at.row(species, j) + i, n)));
      });
      agreement_.maxima[s] = max_lane(largest);
    }
    comm_->agree(agreement_);
    const double n_points = static_cast<double>(grids_[0].x().n_free()) * grids_[0].y().n_free();
    for (std::size_t s = 0; s < m; ++s) {
      const double least = round_off * agreement_.maxima[s];
      const double square = std::max(agreement_.sums[s].value(), n_points * least * least);
      weights_[s] = square > 0.0 ? 1.0 / square : 0.0;
    }
  }

  /// Inner products of w with the first n - 1 basis vectors and itself.
  const std::vector<double>& products(std::size_t n, const PlaneView& w) {
    agreement_.sums.assign(n, ReproducibleSum());
    agreement_.maxima.clear();
    for (int s = 0; s < m; ++s) {
      const Pack weight(weights_[s]);
      levels_[0].for_cells([&](int i, int j, int count) {
        const Mask points = Mask::first(count);
        const Pack v = Pack::load(w.row(s, j) + i);
        const Pack weighted = weight * v;
        for (std::size_t k = 0; k + 1 < n; ++k) agreement_.sums[k].add(Pack::load(basis_[k].row(s, j) + i) * weighted, points);
        agreement_.sums[n - 1].add(v * weighted, points);
      });
    }
    comm_->agree(agreement_);
    products_.clear();
    for (const ReproducibleSum& sum : agreement_.sums) products_.push_back(sum.value());
    return products_;
  }

  /// Of basis vector n the parts along the ones before are taken away.
  void subtract_projections(std::size_t n, const std::vector<double>& c) {
    for (int s = 0; s < m; ++s) {
      levels_[0].for_cells([&](int i, int j, int count) {
        double* to = basis_[n].row(s, j) + i;
        Pack sum = Pack::load(to);
        for (std::size_t k = 0; k < n; ++k) sum = neg_mul_add(Pack(c[k]), Pack::load(basis_[k].row(s, j) + i), sum);
        sum.store_partial(to, count);
      });
    }
  }
  void scale(const PlaneView& u, double factor) {
    for (int s = 0; s < m; ++s) {
      levels_[0].for_cells([&](int i, int j, int n) { (Pack(factor) * Pack::load(u.row(s, j) + i)).store_partial(u.row(s, j) + i, n); });
    }
  }
  void add_to(const PlaneView& u, double factor, const PlaneView& v) {
    for (int s = 0; s < m; ++s) {
      levels_[0].for_cells([&](int i, int j, int n) {
        mul_add(Pack(factor), Pack::load(v.row(s, j) + i), Pack::load(u.row(s, j) + i)).store_partial(u.row(s, j) + i, n);
      });
    }
  }
  void subtract(const PlaneView& u, const PlaneView& v, const PlaneView& result) {
    for (int s = 0; s < m; ++s) {
      levels_[0].for_cells(
          [&](int i, int j, int n) { (Pack::load(u.row(s, j) + i) - Pack::load(v.row(s, j) + i)).store_partial(result.row(s, j) + i, n); });
    }
  }
  void copy_cells(const PlaneView& from, const PlaneView& to) {
    for (int s = 0; s < m; ++s) {
      levels_[0].for_cells([&](int i, int j, int n) { Pack::load(from.row(s, j) + i).store_partial(to.row(s, j) + i, n); });
    }
  }
  /// The Dirichlet points of b; unknowns are zero.
  void copy_known(const Field& b, const PlaneView& u) {
    const FreeBox& free = grids_[0].free;
    for (int s = 0; s < m; ++s) {
      for (int j = 0; j < b.n_y(); ++j) {
        double* to = u.row(s, j);
        std::copy_n(b.row(s, j), b.n_x(), to);
        if (j >= free.j_begin && j < free.j_end) std::fill(to + free.i_begin, to + std::max(free.i_begin, free.i_end), 0.0);
      }
    }
  }

  const ReactionTerm* reaction_;
  ImplicitTerms terms_;
  double tolerance_;
  const Communicator* comm_;
  bool fixed_points_;
  Field jacobian_;  // zero if the reaction is no part
  std::vector<CoarseGrid> grids_;
  std::vector<PlaneLevel<m>> levels_;
  std::size_t n_levels_ = 1;
  std::vector<Plane> basis_;
  std::vector<Plane> solution_;
  std::array<double, m> weights_{};
  std::vector<double> coefficients_;
  std::vector<double> products_;
  Agreement agreement_;
  double k_x_[m];
  double k_y_[m];
  std::int64_t solves_ = 0;
  std::int64_t unfinished_ = 0;
};

}  // namespace

std::unique_ptr<ImplicitPart> make_multigrid_part(const Field& shape, const DiffusionOperator& diffusion, const ReactionTerm& reaction,
                                                  ImplicitTerms terms, double relative_tolerance) {
  if (diffusion.dimension() != 2) throw Error(ErrorKind::input, "method.implicit_solver: \"multigrid\" is for two dimensions");
  return for_species_count<std::unique_ptr<ImplicitPart>>(
      shape.n_species(), [&]<int m>() { return std::make_unique<PlanePart<m>>(shape, diffusion, reaction, terms, relative_tolerance); });
}

}  // namespace stiffront
