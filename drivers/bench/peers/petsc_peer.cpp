// SPDX-License-Identifier: BSD-3-Clause
// PETSc's TS: variable-step BDF of order 5, coupled, the Jacobian assembled in blocks. In one dimension LU, in two GMRES with point
// block Jacobi.
#include <petscts.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>

#include "peer_problem.hpp"
#include "stiffront/core/floating_point.hpp"

namespace {

struct Context {
  peers::Setup setup;
  std::unique_ptr<peers::Problem> problem;
};

PetscErrorCode right_hand_side(TS, PetscReal t, Vec y, Vec f, void* data) {
  const PetscScalar* u = nullptr;
  PetscScalar* r = nullptr;
  VecGetArrayRead(y, &u);
  VecGetArray(f, &r);
  static_cast<Context*>(data)->problem->interleaved_right_hand_side(t, u, r);
  VecRestoreArray(f, &r);
  VecRestoreArrayRead(y, &u);
  return 0;
}

PetscErrorCode jacobian(TS, PetscReal t, Vec y, Mat, Mat matrix, void* data) {
  const Context& c = *static_cast<Context*>(data);
  const peers::Problem& p = *c.problem;
  const int m = p.n_species(), n_x = c.setup.n_x, n_y = c.setup.n_y;
  const PetscScalar* u = nullptr;
  VecGetArrayRead(y, &u);
  std::vector<double> block(static_cast<std::size_t>(m * m));
  std::vector<double> off(static_cast<std::size_t>(m * m));
  for (PetscInt k = 0; k < p.points(); ++k) {
    p.point_jacobian(t, k, u + static_cast<std::ptrdiff_t>(k) * m, block.data());
    for (int s = 0; s < m; ++s) block[static_cast<std::size_t>(s * m + s)] -= 2.0 * (p.k_x(s) + p.k_y(s));
    MatSetValuesBlocked(matrix, 1, &k, 1, &k, block.data(), ADD_VALUES);
    const auto couple = [&](PetscInt other, bool along_x) {
      for (int s = 0; s < m; ++s) off[static_cast<std::size_t>(s * m + s)] = along_x ? p.k_x(s) : p.k_y(s);
      MatSetValuesBlocked(matrix, 1, &k, 1, &other, off.data(), ADD_VALUES);  // a mirrored neighbour is added twice
    };
    const int i = k % n_x, j = k / n_x;
    couple(i > 0 ? k - 1 : (c.setup.periodic_x ? k + n_x - 1 : k + 1), true);
    couple(i < n_x - 1 ? k + 1 : (c.setup.periodic_x ? k - n_x + 1 : k - 1), true);
    if (n_y == 1) continue;
    couple(j > 0 ? k - n_x : (c.setup.periodic_y ? k + n_x * (n_y - 1) : k + n_x), false);
    couple(j < n_y - 1 ? k + n_x : (c.setup.periodic_y ? k - n_x * (n_y - 1) : k - n_x), false);
  }
  VecRestoreArrayRead(y, &u);
  MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY);
  MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY);
  return 0;
}

PetscErrorCode fresh_jacobian(TS ts, PetscReal t, Vec y, Mat a, Mat matrix, void* data) {
  MatZeroEntries(matrix);
  return jacobian(ts, t, y, a, matrix, data);
}

int run(const peers::Setup& setup) {
  Context c;
  c.setup = setup;
  c.problem = peers::make_problem(setup);
  const int m = c.problem->n_species(), n = setup.points();
  const PetscInt size = static_cast<PetscInt>(m) * n;
  const std::vector<double> initial = setup.read_initial(m);
  Vec y;
  VecCreateSeq(PETSC_COMM_SELF, size, &y);
  VecSetBlockSize(y, m);
  PetscScalar* u = nullptr;
  VecGetArray(y, &u);
  peers::interleave(m, n, initial.data(), u);
  VecRestoreArray(y, &u);
  Mat matrix;
  MatCreateSeqBAIJ(PETSC_COMM_SELF, m, size, size, setup.n_y > 1 ? 5 : 3, nullptr, &matrix);
  TS ts;
  TSCreate(PETSC_COMM_SELF, &ts);
  TSSetProblemType(ts, TS_NONLINEAR);
  TSSetType(ts, TSBDF);
  TSBDFSetOrder(ts, 5);
  TSSetRHSFunction(ts, nullptr, right_hand_side, &c);
  TSSetRHSJacobian(ts, matrix, matrix, fresh_jacobian, &c);
  TSSetTolerances(ts, setup.absolute_tolerance, nullptr, setup.relative_tolerance, nullptr);
  TSSetTime(ts, setup.start);
  TSSetMaxTime(ts, setup.end);
  TSSetMaxSteps(ts, 100000000);
  TSSetTimeStep(ts, 1e-6 * (setup.end - setup.start));
  TSSetExactFinalTime(ts, TS_EXACTFINALTIME_MATCHSTEP);
  TSSetMaxSNESFailures(ts, -1);
  TSSetFromOptions(ts);
  const auto began = std::chrono::steady_clock::now();
  const PetscErrorCode status = TSSolve(ts, y);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  PetscInt steps = 0, rejected = 0, newton = 0, iterations = 0;
  TSGetStepNumber(ts, &steps);
  TSGetStepRejections(ts, &rejected);
  TSGetSNESIterations(ts, &newton);
  TSGetKSPIterations(ts, &iterations);
  TSConvergedReason reason = TS_CONVERGED_ITERATING;
  TSGetConvergedReason(ts, &reason);
  std::vector<double> planar(initial.size());
  VecGetArray(y, &u);
  peers::separate(m, n, u, planar.data());
  VecRestoreArray(y, &u);
  if (!setup.final.empty()) setup.write_final(planar.data(), m);
  const int failed = status != 0 || reason < 0;
  std::printf("{\"status\": %d, \"seconds\": %.6f, \"steps\": %d, \"rejected\": %d, \"rhs\": 0, \"newton\": %d, \"linear\": %d}\n", -failed,
              seconds, static_cast<int>(steps), static_cast<int>(rejected), static_cast<int>(newton), static_cast<int>(iterations));
  TSDestroy(&ts);
  MatDestroy(&matrix);
  VecDestroy(&y);
  return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const peers::Setup setup = peers::Setup::parse(argc, argv);
    std::vector<std::string> options{argv[0], "-ts_adapt_type", "basic"};
    if (setup.n_y > 1) {
      options.insert(options.end(), {"-ksp_type", "gmres", "-pc_type", "pbjacobi"});
    } else {
      options.insert(options.end(), {"-ksp_type", "preonly", "-pc_type", "lu"});
    }
    std::vector<char*> words;
    for (std::string& o : options) words.push_back(o.data());
    words.push_back(nullptr);
    int count = static_cast<int>(options.size());
    char** list = words.data();
    PetscInitialize(&count, &list, nullptr, nullptr);
    stiffront::flush_denormals_to_zero();  // the same advantage
    const int status = run(setup);
    PetscFinalize();
    return status;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "petsc_peer: %s\n", e.what());
    return EXIT_FAILURE;
  }
}
