// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/cvode.hpp"

#include <cvode/cvode.h>
#include <fmt/format.h>
#include <sunlinsol/sunlinsol_band.h>
#include <sunlinsol/sunlinsol_spgmr.h>
#include <sunmatrix/sunmatrix_band.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "stiffront/control/state_norm.hpp"
#include "stiffront/core/error.hpp"
#include "stiffront/solvers/sundials_vector.hpp"

namespace stiffront {

/// CVODE and what it calls back. Unknowns are the evolving points, species fastest.
class Cvode::Solver {
 public:
  Solver(const Field& shape, CoupledRhs& rhs, CvodeOptions options)
      : comm_(&shape.comm()),
        rhs_(&rhs),
        options_(std::move(options)),
        free_(rhs.free_box()),
        m_(shape.n_species()),
        u_(shape.similar()),
        du_(shape.similar()),
        direction_(shape.similar()) {
    const Grid& grid = shape.decomposition().grid();
    if (options_.linear_solver == CvodeOptions::LinearSolver::band && (grid.dimension != 1 || grid.periodic[0] || comm_->size() != 1)) {
      throw Error(ErrorKind::input, "method.linear_solver: \"band\" needs one dimension, no periodic boundary and one rank; use \"gmres\"");
    }
    check(SUNContext_Create(nullptr, &context_), "SUNContext_Create");
    const std::int64_t points = static_cast<std::int64_t>(free_.i_end - free_.i_begin) * (free_.j_end - free_.j_begin);
    const std::int64_t all_points = rhs.diffusion().boundary().free_points(grid);
    y_ = make_sundials_vector(*comm_, points * m_, all_points * m_, context_);
    atol_ = N_VClone(y_);
    double* a = N_VGetArrayPointer(atol_);
    for (std::int64_t i = 0; i < points * m_; ++i) a[i] = options_.absolute_tolerance[static_cast<std::size_t>(i % m_)];
    if (options_.linear_solver == CvodeOptions::LinearSolver::band) {
      width_ = rhs.diffusion().reach();
      if (rhs.transport() == nullptr) probe_stencil(shape);
    } else {
      blocks_.resize(static_cast<std::size_t>(points * m_ * m_));
      pivots_.resize(static_cast<std::size_t>(points * m_));
    }
  }

  ~Solver() {
    drop();
    N_VDestroy(atol_);
    N_VDestroy(y_);
    SUNContext_Free(&context_);
  }
  Solver(const Solver&) = delete;
  Solver& operator=(const Solver&) = delete;

  void drop() {
    if (memory_ == nullptr) return;
    CVodeFree(&memory_);
    SUNLinSolFree(linear_);
    if (matrix_ != nullptr) SUNMatDestroy(matrix_);
    memory_ = nullptr;
    matrix_ = nullptr;
  }

  void start(double t, double end, const Field& u) {
    drop();
    end_ = end;
    u_.copy_interior(u);  // Dirichlet points too
    gather(u, y_);
    memory_ = CVodeCreate(CV_BDF, context_);
    check(CVodeInit(memory_, &Solver::evaluate, t, y_), "CVodeInit");
    check(CVodeSVtolerances(memory_, options_.relative_tolerance, atol_), "CVodeSVtolerances");
    check(CVodeSetUserData(memory_, this), "CVodeSetUserData");
    check(CVodeSetMaxNumSteps(memory_, -1), "CVodeSetMaxNumSteps");
    check(CVodeSetErrHandlerFn(memory_, &Solver::remember_message, this), "CVodeSetErrHandlerFn");
    if (options_.linear_solver == CvodeOptions::LinearSolver::band) {
      // Transport couples all species of neighbouring points.
      const bool transport = rhs_->transport() != nullptr;
      const sunindextype half = transport ? m_ * width_ + m_ - 1 : std::max(m_ - 1, m_ * width_);
      matrix_ = SUNBandMatrix(N_VGetLength(y_), half, half, context_);
      linear_ = SUNLinSol_Band(y_, matrix_, context_);
      check(CVodeSetLinearSolver(memory_, linear_, matrix_), "CVodeSetLinearSolver");
      check(CVodeSetJacFn(memory_, transport ? &Solver::differenced_jacobian : &Solver::band_jacobian), "CVodeSetJacFn");
    } else {
      linear_ = SUNLinSol_SPGMR(y_, SUN_PREC_LEFT, 10, context_);
      check(CVodeSetLinearSolver(memory_, linear_, nullptr), "CVodeSetLinearSolver");
      check(CVodeSetPreconditioner(memory_, &Solver::factor_blocks, &Solver::solve_blocks), "CVodeSetPreconditioner");
      if (rhs_->transport() == nullptr) check(CVodeSetJacTimes(memory_, nullptr, &Solver::jacobian_product), "CVodeSetJacTimes");
    }
    counted_ = Work{};
  }

