// SPDX-License-Identifier: BSD-3-Clause
// How many arrays of the size of the state a run holds: every one the program makes is counted.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>

#include "stiffront/app/case_file.hpp"
#include "stiffront/app/case_source.hpp"
#include "stiffront/app/method_stack.hpp"
#include "stiffront/app/problem.hpp"
#include "stiffront/control/evolve.hpp"
#include "stiffront/solvers/model_registry.hpp"

namespace {
std::atomic<std::size_t> smallest_counted{0};
std::atomic<int> arrays{0};
}  // namespace

#ifndef __SANITIZE_ADDRESS__  // which has its own
extern "C" void* aligned_alloc(std::size_t alignment, std::size_t size) {
  if (smallest_counted != 0 && size >= smallest_counted) arrays += static_cast<int>((size + smallest_counted / 2) / smallest_counted);
  void* p = nullptr;
  return posix_memalign(&p, alignment, size) == 0 ? p : nullptr;
}
#endif

namespace stiffront::app {
namespace {

struct Holding {
  const char* method;
  int arrays;  ///< the state included
};

class StateArrays : public ::testing::TestWithParam<Holding> {};

TEST_P(StateArrays, AreAsManyAsTheDocumentationSays) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "not under the address sanitizer";
#endif
  ModelRegistry models;
  register_builtin_models(models);
  const Communicator comm(MPI_COMM_SELF);
  const Case c =
      parse_case(read_case_source("bz-2d-spiral", {"grid.points=[96, 96]", GetParam().method, "time.end=5e-3"}), models.descriptions());
  arrays = 0;
  smallest_counted = 3 * 96 * 96 * sizeof(double);
  Problem problem(c, models, comm);
  MethodStack stack(c, problem);
  Schedule schedule;
  schedule.end = c.time.end;
  Observer nobody;
  Progress progress;
  evolve(stack.method(), schedule, problem.state, progress, nobody);
  smallest_counted = 0;
  EXPECT_GT(progress.accepted, 3);
  EXPECT_EQ(arrays, GetParam().arrays);
}

INSTANTIATE_TEST_SUITE_P(Methods, StateArrays,
                         ::testing::Values(Holding{"method={ name = \"strang\", step = 1e-3 }", 6},
                                           Holding{"method={ name = \"lie\", step = 1e-3 }", 5},
                                           Holding{"method={ name = \"adaptive-strang\", tolerance = 1e-3 }", 13},
                                           Holding{"method={ name = \"dcs\", tolerance = 1e-4 }", 15},
                                           Holding{"method={ name = \"sbdf\", relative_tolerance = 1e-3 }", 11},
                                           Holding{"method={ name = \"sdc\", step = 5e-4 }", 44}));

}  // namespace
}  // namespace stiffront::app
