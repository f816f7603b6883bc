// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/splitting/balance_plan.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <set>

namespace stiffront {
namespace {

/// Work of the ranks after the transfers.
std::vector<std::int64_t> after(std::vector<std::int64_t> work, const std::vector<WorkTransfer>& plan) {
  for (const WorkTransfer& t : plan) {
    work[static_cast<std::size_t>(t.from)] -= t.work;
    work[static_cast<std::size_t>(t.to)] += t.work;
  }
  return work;
}

TEST(BalancePlan, BringsEveryRankNearTheMeanWithFewTransfers) {
  std::mt19937 random(1);
  for (int ranks : {2, 3, 7, 64, 1000}) {
    std::vector<std::int64_t> work;
    for (int r = 0; r < ranks; ++r) work.push_back(random() % 10 == 0 ? 200000 + random() % 100000 : 10000 + random() % 1000);
    work[0] = 300000;
    const std::vector<WorkTransfer> plan = plan_transfers(work);
    const std::vector<std::int64_t> balanced = after(work, plan);
    const double mean = static_cast<double>(std::accumulate(work.begin(), work.end(), std::int64_t{0})) / ranks;
    EXPECT_GT(static_cast<double>(*std::max_element(work.begin(), work.end())), 1.5 * mean);
    EXPECT_LT(static_cast<double>(*std::max_element(balanced.begin(), balanced.end())), 1.011 * mean) << ranks;
    EXPECT_LT(static_cast<int>(plan.size()), ranks);
    std::set<int> senders, receivers;
    for (const WorkTransfer& t : plan) {
      senders.insert(t.from);
      receivers.insert(t.to);
    }
    for (int s : senders) EXPECT_EQ(receivers.count(s), 0U) << "a rank either sends or receives";
  }
}

TEST(BalancePlan, NothingMovesBelowTheThresholdOrForLittleGain) {
  EXPECT_TRUE(plan_transfers(std::vector<std::int64_t>{10100, 10000, 9900}).empty());
  EXPECT_FALSE(plan_transfers(std::vector<std::int64_t>{11000, 10000, 9000}).empty());
  EXPECT_TRUE(plan_transfers(std::vector<std::int64_t>{500, 10, 10}).empty()) << "messages cost more than that";
  EXPECT_TRUE(plan_transfers(std::vector<std::int64_t>{500000}).empty());
  EXPECT_TRUE(plan_transfers(std::vector<std::int64_t>{0, 0, 0}).empty());
  EXPECT_TRUE(plan_transfers({}).empty());
}

TEST(BalancePlan, ChoosesTheMostExpensivePacksThatFit) {
  const std::vector<float> packs{3, 50, 3, 80, 3, 0, 20, 3, 5000, 3};
  const auto chosen = choose_packs(packs, std::vector<std::int64_t>{130, 23, 9});
  ASSERT_EQ(chosen.size(), 3U);
  EXPECT_EQ(chosen[0], (std::vector<std::int32_t>{1, 3}));
  EXPECT_EQ(chosen[1], (std::vector<std::int32_t>{0, 6}));
  EXPECT_EQ(chosen[2], (std::vector<std::int32_t>{2, 4, 7}));
}

TEST(BalancePlan, ChosenPacksAddUpToTheAmountsAndGoOnceOnly) {
  std::mt19937 random(2);
  std::vector<float> packs;
  for (int p = 0; p < 500; ++p) packs.push_back(static_cast<float>(random() % 8 == 0 ? 200 + random() % 2000 : 24 + random() % 4));
  const std::vector<std::int64_t> amounts{20000, 3000, 11000, 250};
  std::set<std::int32_t> seen;
  const auto chosen = choose_packs(packs, amounts);
  for (std::size_t k = 0; k < amounts.size(); ++k) {
    double sum = 0.0;
    for (std::int32_t p : chosen[k]) {
      EXPECT_TRUE(seen.insert(p).second);
      sum += static_cast<double>(packs[static_cast<std::size_t>(p)]);
    }
    EXPECT_NEAR(sum, static_cast<double>(amounts[k]), 24.0) << "no further from it than half the cheapest packs and one";
    EXPECT_TRUE(std::is_sorted(chosen[k].begin(), chosen[k].end()));
  }
}

TEST(BalancePlan, GroupsAreNoLargerThanAllowedAndAsFewAsThatNeeds) {
  for (const std::array<int, 2> processes :
       {std::array{64, 1}, std::array{8, 8}, std::array{100, 1000}, std::array{317, 316}, std::array{1, 1}}) {
    const std::array<int, 2> groups = balance_groups(processes, 1024);
    const int size = (processes[0] + groups[0] - 1) / groups[0] * ((processes[1] + groups[1] - 1) / groups[1]);
    EXPECT_LE(size, 1024);
    EXPECT_GE(size, std::min(processes[0] * processes[1], 800));
  }
}

}  // namespace
}  // namespace stiffront