  Attempt step(double t, double dt, Field& u, Field& u_new, std::uint64_t& flags) {
    if (memory_ == nullptr) start(t, end_ > t ? end_ : t + dt, u);
    Attempt a;
    check(CVodeSetStopTime(memory_, t + dt), "CVodeSetStopTime");
    double reached = t;
    const int status = CVode(memory_, t + dt, y_, &reached, CV_ONE_STEP);
    u_new.copy_interior(u);
    scatter(y_, u_new);
    rhs_->diffusion().boundary().impose(u_new, reached);
    Agreement agreement(0, 0);
    agreement.flags = flags | inspect(u_new, free_);
    comm_->agree(agreement);
    flags = agreement.flags;
    // CVODE has tried smaller steps before it gives up: nothing is left to be retried.
    if (status < 0) throw Error(ErrorKind::numerics, fmt::format("CVODE failed at t = {:.17g}: {}", reached, message_));
    if ((flags & step_flags::not_finite) != 0) {
      throw Error(ErrorKind::numerics,
                  fmt::format("the state of CVODE is not finite at t = {:.17g}; check the model and its initial state", reached));
    }
    a.accepted = true;
    a.dt_taken = reached >= t + dt ? dt : reached - t;
    // All the way to the end: the time asked for is where CVODE must stop, not the step it should take.
    a.dt_next = end_ - t - a.dt_taken;
    CVodeGetLastOrder(memory_, &a.iterations);
    a.work = new_work();
    return a;
  }

 private:
  static void check(int status, const char* call) {
    if (status != 0) throw Error(ErrorKind::bug, fmt::format("{} returned {}", call, status));
  }
  static Solver& self(void* data) { return *static_cast<Solver*>(data); }

  static void remember_message(int, const char*, const char*, char* text, void* data) { self(data).message_ = text; }

  Work new_work() {
    Work total;
    long rhs = 0, linear = 0, newton = 0, jacobians = 0;
    CVodeGetNumRhsEvals(memory_, &rhs);
    CVodeGetNumNonlinSolvIters(memory_, &newton);
    CVodeGetNumLinIters(memory_, &linear);
    if (matrix_ != nullptr) CVodeGetNumJacEvals(memory_, &jacobians);
    total.rhs_evaluations = rhs;
    total.linear_iterations = linear;
    total.reaction_newton_iterations = newton;
    total.reaction_jacobians = jacobians;
    total.halo_exchanges = rhs_->evaluations();
    Work since = total;
    since.rhs_evaluations -= counted_.rhs_evaluations;
    since.linear_iterations -= counted_.linear_iterations;
    since.reaction_newton_iterations -= counted_.reaction_newton_iterations;
    since.reaction_jacobians -= counted_.reaction_jacobians;
    since.halo_exchanges -= counted_.halo_exchanges;
    counted_ = total;
    return since;
  }

  template <class F>
  void for_each_point(F f) const {
    std::int64_t k = 0;
    for (int j = free_.j_begin; j < free_.j_end; ++j) {
      for (int i = free_.i_begin; i < free_.i_end; ++i) f(i, j, k++);
    }
  }
  void gather(const Field& u, N_Vector y) const {
    double* p = N_VGetArrayPointer(y);
    for_each_point([&](int i, int j, std::int64_t k) {
      for (int s = 0; s < m_; ++s) p[k * m_ + s] = u.at(s, i, j);
    });
  }
  void scatter(N_Vector y, Field& u) const {
    const double* p = N_VGetArrayPointer(y);
    for_each_point([&](int i, int j, std::int64_t k) {
      for (int s = 0; s < m_; ++s) u.at(s, i, j) = p[k * m_ + s];
    });
  }
  double x_of(int i) const { return u_.decomposition().grid().position(0, u_.decomposition().offset_x() + i); }
  double y_of(int j) const {
    const Decomposition& d = u_.decomposition();
    return d.grid().dimension == 2 ? d.grid().position(1, d.offset_y() + j) : 0.0;
  }

  static int evaluate(realtype t, N_Vector y, N_Vector ydot, void* data) {
    Solver& me = self(data);
    me.scatter(y, me.u_);
    me.rhs_->diffusion().boundary().impose(me.u_, t);
    me.rhs_->evaluate(t, me.u_, me.du_);
    me.gather(me.du_, ydot);
    return 0;
  }

