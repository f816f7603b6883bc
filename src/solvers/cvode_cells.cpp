// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/solvers/cvode_cells.hpp"

#include <cvode/cvode.h>
#include <fmt/format.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <cmath>
#include <cstdlib>
#include <utility>

#include "stiffront/core/error.hpp"

namespace stiffront {

/// One CVODE, restarted for each cell. Time runs from the beginning of the interval, so that small intervals late in a run keep all
/// their digits.
class CvodeCells::Integrator {
 public:
  Integrator(const ReactionTerm& term, const CellTolerances& tolerances) : term_(term) {
    const auto m = static_cast<sunindextype>(term.n_species());
    if (SUNContext_Create(nullptr, &context_) != 0) throw Error(ErrorKind::bug, "CVODE: SUNContext_Create failed");
    u_ = N_VNew_Serial(m, context_);
    N_Vector absolute = N_VNew_Serial(m, context_);
    for (std::size_t s = 0; s < tolerances.absolute.size(); ++s) N_VGetArrayPointer(absolute)[s] = tolerances.absolute[s];
    for (std::size_t s = 0; s < tolerances.absolute.size(); ++s) state()[s] = 0.0;
    matrix_ = SUNDenseMatrix(m, m, context_);
    linear_ = SUNLinSol_Dense(u_, matrix_, context_);
    memory_ = CVodeCreate(CV_BDF, context_);
    const bool good = memory_ != nullptr && linear_ != nullptr && CVodeInit(memory_, &Integrator::rates, 0.0, u_) == CV_SUCCESS &&
                      CVodeSVtolerances(memory_, tolerances.relative, absolute) == CV_SUCCESS &&
                      CVodeSetUserData(memory_, this) == CV_SUCCESS && CVodeSetMaxNumSteps(memory_, 100000) == CV_SUCCESS &&
                      CVodeSetErrHandlerFn(memory_, &Integrator::ignore_message, nullptr) == CV_SUCCESS &&
                      CVodeSetLinearSolver(memory_, linear_, matrix_) == CV_SUCCESS &&
                      CVodeSetJacFn(memory_, &Integrator::jacobian) == CV_SUCCESS;
    N_VDestroy(absolute);
    if (!good) {
      release();
      throw Error(ErrorKind::bug, "CVODE could not be set up for single cells");
    }
    transposed_.resize(tolerances.absolute.size() * tolerances.absolute.size());
  }
  ~Integrator() { release(); }
  Integrator(const Integrator&) = delete;
  Integrator& operator=(const Integrator&) = delete;

  int n_species() const { return term_.n_species(); }
  double* state() { return N_VGetArrayPointer(u_); }

  /// Advances state(). @return CVODE's flag, negative on failure
  int advance(double t, double dt, double x, double y) {
    t_ = t;
    x_ = x;
    y_ = y;
    CVodeReInit(memory_, 0.0, u_);
    CVodeSetStopTime(memory_, dt);
    double reached = 0.0;
    return CVode(memory_, dt, u_, &reached, CV_NORMAL);
  }

  /// Adds the counts of the last call. @return its cost
  double count(Work& work) const {
    long steps = 0, rhs = 0, newton = 0, jacobians = 0, error_failures = 0, newton_failures = 0;
    CVodeGetNumSteps(memory_, &steps);
    CVodeGetNumRhsEvals(memory_, &rhs);
    CVodeGetNumNonlinSolvIters(memory_, &newton);
    CVodeGetNumJacEvals(memory_, &jacobians);
    CVodeGetNumErrTestFails(memory_, &error_failures);
    CVodeGetNumNonlinSolvConvFails(memory_, &newton_failures);
    work.reaction_steps += steps;
    work.reaction_rejections += error_failures + newton_failures;
    work.reaction_newton_iterations += newton;
    work.reaction_rhs += rhs;
    work.reaction_jacobians += jacobians;
    return static_cast<double>(newton) + attempt_cost * static_cast<double>(steps + error_failures + newton_failures);
  }

  /// Where and why the last call failed.
  void describe(int flag, CellFailure& failure) const {
    double reached = 0.0;
    CVodeGetCurrentTime(memory_, &reached);
    CVodeGetCurrentStep(memory_, &failure.dt);
    failure.t = t_ + reached;
    if (flag == CV_FIRST_RHSFUNC_ERR) {
      failure.reason = "the rates are not finite";
      return;
    }
    char* name = CVodeGetReturnFlagName(flag);
    failure.reason = fmt::format("CVODE stopped with {}", name);
    std::free(name);  // NOLINT: CVODE leaves it to the caller
  }

