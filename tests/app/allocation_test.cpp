// SPDX-License-Identifier: BSD-3-Clause
// Once under way, the steps of a run take no memory from the system: every allocation of this program is counted.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "stiffront/app/builtin_cases.hpp"
#include "stiffront/app/case_file.hpp"
#include "stiffront/app/case_source.hpp"
#include "stiffront/app/method_stack.hpp"
#include "stiffront/app/problem.hpp"
#include "stiffront/control/evolve.hpp"
#include "stiffront/solvers/model_registry.hpp"

namespace {
std::atomic<std::int64_t> allocations{0};

void* counted(std::size_t size) {
  allocations.fetch_add(1, std::memory_order_relaxed);
  if (void* p = std::malloc(size == 0 ? 1 : size)) return p;
  throw std::bad_alloc();
}
}  // namespace

#ifndef __SANITIZE_ADDRESS__  // which counts in its own way and wants its own operators
void* operator new(std::size_t size) { return counted(size); }
void* operator new[](std::size_t size) { return counted(size); }
void operator delete(void* p) noexcept { std::free(p); }
void operator delete[](void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }
void operator delete[](void* p, std::size_t) noexcept { std::free(p); }
#endif

namespace stiffront::app {
namespace {

/// Counts from the end of one attempt to the end of the next. A rejected one may say why in a sentence.
class Counting final : public Observer {
 public:
  void attempted(const StepRecord& record) override {
    const std::int64_t now = allocations.load(std::memory_order_relaxed);
    if (attempts_ > warm_up && record.attempt.accepted) most = std::max(most, now - before_);
    ++attempts_;
    before_ = allocations.load(std::memory_order_relaxed);
  }
  std::int64_t counted_attempts() const { return attempts_ - warm_up; }
  std::int64_t most = 0;

 private:
  static constexpr std::int64_t warm_up = 1;  // what evolve() sets up
  std::int64_t attempts_ = 0;
  std::int64_t before_ = 0;
};

struct Run {
  const char* name;
  std::vector<std::string> overrides;
};

class Allocation : public ::testing::TestWithParam<Run> {};

TEST_P(Allocation, NoneIsMadeInTheStepsOfARunUnderWay) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "not under the address sanitizer";
#endif
  ModelRegistry models;
  register_builtin_models(models);
  const Communicator comm(MPI_COMM_SELF);
  std::vector<std::string> overrides = GetParam().overrides;
  overrides.insert(overrides.begin(), {"grid.points=[201]", "initial.profile=bz-front"});
  const Case c = parse_case(read_case_source("bz-1d", overrides), models.descriptions());
  Problem problem(c, models, comm);
  MethodStack stack(c, problem);
  Schedule schedule;
  schedule.end = c.time.end;
  // Lists grow to the size the run needs; the second time it has to make do with it.
  Field initial = problem.state.similar();
  initial.copy_interior(problem.state);
  Observer nobody;
  Progress first;
  evolve(stack.method(), schedule, problem.state, first, nobody);
  problem.state.copy_interior(initial);
  stack.method().restart(schedule.start);
  Counting counting;
  Progress second;
  evolve(stack.method(), schedule, problem.state, second, counting);
  EXPECT_GT(counting.counted_attempts(), 20);
  EXPECT_EQ(counting.most, 0);
}

INSTANTIATE_TEST_SUITE_P(Methods, Allocation,
                         ::testing::Values(Run{"sbdf", {"method={ name = \"sbdf\" }", "time.end=0.05"}},
                                           Run{"strang", {"method={ name = \"strang\", step = 1e-3 }", "time.end=0.06"}},
                                           Run{"adaptive_strang",
                                               {"method={ name = \"adaptive-strang\", tolerance = 1e-4 }", "time.end=0.02"}},
                                           Run{"dcs", {"method={ name = \"dcs\", tolerance = 1e-5 }", "time.end=0.02"}}),
                         [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace stiffront::app
