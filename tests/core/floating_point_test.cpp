// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/core/floating_point.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <thread>

namespace stiffront {
namespace {

TEST(FloatingPoint, DenormalsBecomeZeroInTheThreadThatAsksForIt) {
#if !defined(__SSE2__) && !defined(__aarch64__)
  GTEST_SKIP() << "nothing is promised on this processor";
#endif
  const auto half_of_smallest = [] {
    volatile double smallest = std::numeric_limits<double>::min();
    return smallest * 0.5;
  };
  const auto twice_a_denormal = [] {
    volatile double denormal = std::numeric_limits<double>::denorm_min();
    return denormal * 2.0;
  };
  EXPECT_GT(half_of_smallest(), 0.0);
  double flushed_result = 1.0;
  double flushed_operand = 1.0;
  std::thread([&] {  // leaves the setting of the thread of the tests alone
    flush_denormals_to_zero();
    flushed_result = half_of_smallest();
    flushed_operand = twice_a_denormal();
  })
      .join();
  EXPECT_EQ(flushed_result, 0.0);
  EXPECT_EQ(flushed_operand, 0.0);
  EXPECT_GT(half_of_smallest(), 0.0);
}

}  // namespace
}  // namespace stiffront