  /// The Laplacian's matrix, found by applying it to combs of unit vectors that do not overlap.
  void probe_stencil(const Field& shape) {
    const DiffusionOperator& diffusion = rhs_->diffusion();
    const int n = free_.i_end - free_.i_begin;
    const int colours = 2 * width_ + 1;
    stencil_.assign(static_cast<std::size_t>(m_ * n * colours), 0.0);
    HaloExchange halo(shape.decomposition(), diffusion.boundary(), m_, 1, diffusion.halo_width());
    Field comb = shape.similar();
    for (int colour = 0; colour < colours; ++colour) {
      for (int s = 0; s < m_; ++s) {
        for (int i = 0; i < shape.n_x(); ++i) comb.at(s, i) = i >= free_.i_begin && i < free_.i_end && i % colours == colour ? 1.0 : 0.0;
      }
      halo.exchange(comb);
      diffusion.apply(comb, du_, free_);
      for (int s = 0; s < m_; ++s) {
        for (int i = free_.i_begin; i < free_.i_end; ++i) {
          for (int offset = -width_; offset <= width_; ++offset) {
            if (i + offset >= 0 && (i + offset) % colours == colour) entry(s, i, offset) = du_.at(s, i);
          }
        }
      }
    }
  }
  double& entry(int s, int i, int offset) {
    const int n = free_.i_end - free_.i_begin;
    return stencil_[static_cast<std::size_t>((s * n + i - free_.i_begin) * (2 * width_ + 1) + offset + width_)];
  }

  static int band_jacobian(realtype t, N_Vector y, N_Vector, SUNMatrix matrix, void* data, N_Vector, N_Vector, N_Vector) {
    Solver& me = self(data);
    const int m = me.m_;
    const double* p = N_VGetArrayPointer(y);
    std::vector<double> jacobian(static_cast<std::size_t>(m * m));
    SUNMatZero(matrix);
    me.for_each_point([&](int i, int j, std::int64_t k) {
      me.rhs_->reaction().jacobian_at(t, me.x_of(i), me.y_of(j), p + k * m, jacobian.data());
      for (int r = 0; r < m; ++r) {
        for (int c = 0; c < m; ++c) SM_ELEMENT_B(matrix, k * m + r, k * m + c) += jacobian[static_cast<std::size_t>(r * m + c)];
        for (int offset = -me.width_; offset <= me.width_; ++offset) {
          if (i + offset < me.free_.i_begin || i + offset >= me.free_.i_end) continue;
          SM_ELEMENT_B(matrix, k * m + r, (k + offset) * m + r) += me.entry(r, i, offset);
        }
      }
    });
    return 0;
  }

  /// By differences of the right-hand side, all columns that do not meet at once.
  static int differenced_jacobian(realtype t, N_Vector y, N_Vector f, SUNMatrix matrix, void* data, N_Vector moved, N_Vector f_moved,
                                  N_Vector) {
    Solver& me = self(data);
    const sunindextype n = N_VGetLength(y);
    const sunindextype half = SM_LBAND_B(matrix);
    const double* p = N_VGetArrayPointer(y);
    const double* before = N_VGetArrayPointer(f);
    double* q = N_VGetArrayPointer(moved);
    const double* after = N_VGetArrayPointer(f_moved);
    std::vector<double> largest(static_cast<std::size_t>(me.m_), 0.0);
    for (sunindextype k = 0; k < n; ++k) {
      double& scale = largest[static_cast<std::size_t>(k % me.m_)];
      scale = std::max(scale, std::abs(p[k]));
    }
    const auto increment = [&](sunindextype k) {
      const double scale = largest[static_cast<std::size_t>(k % me.m_)];
      return 1.5e-8 * (std::max(std::abs(p[k]), 1e-3 * scale) + (scale == 0.0 ? 1.0 : 0.0));
    };
    SUNMatZero(matrix);
    for (sunindextype colour = 0; colour < std::min(n, 2 * half + 1); ++colour) {
      std::copy(p, p + n, q);
      for (sunindextype k = colour; k < n; k += 2 * half + 1) q[k] += increment(k);
      evaluate(t, moved, f_moved, data);
      for (sunindextype k = colour; k < n; k += 2 * half + 1) {
        const double step = q[k] - p[k];
        for (sunindextype row = std::max<sunindextype>(0, k - half); row <= std::min(n - 1, k + half); ++row) {
          SM_ELEMENT_B(matrix, row, k) = (after[row] - before[row]) / step;
        }
      }
    }
    return 0;
  }

