// SPDX-License-Identifier: BSD-3-Clause
// CVODE, variable-order BDF with Newton iterations, as one would use it by hand: coupled, all on one core. linear_solver=gmres: GMRES,
// preconditioned from the left by the inverted diagonal blocks of the points, Jacobian products exact; band: LU, Jacobian exact.
#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_band.h>
#include <sunlinsol/sunlinsol_spgmr.h>
#include <sunmatrix/sunmatrix_band.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>

#include "peer_problem.hpp"
#include "stiffront/core/floating_point.hpp"

namespace {

struct Context {
  std::unique_ptr<peers::Problem> problem;
  std::vector<double> blocks;
  std::vector<double> jacobian;
};
Context& context(void* data) { return *static_cast<Context*>(data); }

int planar_rhs(realtype t, N_Vector y, N_Vector f, void* data) {
  context(data).problem->right_hand_side(t, N_VGetArrayPointer(y), N_VGetArrayPointer(f));
  return 0;
}
int interleaved_rhs(realtype t, N_Vector y, N_Vector f, void* data) {
  context(data).problem->interleaved_right_hand_side(t, N_VGetArrayPointer(y), N_VGetArrayPointer(f));
  return 0;
}
int jacobian_product(N_Vector v, N_Vector jv, realtype t, N_Vector y, N_Vector, void* data, N_Vector) {
  context(data).problem->jacobian_product(t, N_VGetArrayPointer(y), N_VGetArrayPointer(v), N_VGetArrayPointer(jv));
  return 0;
}
int invert_blocks(realtype t, N_Vector y, N_Vector, booleantype, booleantype* current, realtype gamma, void* data) {
  Context& c = context(data);
  c.problem->invert_blocks(t, N_VGetArrayPointer(y), gamma, true, c.blocks.data());
  *current = SUNTRUE;
  return 0;
}
int apply_blocks(realtype, N_Vector, N_Vector, N_Vector r, N_Vector z, realtype, realtype, int, void* data) {
  Context& c = context(data);
  c.problem->apply_blocks(c.blocks.data(), N_VGetArrayPointer(r), N_VGetArrayPointer(z));
  return 0;
}
int band_jacobian(realtype t, N_Vector y, N_Vector, SUNMatrix matrix, void* data, N_Vector, N_Vector, N_Vector) {
  Context& c = context(data);
  const int m = c.problem->n_species(), n = c.problem->points();
  const double* u = N_VGetArrayPointer(y);
  for (int i = 0; i < n; ++i) {
    c.problem->point_jacobian(t, i, u + static_cast<std::ptrdiff_t>(i) * m, c.jacobian.data());
    for (int s = 0; s < m; ++s) {
      const double k = c.problem->k_x(s);
      for (int r = 0; r < m; ++r) SM_ELEMENT_B(matrix, m * i + r, m * i + s) = c.jacobian[static_cast<std::size_t>(r * m + s)];
      SM_ELEMENT_B(matrix, m * i + s, m * i + s) -= 2.0 * k;
      if (i > 0) SM_ELEMENT_B(matrix, m * i + s, m * (i - 1) + s) = i == n - 1 ? 2.0 * k : k;
      if (i < n - 1) SM_ELEMENT_B(matrix, m * i + s, m * (i + 1) + s) = i == 0 ? 2.0 * k : k;
    }
  }
  return 0;
}

int run(const peers::Setup& setup) {
  Context c;
  c.problem = peers::make_problem(setup);
  const int m = c.problem->n_species(), n = setup.points();
  c.jacobian.resize(static_cast<std::size_t>(m * m));
  const auto choice = setup.other.find("linear_solver");
  const bool band = choice != setup.other.end() && choice->second == "band";
  if (band && (setup.n_y > 1 || setup.periodic_x)) throw std::runtime_error("band: one dimension without periodic boundary");
  const std::vector<double> initial = setup.read_initial(m);

  SUNContext sun = nullptr;
  SUNContext_Create(nullptr, &sun);
  N_Vector y = N_VNew_Serial(static_cast<sunindextype>(initial.size()), sun);
  double* u = N_VGetArrayPointer(y);
  if (band) {
    peers::interleave(m, n, initial.data(), u);
  } else {
    std::copy(initial.begin(), initial.end(), u);
  }
  void* memory = CVodeCreate(CV_BDF, sun);
  CVodeInit(memory, band ? interleaved_rhs : planar_rhs, setup.start, y);
  CVodeSStolerances(memory, setup.relative_tolerance, setup.absolute_tolerance);
  CVodeSetUserData(memory, &c);
  CVodeSetMaxNumSteps(memory, -1);
  SUNMatrix matrix = nullptr;
  SUNLinearSolver linear = nullptr;
  if (band) {
    matrix = SUNBandMatrix(static_cast<sunindextype>(initial.size()), m, m, sun);
    linear = SUNLinSol_Band(y, matrix, sun);
    CVodeSetLinearSolver(memory, linear, matrix);
    CVodeSetJacFn(memory, band_jacobian);
  } else {
    c.blocks.resize(c.problem->size_of_blocks());
    linear = SUNLinSol_SPGMR(y, SUN_PREC_LEFT, 10, sun);
    CVodeSetLinearSolver(memory, linear, nullptr);
    CVodeSetPreconditioner(memory, invert_blocks, apply_blocks);
    CVodeSetJacTimes(memory, nullptr, jacobian_product);
  }
  CVodeSetStopTime(memory, setup.end);
  const auto began = std::chrono::steady_clock::now();
  double t = setup.start;
  const int status = CVode(memory, setup.end, y, &t, CV_NORMAL);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();

  long steps = 0, failures = 0, evaluations = 0, newton = 0, iterations = 0;
  CVodeGetNumSteps(memory, &steps);
  CVodeGetNumErrTestFails(memory, &failures);
  CVodeGetNumRhsEvals(memory, &evaluations);
  CVodeGetNumNonlinSolvIters(memory, &newton);
  if (!band) CVodeGetNumLinIters(memory, &iterations);
  std::vector<double> planar(initial.size());
  if (band) {
    peers::separate(m, n, u, planar.data());
  } else {
    std::copy(u, u + planar.size(), planar.begin());
  }
  if (!setup.final.empty()) setup.write_final(planar.data(), m);
  std::printf("{\"status\": %d, \"seconds\": %.6f, \"steps\": %ld, \"rejected\": %ld, \"rhs\": %ld, \"newton\": %ld, \"linear\": %ld}\n",
              status, seconds, steps, failures, evaluations, newton, iterations);
  CVodeFree(&memory);
  SUNLinSolFree(linear);
  if (matrix != nullptr) SUNMatDestroy(matrix);
  N_VDestroy(y);
  SUNContext_Free(&sun);
  return status < 0 ? EXIT_FAILURE : EXIT_SUCCESS;
}

}  // namespace

int main(int argc, char** argv) {
  stiffront::flush_denormals_to_zero();  // the same advantage
  try {
    return run(peers::Setup::parse(argc, argv));
  } catch (const std::exception& e) {
    std::fprintf(stderr, "cvode_peer: %s\n", e.what());
    return EXIT_FAILURE;
  }
}
