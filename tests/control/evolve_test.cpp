// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/evolve.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "stiffront/core/error.hpp"

namespace stiffront {
namespace {

/// A method that adds dt to the only cell and lets a test decide what becomes of an attempt.
class CountingMethod final : public Method {
 public:
  double first_step(double, double, Field&) override {
    ++first_steps;
    return step;
  }
  Attempt attempt(double t, double dt, Field& u, Field& u_new, std::uint64_t& flags) override {
    seen_flags |= flags;
    u_new.at(0, 0) = u.at(0, 0) + dt;
    Attempt a;
    a.accepted = true;
    a.dt_next = step;
    if (decide) decide(t, dt, a);
    return a;
  }
  void restart(double t) override { restarts.push_back(t); }

  double step = 0.1;
  int first_steps = 0;
  std::uint64_t seen_flags = 0;
  std::vector<double> restarts;
  std::function<void(double, double, Attempt&)> decide;
};

class Recorder final : public Observer {
 public:
  std::uint64_t requests() override { return request; }
  void attempted(const StepRecord& r) override { attempts.push_back(r); }
  void stepped(const StepRecord&, double t_new, Field& u, Field& u_new) override {
    times.push_back(t_new);
    EXPECT_NE(u.at(0, 0), u_new.at(0, 0));
  }
  bool carry_on(std::uint64_t, std::int64_t step, double, double, Field&) override { return stop_after == 0 || step < stop_after; }

  std::uint64_t request = 0;
  std::int64_t stop_after = 0;
  std::vector<StepRecord> attempts;
  std::vector<double> times;
};

class EvolveTest : public ::testing::Test {
 protected:
  EvolveTest() : comm_(MPI_COMM_SELF), decomposition_(comm_, Grid{1, {2, 1}}, {1, 1}, 1), u_(decomposition_, 1, 0) { schedule_.end = 1.0; }

  bool run() { return evolve(method_, schedule_, u_, progress_, recorder_); }

