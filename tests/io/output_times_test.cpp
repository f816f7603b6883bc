// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/io/output_times.hpp"

#include <gtest/gtest.h>

#include <random>

namespace stiffront {
namespace {

OutputTimes listed(std::vector<double> times) {
  OutputTimes o;
  o.times = std::move(times);
  return o;
}

TEST(OutputTimesTest, TimesOutsideTheRunAreIgnored) { EXPECT_EQ(listed({-1.0, 0.0, 0.25, 1.0, 2.0}).inner(), std::vector<double>{0.25}); }

TEST(OutputTimesTest, RegularTimesAndListedTimesMergeAndCoincidingOnesAreOne) {
  OutputTimes o = listed({0.2, 0.3, 0.55});
  o.every = 0.1;
  o.end = 0.65;
  const std::vector<double> t = o.inner();
  ASSERT_EQ(t.size(), 7U);
  for (std::size_t k = 0; k < 5; ++k) EXPECT_NEAR(t[k], 0.1 * static_cast<double>(k + 1), 1e-15);
  EXPECT_EQ(t[5], 0.55);
  EXPECT_NEAR(t[6], 0.6, 1e-15);
}

TEST(OutputTimesTest, TheFinalStateIsAlwaysDueAndOtherStatesOnlyWhenAsked) {
  OutputTimes o;
  EXPECT_TRUE(o.due_at(1.0, 7));
  EXPECT_FALSE(o.due_at(0.5, 7));
  o.steps = 7;
  EXPECT_TRUE(o.due_at(0.5, 14));
  EXPECT_FALSE(o.due_at(0.5, 15));
}

TEST(OutputTimesTest, AStepThatEndsWithinRoundOffOfATimeLandsOnIt) {
  const OutputTimes o = listed({0.3});
  const double almost = 0.1 + 0.2;  // one bit above 0.3
  EXPECT_NE(almost, 0.3);
  EXPECT_TRUE(o.due_at(almost, 1));
  EXPECT_TRUE(o.between(0.1, almost).empty());
  EXPECT_TRUE(o.between(almost, 0.9).empty());
}

TEST(OutputTimesTest, EveryTimeIsMetExactlyOnceHoweverTheRunIsCutIntoSteps) {
  OutputTimes o = listed({0.123, 0.5, 0.777});
  o.start = 0.05;
  o.end = 1.03;
  o.every = 0.07;
  const std::size_t expected = o.inner().size();
  std::mt19937 random(4);
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<double> met;
    double t = o.start;
    for (std::int64_t step = 1; t < o.end; ++step) {
      double t_new = t + std::uniform_real_distribution<double>(1e-6, 0.2)(random);
      if (trial % 3 == 0) {  // now and then a step lands on a time
        const auto ahead = o.between(t, o.end);
        if (!ahead.empty() && step % 2 == 0) t_new = ahead[0];
      }
      if (t_new > o.end) t_new = o.end;
      for (double time : o.between(t, t_new)) met.push_back(time);
      if (o.due_at(t_new, step) && t_new < o.end) met.push_back(t_new);
      t = t_new;
    }
    ASSERT_EQ(met.size(), expected);
    ASSERT_TRUE(std::is_sorted(met.begin(), met.end()));
  }
}

}  // namespace
}  // namespace stiffront