 private:
  void release() {
    CVodeFree(&memory_);
    if (linear_ != nullptr) SUNLinSolFree(linear_);
    if (matrix_ != nullptr) SUNMatDestroy(matrix_);
    N_VDestroy(u_);
    SUNContext_Free(&context_);
  }

  static bool all_finite(const double* p, std::size_t n) {
    for (std::size_t i = 0; i < n; ++i) {
      if (!std::isfinite(p[i])) return false;
    }
    return true;
  }

  // A positive return value makes CVODE try a shorter step.
  static int rates(double t, N_Vector u, N_Vector du, void* self) {
    const Integrator& s = *static_cast<const Integrator*>(self);
    double* out = N_VGetArrayPointer(du);
    s.term_.rates_at(s.t_ + t, s.x_, s.y_, N_VGetArrayPointer(u), out);
    return all_finite(out, static_cast<std::size_t>(s.n_species())) ? 0 : 1;
  }
  static int jacobian(double t, N_Vector u, N_Vector, SUNMatrix j, void* self, N_Vector, N_Vector, N_Vector) {
    Integrator& s = *static_cast<Integrator*>(self);
    s.term_.jacobian_at(s.t_ + t, s.x_, s.y_, N_VGetArrayPointer(u), s.transposed_.data());
    const auto m = static_cast<std::size_t>(s.n_species());
    for (std::size_t a = 0; a < m; ++a) {
      for (std::size_t b = 0; b < m; ++b) SM_COLUMN_D(j, static_cast<sunindextype>(b))[a] = s.transposed_[a * m + b];
    }
    return all_finite(s.transposed_.data(), m * m) ? 0 : 1;
  }
  static void ignore_message(int, const char*, const char*, char*, void*) {}  // failures are values

  const ReactionTerm& term_;
  SUNContext context_ = nullptr;
  N_Vector u_ = nullptr;
  SUNMatrix matrix_ = nullptr;
  SUNLinearSolver linear_ = nullptr;
  void* memory_ = nullptr;
  std::vector<double> transposed_;  ///< the Jacobian by rows; CVODE stores columns
  double t_ = 0.0;
  double x_ = 0.0;
  double y_ = 0.0;
};

namespace {

const CellTolerances& checked(const CellTolerances& tolerances, int n_species) {
  bool valid = tolerances.relative > 0.0 && tolerances.absolute.size() == static_cast<std::size_t>(n_species);
  for (double a : tolerances.absolute) valid = valid && a > 0.0;
  if (!valid) throw Error(ErrorKind::bug, "CvodeCells needs a positive tolerance for each species");
  return tolerances;
}

}  // namespace

CvodeCells::CvodeCells(const ReactionTerm& term, const CellTolerances& tolerances)
    : integrator_(std::make_unique<Integrator>(term, checked(tolerances, term.n_species()))) {}

CvodeCells::~CvodeCells() = default;

void CvodeCells::begin(const Grid& grid, double t, double dt) {
  grid_ = &grid;
  t_ = t;
  dt_ = dt;
}

void CvodeCells::run(const CellRun& cells) {
  const int m = integrator_->n_species();
  const double y = grid_->dimension == 2 ? grid_->position(1, cells.j) : 0.0;
  for (int k = 0; k < cells.n; ++k) {
    const std::int64_t i = cells.i + k;
    const double x = grid_->position(0, i);
    double* u = integrator_->state();
    for (int s = 0; s < m; ++s) u[s] = cells.from[s * cells.from_stride + k];
    const int flag = integrator_->advance(t_, dt_, x, y);
    cells.cost[k] = static_cast<float>(integrator_->count(work_));
    if (flag >= 0) {
      for (int s = 0; s < m; ++s) cells.to[s * cells.to_stride + k] = u[s];
      continue;
    }
    if (!first_ || cells.j < first_->j || (cells.j == first_->j && i < first_->i)) {
      first_.emplace();
      first_->i = i;
      first_->j = cells.j;
      first_->x = x;
      first_->y = y;
      first_->interval = dt_;
      for (int s = 0; s < m; ++s) first_->state.push_back(cells.from[s * cells.from_stride + k]);
      integrator_->describe(flag, *first_);
    }
    for (int s = 0; s < m; ++s) cells.to[s * cells.to_stride + k] = cells.from[s * cells.from_stride + k];
  }
}

std::optional<CellFailure> CvodeCells::finish(Work& work) {
  work += std::exchange(work_, Work{});
  return std::exchange(first_, std::nullopt);
}

}  // namespace stiffront