  Communicator comm_;
  Decomposition decomposition_;
  Field u_;
  CountingMethod method_;
  Schedule schedule_;
  Progress progress_;
  Recorder recorder_;
};

TEST_F(EvolveTest, ReachesTheEndExactlyWithoutATinyLastStep) {
  EXPECT_TRUE(run());
  EXPECT_EQ(progress_.t, 1.0);
  EXPECT_EQ(recorder_.times.size(), 10U);
  EXPECT_NEAR(u_.at(0, 0), 1.0, 1e-14);
}

TEST_F(EvolveTest, LandsOnBreakpointsAndRestartsTheMethodThere) {
  schedule_.breakpoints = {0.25, 0.777};
  EXPECT_TRUE(run());
  EXPECT_EQ(method_.restarts, (std::vector<double>{0.25, 0.777}));
  for (double t : {0.25, 0.777, 1.0}) EXPECT_EQ(std::count(recorder_.times.begin(), recorder_.times.end(), t), 1) << t;
  EXPECT_EQ(method_.first_steps, 3);
}

TEST_F(EvolveTest, NoStepSeesTheOtherSideOfAJumpOfTheData) {
  schedule_.breakpoints = {0.25};
  schedule_.restart_period = 0.4;
  schedule_.restart_step = 0.03;
  std::vector<std::pair<double, double>> steps;
  method_.decide = [&](double t, double dt, Attempt&) { steps.emplace_back(t, t + dt); };
  run();
  for (const double jump : {0.25, 0.4, 0.8}) {
    for (const auto& [begin, end] : steps) {
      EXPECT_FALSE(begin <= jump && jump <= end) << jump << " in " << begin << ", " << end;
      EXPECT_FALSE(begin <= jump * (1.0 + 1e-16) && jump * (1.0 - 1e-16) <= end) << jump << " touched by " << begin << ", " << end;
    }
  }
  // What is left out is round-off, and the times of the world are those asked for.
  EXPECT_NEAR(u_.at(0, 0), 1.0, 1e-14);
  for (const double jump : {0.25, 0.4, 0.8}) EXPECT_EQ(std::count(recorder_.times.begin(), recorder_.times.end(), jump), 1) << jump;
}

TEST_F(EvolveTest, ResetsTheTrialStepEveryPeriod) {
  schedule_.restart_period = 0.5;
  schedule_.restart_step = 0.01;
  EXPECT_TRUE(run());
  EXPECT_EQ(std::count(recorder_.times.begin(), recorder_.times.end(), 0.5), 1);
  const auto after = std::find_if(recorder_.attempts.begin(), recorder_.attempts.end(), [](const StepRecord& r) { return r.t == 0.5; });
  ASSERT_NE(after, recorder_.attempts.end());
  EXPECT_EQ(after->dt, 0.01);
}

TEST_F(EvolveTest, ARestartIsNotLostToAnOutputTimeThatDiffersByRoundOff) {
  schedule_.restart_period = 0.1;
  schedule_.restart_step = 0.01;
  schedule_.landing_times = {0.3, 0.6, 0.7};  // 3 * 0.1, 6 * 0.1 and 7 * 0.1 are larger by one unit in the last place
  method_.step = 0.04;
  EXPECT_TRUE(run());
  EXPECT_EQ(method_.restarts.size(), 10U);  // one of them at the end
}

TEST_F(EvolveTest, TakesUpThePlannedStepAgainAfterLandingOnAnOutputTime) {
  schedule_.landing_times = {0.05};
  method_.decide = [](double, double dt, Attempt& a) { a.dt_next = 1.2 * dt; };
  EXPECT_TRUE(run());
  EXPECT_EQ(recorder_.times[0], 0.05);
  EXPECT_DOUBLE_EQ(recorder_.attempts[1].dt, 0.1);
  EXPECT_TRUE(method_.restarts.empty());
}

TEST_F(EvolveTest, RepeatsARejectedAttemptFromTheSameTimeWithASmallerStep) {
  bool rejected = false;
  method_.decide = [&](double t, double dt, Attempt& a) {
    if (t > 0.45 && !rejected) {
      rejected = true;
      a.accepted = false;
      a.dt_next = 0.5 * dt;
    }
  };
  EXPECT_TRUE(run());
  EXPECT_EQ(progress_.rejected, 1);
  const auto bad =
      std::find_if(recorder_.attempts.begin(), recorder_.attempts.end(), [](const StepRecord& r) { return !r.attempt.accepted; });
  ASSERT_NE(bad, recorder_.attempts.end());
  EXPECT_EQ((bad + 1)->t, bad->t);
  EXPECT_EQ((bad + 1)->dt, 0.5 * bad->dt);
  EXPECT_NEAR(u_.at(0, 0), 1.0, 1e-14);
}

TEST_F(EvolveTest, FailsWithTheReasonWhenTheStepUnderflows) {
  method_.decide = [](double, double dt, Attempt& a) {
    a.accepted = false;
    a.dt_next = 0.1 * dt;
    a.reason = "because";
  };
  try {
    run();
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::numerics);
    EXPECT_NE(std::string(e.what()).find("because"), std::string::npos);
  }
}

TEST_F(EvolveTest, FailsWhenAcceptedStepsShrinkUntilTheTimeStandsStill) {
  method_.decide = [](double, double dt, Attempt& a) { a.dt_next = 0.3 * dt; };
  try {
    run();
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::numerics);
    EXPECT_NE(std::string(e.what()).find("underflowed"), std::string::npos) << e.what();
  }
  EXPECT_EQ(progress_.rejected, 0);
}

TEST_F(EvolveTest, TellsTheMethodWhetherNegativeStatesAreRefused) {
  EXPECT_TRUE(run());
  EXPECT_EQ(method_.seen_flags & step_flags::refuse_negative, 0U);
  progress_ = Progress{};
  schedule_.refuses_negative = true;
  EXPECT_TRUE(run());
  EXPECT_NE(method_.seen_flags & step_flags::refuse_negative, 0U);
}

