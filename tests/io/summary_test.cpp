// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/io/summary.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "stiffront/io/memory.hpp"

namespace stiffront {
namespace {

TEST(SummaryTest, HasEveryKeyOfTheInterface) {
  Summary s;
  s.status = "done";
  s.accepted = 12;
  s.rejected = 3;
  s.work.diffusion_stages = 140;
  s.allreduces = 15;
  s.wall_seconds = {{"diffusion", 1.0}, {"reaction", 2.0}, {"quadrature", 0.0}, {"communication", 0.1}, {"output", 0.2}, {"total", 3.5}};
  s.checksum = "00ff";
  const auto j = nlohmann::json::parse(summary_json(s));
  for (const char* key : {"status", "time", "steps", "work", "wall_seconds", "ranks", "imbalance", "negatives", "peak_memory_mib",
                          "version", "git_hash", "checksum"}) {
    EXPECT_TRUE(j.contains(key)) << key;
  }
  for (const char* key :
       {"diffusion_stages", "reaction_steps", "reaction_newton_iterations", "reaction_rhs", "halo_exchanges", "allreduces"}) {
    EXPECT_TRUE(j["work"].contains(key)) << key;
  }
  EXPECT_EQ(j["steps"]["accepted"], 12);
  EXPECT_EQ(j["steps"]["rejected"], 3);
  EXPECT_EQ(j["work"]["diffusion_stages"], 140);
  EXPECT_EQ(j["wall_seconds"]["total"], 3.5);
  EXPECT_EQ(j["checksum"], "00ff");
  EXPECT_FALSE(j.contains("reason"));
}

TEST(SummaryTest, NumbersThatAreNotFiniteAreWordsAndNoNulls) {
  Summary s;
  s.time = std::numeric_limits<double>::quiet_NaN();
  s.imbalance = -std::numeric_limits<double>::infinity();
  const std::string text = summary_json(s);
  const auto j = nlohmann::json::parse(text);
  EXPECT_EQ(j["time"], "nan");
  EXPECT_EQ(j["imbalance"], "-inf");
  EXPECT_EQ(text.find("null"), std::string::npos);
}

TEST(SummaryTest, AMessageWithStrayBytesIsStillJson) {
  Summary s;
  s.reason = "bad byte \xff in the case file";
  EXPECT_TRUE(nlohmann::json::accept(summary_json(s)));
}

TEST(MemoryTest, PeakMemoryGrowsByWhatIsTouched) {
  const double before = peak_memory_mib();
  std::vector<char> block(static_cast<std::size_t>(before + 64.0) << 20, 1);
  EXPECT_GT(peak_memory_mib(), before + 32.0) << static_cast<int>(block.back());
  EXPECT_GT(available_memory_mib(), 1.0);
}

}  // namespace
}  // namespace stiffront