  static int jacobian_product(N_Vector v, N_Vector jv, realtype t, N_Vector y, N_Vector, void* data, N_Vector) {
    Solver& me = self(data);
    me.scatter(y, me.u_);
    // Fixed points do not vary: the direction is zero there, and homogeneous in the halo.
    me.scatter(v, me.direction_);
    if (!me.direction_halo_) {
      const DiffusionOperator& diffusion = me.rhs_->diffusion();
      me.direction_halo_ = std::make_unique<HaloExchange>(me.u_.decomposition(), diffusion.boundary(), me.m_, 1, diffusion.halo_width(),
                                                          diffusion.diffusing_species());
    }
    me.direction_halo_->exchange(me.direction_);
    me.rhs_->diffusion().apply(me.direction_, me.du_, me.free_);
    me.rhs_->reaction().add_jacobian_product(t, me.u_, me.direction_, me.du_, me.free_);
    me.gather(me.du_, jv);
    return 0;
  }

  /// LU with row pivoting of every cell's I - gamma (J + diagonal of the Laplacian).
  static int factor_blocks(realtype t, N_Vector y, N_Vector, booleantype, booleantype* current, realtype gamma, void* data) {
    Solver& me = self(data);
    const int m = me.m_;
    const DiffusionOperator& diffusion = me.rhs_->diffusion();
    const double* p = N_VGetArrayPointer(y);
    me.for_each_point([&](int i, int j, std::int64_t k) {
      double* b = &me.blocks_[static_cast<std::size_t>(k * m * m)];
      int* pivot = &me.pivots_[static_cast<std::size_t>(k * m)];
      me.rhs_->reaction().jacobian_at(t, me.x_of(i), me.y_of(j), p + k * m, b);
      for (int r = 0; r < m; ++r) {
        b[r * m + r] -= diffusion.diagonal() * (diffusion.k_x(r) + diffusion.k_y(r));
        for (int c = 0; c < m; ++c) b[r * m + c] = (r == c ? 1.0 : 0.0) - gamma * b[r * m + c];
      }
      for (int c = 0; c < m; ++c) {
        int best = c;
        for (int r = c + 1; r < m; ++r) best = std::abs(b[r * m + c]) > std::abs(b[best * m + c]) ? r : best;
        pivot[c] = best;
        if (best != c) std::swap_ranges(b + c * m, b + c * m + m, b + best * m);
        for (int r = c + 1; r < m; ++r) {
          const double factor = b[r * m + c] /= b[c * m + c];
          for (int q = c + 1; q < m; ++q) b[r * m + q] -= factor * b[c * m + q];
        }
      }
    });
    *current = SUNTRUE;
    return 0;
  }

  static int solve_blocks(realtype, N_Vector, N_Vector, N_Vector r, N_Vector z, realtype, realtype, int, void* data) {
    Solver& me = self(data);
    const int m = me.m_;
    const double* in = N_VGetArrayPointer(r);
    double* out = N_VGetArrayPointer(z);
    me.for_each_point([&](int, int, std::int64_t k) {
      const double* b = &me.blocks_[static_cast<std::size_t>(k * m * m)];
      const int* pivot = &me.pivots_[static_cast<std::size_t>(k * m)];
      double* x = out + k * m;
      std::copy(in + k * m, in + k * m + m, x);
      for (int c = 0; c < m; ++c) {
        std::swap(x[c], x[pivot[c]]);
      }
      for (int c = 0; c < m; ++c) {
        for (int q = c + 1; q < m; ++q) x[q] -= b[q * m + c] * x[c];
      }
      for (int c = m - 1; c >= 0; --c) {
        for (int q = c + 1; q < m; ++q) x[c] -= b[c * m + q] * x[q];
        x[c] /= b[c * m + c];
      }
    });
    return 0;
  }

  const Communicator* comm_;
  CoupledRhs* rhs_;
  CvodeOptions options_;
  FreeBox free_;
  int m_;
  int width_ = 1;
  Field u_;
  Field du_;
  Field direction_;
  std::unique_ptr<HaloExchange> direction_halo_;
  std::vector<double> stencil_;
  std::vector<double> blocks_;
  std::vector<int> pivots_;
  double end_ = 0.0;
  std::string message_;
  Work counted_;
  SUNContext context_ = nullptr;
  N_Vector y_ = nullptr;
  N_Vector atol_ = nullptr;
  SUNMatrix matrix_ = nullptr;
  SUNLinearSolver linear_ = nullptr;
  void* memory_ = nullptr;
};

Cvode::Cvode(const Field& shape, CoupledRhs& rhs, CvodeOptions options)
    : solver_(std::make_unique<Solver>(shape, rhs, std::move(options))) {}
Cvode::~Cvode() = default;

double Cvode::first_step(double t, double t_end, Field& u) {
  solver_->start(t, t_end, u);
  return t_end - t;
}

Attempt Cvode::attempt(double t, double dt, Field& u, Field& u_new, std::uint64_t& flags) { return solver_->step(t, dt, u, u_new, flags); }

void Cvode::restart(double) { solver_->drop(); }

}  // namespace stiffront
