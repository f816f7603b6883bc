// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>

#include "stiffront/io/checkpoint.hpp"
#include "stiffront/mesh/field.hpp"
#include "support/temporary_folder.hpp"

namespace stiffront {
namespace {

namespace fs = std::filesystem;

/// Where a run may be killed, and which checkpoint must then be found: the one of step 20 being written, or that of step 10.
struct Moment {
  const char* fail_point;
  std::int64_t step;
};
void PrintTo(const Moment& m, std::ostream* out) { *out << m.fail_point; }

class CheckpointCrashTest : public ::testing::TestWithParam<Moment> {
 protected:
  CheckpointCrashTest() {
    grid_.points = {31, 1};
    decomposition_.emplace(comm_, grid_, std::array{0, 0}, 2);
    u_.emplace(*decomposition_, 2, 1);
  }
  void write(std::int64_t step) {
    for (int s = 0; s < 2; ++s) {
      for (int i = 0; i < 31; ++i) u_->at(s, i) = static_cast<double>(step) + 0.01 * i + s;
    }
    write_checkpoint(folder_.path(), {step, 0.0, "m", {"a", "b"}, grid_, ""}, *decomposition_, 2, visit());
  }
  VisitState visit() {
    return [this](StateVisitor& v) { v.field("u", *u_); };
  }
  void expect_loads(std::int64_t step) {
    const Checkpoint checkpoint(comm_, folder_.path());
    EXPECT_TRUE(checkpoint.warnings().empty());
    EXPECT_EQ(checkpoint.header().step, step);
    checkpoint.load(*decomposition_, visit());
    EXPECT_EQ(u_->at(1, 30), static_cast<double>(step) + 0.3 + 1.0);
  }

  Communicator comm_{MPI_COMM_SELF};
  testing::TemporaryFolder folder_{comm_};
  Grid grid_;
  std::optional<Decomposition> decomposition_;
  std::optional<Field> u_;
};

INSTANTIATE_TEST_SUITE_P(At, CheckpointCrashTest,
                         ::testing::Values(Moment{"checkpoint.after_shard", 10}, Moment{"checkpoint.before_manifest", 10},
                                           Moment{"checkpoint.before_rename", 10}, Moment{"checkpoint.before_prune", 20}));

TEST_P(CheckpointCrashTest, AKillAtAnyMomentLosesAtMostTheCheckpointBeingWritten) {
  write(10);
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    ::setenv("STIFFRONT_FAILPOINT", GetParam().fail_point, 1);
    write(20);
    _exit(1);  // the fail point did not kill
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL) << status;
  expect_loads(GetParam().step);
  // The run goes on, and nothing is left of the accident.
  write(30);
  expect_loads(30);
  for (const auto& entry : fs::directory_iterator(folder_.path())) EXPECT_NE(entry.path().extension(), ".tmp") << entry.path();
}

}  // namespace
}  // namespace stiffront
