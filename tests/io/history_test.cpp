// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/io/history.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "stiffront/core/error.hpp"
#include "support/temporary_folder.hpp"

namespace stiffront {
namespace {

using testing::content_of;

StepRecord record(std::int64_t step, bool accepted) {
  StepRecord r;
  r.step = step;
  r.t = 0.1 * static_cast<double>(step);
  r.dt = 0.1;
  r.attempt.accepted = accepted;
  r.attempt.error = 0.25;
  r.attempt.iterations = 3;
  r.attempt.epsilon = 0.05;
  r.attempt.critical_dt = 2.0;
  r.attempt.work.diffusion_stages = 14;
  r.attempt.work.reaction_steps = 1000;
  return r;
}

class HistoryTest : public ::testing::Test {
 protected:
  std::ptrdiff_t lines() const {
    const std::string text = content_of(path_);
    return std::count(text.begin(), text.end(), '\n');
  }
  Communicator comm_{MPI_COMM_SELF};
  testing::TemporaryFolder folder_{comm_};
  std::string path_ = folder_.file("history.csv");
};

const std::string header = "step,time,dt,error,accepted,iterations,epsilon,critical_dt,diffusion_stages,reaction_steps,wall_seconds\n";

TEST_F(HistoryTest, HasTheColumnsOfTheInterfaceAndOneLinePerAttempt) {
  History history(comm_, path_);
  history.begin();
  EXPECT_EQ(content_of(path_), header);
  history.add(record(0, false), 0.5);
  history.add(record(0, true), 0.25);
  history.flush();
  EXPECT_EQ(content_of(path_), header + "0,0,0.1,0.25,0,3,0.05,2,14,1000,0.5\n0,0,0.1,0.25,1,3,0.05,2,14,1000,0.25\n");
}

TEST_F(HistoryTest, LinesAreKeptBackUntilTheyAreABatch) {
  History history(comm_, path_);
  history.begin();
  for (int n = 0; n < 63; ++n) history.add(record(n, true), 0.0);
  EXPECT_FALSE(history.is_full());
  history.add(record(63, true), 0.0);
  EXPECT_TRUE(history.is_full());
  EXPECT_EQ(lines(), 1);
  history.flush();
  EXPECT_FALSE(history.is_full());
  EXPECT_EQ(lines(), 65);
}

TEST_F(HistoryTest, AContinuedRunDropsWhatCameAfterItsCheckpointAndLinesCutShort) {
  History first(comm_, path_);
  first.begin();
  for (int n = 0; n < 5; ++n) first.add(record(n, true), 0.0);
  first.flush();
  testing::write_content(path_, content_of(path_) + "5,0.5,0.1,0.2");
  History second(comm_, path_);
  second.resume(3);
  EXPECT_EQ(lines(), 4);
  second.add(record(3, true), 0.0);
  second.flush();
  const std::string text = content_of(path_);
  EXPECT_EQ(text.find("\n4,"), std::string::npos);
  EXPECT_NE(text.find("\n3,0.3"), std::string::npos);
  EXPECT_EQ(lines(), 5);
}

TEST_F(HistoryTest, AFileThatCannotBeWrittenIsAnError) {
  History history(comm_, folder_.file("no/such/folder/history.csv"));
  try {
    history.begin();
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::io);
    EXPECT_NE(std::string(e.what()).find("history.csv"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace stiffront
