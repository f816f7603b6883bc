// SPDX-License-Identifier: BSD-3-Clause
// ARKODE, additive Runge-Kutta: diffusion explicit, reaction implicit with a direct solve at every point. order=3, 4 or 5.
#include <arkode/arkode_arkstep.h>
#include <nvector/nvector_serial.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>

#include "peer_problem.hpp"
#include "stiffront/core/floating_point.hpp"

namespace {

struct Context {
  std::unique_ptr<peers::Problem> problem;
  void* arkode = nullptr;
};
Context& context(void* data) { return *static_cast<Context*>(data); }

int diffusion(realtype, N_Vector y, N_Vector f, void* data) {
  N_VConst(0.0, f);
  context(data).problem->add_diffusion(N_VGetArrayPointer(y), N_VGetArrayPointer(f));
  return 0;
}
int reaction(realtype t, N_Vector y, N_Vector f, void* data) {
  context(data).problem->reaction(t, N_VGetArrayPointer(y), N_VGetArrayPointer(f));
  return 0;
}

SUNLinearSolver_Type embedded(SUNLinearSolver) { return SUNLINEARSOLVER_MATRIX_EMBEDDED; }
int solve(SUNLinearSolver solver, SUNMatrix, N_Vector x, N_Vector b, realtype) {
  Context& c = context(solver->content);
  N_Vector predicted, state, rates, data;
  realtype t, gamma;
  void* user;
  const int status = ARKStepGetNonlinearSystemData(c.arkode, &t, &predicted, &state, &rates, &gamma, &data, &user);
  if (status != 0) return status;
  c.problem->solve_reaction(t, N_VGetArrayPointer(state), gamma, N_VGetArrayPointer(b), N_VGetArrayPointer(x));
  return 0;
}
int release(SUNLinearSolver solver) {
  SUNLinSolFreeEmpty(solver);
  return 0;
}

int run(const peers::Setup& setup) {
  Context c;
  c.problem = peers::make_problem(setup);
  const int m = c.problem->n_species();
  const std::vector<double> initial = setup.read_initial(m);
  const auto order = setup.other.find("order");

  SUNContext sun = nullptr;
  SUNContext_Create(nullptr, &sun);
  N_Vector y = N_VNew_Serial(static_cast<sunindextype>(initial.size()), sun);
  std::copy(initial.begin(), initial.end(), N_VGetArrayPointer(y));
  c.arkode = ARKStepCreate(diffusion, reaction, setup.start, y, sun);
  ARKStepSStolerances(c.arkode, setup.relative_tolerance, setup.absolute_tolerance);
  ARKStepSetUserData(c.arkode, &c);
  ARKStepSetOrder(c.arkode, order == setup.other.end() ? 4 : std::stoi(order->second));
  ARKStepSetMaxNumSteps(c.arkode, -1);
  ARKStepSetDeduceImplicitRhs(c.arkode, SUNTRUE);
  SUNLinearSolver linear = SUNLinSolNewEmpty(sun);
  linear->content = &c;
  linear->ops->gettype = embedded;
  linear->ops->solve = solve;
  linear->ops->free = release;
  ARKStepSetLinearSolver(c.arkode, linear, nullptr);
  ARKStepSetStopTime(c.arkode, setup.end);
  const auto began = std::chrono::steady_clock::now();
  double t = setup.start;
  const int status = ARKStepEvolve(c.arkode, setup.end, y, &t, ARK_NORMAL);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();

  long steps = 0, failures = 0, explicit_evaluations = 0, implicit_evaluations = 0, newton = 0;
  ARKStepGetNumSteps(c.arkode, &steps);
  ARKStepGetNumErrTestFails(c.arkode, &failures);
  ARKStepGetNumRhsEvals(c.arkode, &explicit_evaluations, &implicit_evaluations);
  ARKStepGetNumNonlinSolvIters(c.arkode, &newton);
  if (!setup.final.empty()) setup.write_final(N_VGetArrayPointer(y), m);
  std::printf("{\"status\": %d, \"seconds\": %.6f, \"steps\": %ld, \"rejected\": %ld, \"rhs\": %ld, \"newton\": %ld, \"linear\": 0}\n",
              status, seconds, steps, failures, implicit_evaluations, newton);
  ARKStepFree(&c.arkode);
  SUNLinSolFree(linear);
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
    std::fprintf(stderr, "arkode_peer: %s\n", e.what());
    return EXIT_FAILURE;
  }
}
