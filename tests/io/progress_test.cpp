// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/io/progress.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <string>

namespace stiffront {
namespace {

StepRecord record(std::int64_t step) {
  StepRecord r;
  r.step = step;
  r.dt = 0.1;
  r.attempt.accepted = true;
  r.attempt.error = 4.2e-3;
  return r;
}

/// What a run of two steps with one rejection prints, the first step without results, the second the last.
std::string printed(bool speaks, ProgressMode mode) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> stream(std::tmpfile(), &std::fclose);
  {
    ProgressLine line(speaks, mode, stream.get(), 0.0, 0.5);
    StepRecord rejected = record(0);
    rejected.attempt.accepted = false;
    line.attempted(rejected);
    line.stepped(record(0), 0.25, false);
    line.stepped(record(1), 0.5, true);
  }
  std::string text(static_cast<std::size_t>(std::ftell(stream.get())), '\0');
  std::rewind(stream.get());
  text.resize(std::fread(text.data(), 1, text.size(), stream.get()));
  return text;
}

TEST(ProgressTest, AFileGetsPlainLinesWhereResultsAreWritten) {
  EXPECT_EQ(printed(true, ProgressMode::automatic), "step 2 t=0.5 dt=0.1 err=4.20e-03 rej=1 100 %\n");
}

TEST(ProgressTest, ALineInPlaceReturnsTheCarriageAndEndsWithANewLine) {
  const std::string text = printed(true, ProgressMode::always);
  EXPECT_EQ(text.front(), '\r');
  EXPECT_EQ(text.back(), '\n');
  EXPECT_EQ(text.find('\n'), text.size() - 1);
}

TEST(ProgressTest, QuietRanksAndTheModeNeverPrintNothing) {
  EXPECT_EQ(printed(false, ProgressMode::always), "");
  EXPECT_EQ(printed(true, ProgressMode::never), "");
}

TEST(ProgressTest, NoColourIsUsed) { EXPECT_EQ(printed(true, ProgressMode::always).find('\033'), std::string::npos); }

TEST(ProgressTest, AFileIsNoTerminal) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> stream(std::tmpfile(), &std::fclose);
  EXPECT_FALSE(reaches_terminal(stream.get()));
}

}  // namespace
}  // namespace stiffront
