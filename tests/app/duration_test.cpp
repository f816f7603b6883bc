// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/app/duration.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace stiffront::app {
namespace {

TEST(Duration, UnitsAddUp) {
  EXPECT_EQ(parse_duration("0s"), 0.0);
  EXPECT_EQ(parse_duration("90s"), 90.0);
  EXPECT_EQ(parse_duration("3h50m"), 13800.0);
  EXPECT_EQ(parse_duration("1d2h3m4s"), 93784.0);
  EXPECT_EQ(parse_duration("1.5h"), 5400.0);
  EXPECT_EQ(parse_duration("0.25s"), 0.25);
}

TEST(Duration, AnythingElseIsRefused) {
  for (const char* text : {"",    "s",    "90", "3h50", "50m3h", "1h1h", "3 h",  " 3h", "3h ",   "-3h",
                           "+3h", "1e3s", "3H", ".s",   "1..5h", "nans", "infs", "3ms", "0x10s", "1,5h"}) {
    EXPECT_EQ(parse_duration(text), std::nullopt) << text;
  }
  EXPECT_EQ(parse_duration(std::string(400, '9') + "s"), std::nullopt);
}

TEST(Duration, TextIsShort) {
  EXPECT_EQ(format_duration(0.0), "0s");
  EXPECT_EQ(format_duration(90.0), "1m30s");
  EXPECT_EQ(format_duration(13800.0), "3h50m");
  EXPECT_EQ(format_duration(86400.0), "1d");
  EXPECT_EQ(format_duration(0.1), "0.1s");
}

TEST(Duration, TextReadsBackAsTheSameBits) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> exponent(-30.0, 60.0);
  for (int i = 0; i < 200; ++i) {
    const double seconds = std::exp2(exponent(random));
    EXPECT_EQ(parse_duration(format_duration(seconds)), seconds);
    EXPECT_EQ(parse_duration(format_duration(std::floor(seconds))), std::floor(seconds));
  }
  EXPECT_EQ(parse_duration(format_duration(std::numeric_limits<double>::max())), std::numeric_limits<double>::max());
}

}  // namespace
}  // namespace stiffront::app
