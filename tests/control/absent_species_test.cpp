// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/absent_species.hpp"

#include <gtest/gtest.h>

#include "stiffront/control/adaptive_strang.hpp"
#include "stiffront/control/evolve.hpp"
#include "stiffront/model/builtin/slaved_oscillator.hpp"
#include "stiffront/solvers/model_kernels.hpp"
#include "stiffront/solvers/rock4.hpp"
#include "support/diffusion_problem.hpp"

namespace stiffront {
namespace {

/// u and v are there from the beginning, z begins at 0 and grows with the splitting's own errors.
struct FrontWithAbsentSpecies {
  FrontWithAbsentSpecies()
      : comm(MPI_COMM_SELF),
        problem(comm, Grid{1, {101, 1}, {0.0, 0.0}, {20.0, 1.0}}, {}, {0.1, 0.0, 0.0}, 2),
        model({}),
        reaction(problem.decomposition, problem.boundary, model.make_radau5({1e-8, {1e-10, 1e-10, 1e-10}})),
        diffusion(problem.decomposition, problem.diffusion, Rock4Tolerances{1e-8, {1e-10, 1e-10, 1e-10}}),
        u(problem.field()) {
    model.initialise("slaved-oscillator-front", u);
  }

  Communicator comm;
  testing::DiffusionProblem problem;
  ModelKernelsOf<SlavedOscillator> model;
  ReactionFlow reaction;
  Rock4 diffusion;
  Field u;
};

TEST(AbsentSpecies, OnlyASpeciesThatIsNotThereGetsAFloorOfItsOwnSize) {
  FrontWithAbsentSpecies p;
  Work work;
  std::vector<double> floors = floors_of_absent_species({&p.reaction, &p.diffusion}, 0.0, 3.0, 1e-3, p.u, p.comm, work);
  ASSERT_EQ(floors.size(), 3U);
  EXPECT_EQ(floors[0], 0.0);
  EXPECT_EQ(floors[1], 0.0);
  EXPECT_GT(floors[2], 0.0);
  EXPECT_LT(floors[2], 1e-2) << "a hundredth of what z becomes, which stays far below u";

  for (int i = 0; i < p.u.n_x(); ++i) p.u.at(2, i) = 1e-3;
  work = {};
  floors = floors_of_absent_species({&p.reaction, &p.diffusion}, 0.0, 3.0, 1e-3, p.u, p.comm, work);
  EXPECT_EQ(floors, std::vector<double>(3, 0.0));
  EXPECT_EQ(work.reaction_steps, 0) << "nothing is done where all species are there";
}

TEST(AbsentSpecies, AdaptiveStrangStartsWithASpeciesAtZero) {
  FrontWithAbsentSpecies p;
  AdaptiveStrangOptions options;
  options.tolerance = 1e-4;
  AdaptiveStrang method(p.u, p.problem.boundary, p.model, p.reaction, p.diffusion, options);
  Schedule schedule;
  schedule.end = 0.05;
  schedule.max_steps = 2000;
  Progress progress;
  Observer nobody;
  EXPECT_TRUE(evolve(method, schedule, p.u, progress, nobody));
  EXPECT_EQ(progress.t, 0.05);
}

}  // namespace
}  // namespace stiffront