TEST(Refusal, NamesTheWorstThingAndNegativeValuesOnlyWhereTheyAreRefused) {
  using namespace step_flags;
  EXPECT_EQ(refusal(0), nullptr);
  EXPECT_EQ(refusal(negative), nullptr);
  EXPECT_EQ(refusal(refuse_negative), nullptr);
  EXPECT_STREQ(refusal(negative | refuse_negative), "the new state is negative somewhere");
  EXPECT_STREQ(refusal(not_finite | negative), "the new state is not finite");
  EXPECT_STREQ(refusal(cell_failed | not_finite), "a cell could not be integrated");
}

TEST(Refusal, FindsTheValueThatIsToBlameWithItsCellAndSpecies) {
  const Communicator comm(MPI_COMM_SELF);
  Grid grid{2, {7, 5}};
  const Decomposition d(comm, grid, {1, 1}, 1);
  Field before(d, 2, 0);
  Field after(d, 2, 0);
  before.at(0, 3, 2) = 0.5;
  before.at(1, 3, 2) = 0.25;
  after.at(1, 3, 2) = -1e-20;
  const FreeBox box{0, 7, 0, 5};
  using namespace step_flags;
  EXPECT_FALSE(find_refused_value(negative, before, after, box, 1.0, 0.125));
  EXPECT_FALSE(find_refused_value(not_finite, before, after, box, 1.0, 0.125));
  const auto f = find_refused_value(negative | refuse_negative, before, after, box, 1.0, 0.125);
  ASSERT_TRUE(f);
  EXPECT_EQ(f->i, 3);
  EXPECT_EQ(f->j, 2);
  EXPECT_EQ(f->x, grid.position(0, 3));
  EXPECT_EQ(f->y, grid.position(1, 2));
  EXPECT_EQ(f->species, 1);
  EXPECT_EQ(f->begin, 1.0);
  EXPECT_EQ(f->interval, 0.125);
  EXPECT_EQ(f->state, (std::vector<double>{0.5, 0.25}));
  EXPECT_EQ(f->reason, "it becomes -1e-20");
  after.at(0, 6, 0) = std::numeric_limits<double>::quiet_NaN();
  const auto g = find_refused_value(not_finite, before, after, box, 1.0, 0.125);
  ASSERT_TRUE(g);
  EXPECT_EQ(g->i, 6);
  EXPECT_EQ(g->species, 0);
}

TEST_F(EvolveTest, FailsWhenNoFirstStepCanBeChosen) {
  for (const double step : {0.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    method_.step = step;
    Progress progress;
    try {
      evolve(method_, schedule_, u_, progress, recorder_);
      ADD_FAILURE() << step;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::numerics);
      EXPECT_NE(std::string(error.what()).find("not finite"), std::string::npos) << error.what();
    }
  }
}

TEST_F(EvolveTest, FailsWhenTheNumberOfStepsIsLimited) {
  schedule_.max_steps = 4;
  EXPECT_THROW(run(), Error);
  EXPECT_EQ(progress_.accepted, 4);
}

TEST_F(EvolveTest, StopsWhenTheObserverAsksAndGoesOnFromThere) {
  recorder_.stop_after = 3;
  EXPECT_FALSE(run());
  EXPECT_EQ(progress_.accepted, 3);
  recorder_.stop_after = 0;
  EXPECT_TRUE(run());
  EXPECT_EQ(recorder_.times.size(), 10U);
}

TEST_F(EvolveTest, PassesTheObserversRequestsThroughTheAgreement) {
  recorder_.request = step_flags::first_of_driver;
  EXPECT_TRUE(run());
  EXPECT_EQ(method_.seen_flags, step_flags::first_of_driver);
}

TEST_F(EvolveTest, AcceptsThatAMethodGoesLessFarThanAsked) {
  method_.decide = [](double t, double dt, Attempt& a) { a.dt_taken = t == 0.0 ? 0.6 * dt : 0.0; };
  method_.step = 0.5;
  EXPECT_TRUE(run());
  EXPECT_DOUBLE_EQ(recorder_.times[0], 0.3);
  EXPECT_DOUBLE_EQ(recorder_.times[1], 0.8);
  EXPECT_EQ(progress_.t, 1.0);
}

}  // namespace
}  // namespace stiffront
