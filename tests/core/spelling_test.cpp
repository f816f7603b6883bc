// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/core/spelling.hpp"

#include <gtest/gtest.h>

namespace stiffront {
namespace {

const std::vector<std::string> names = {"tolerance", "initial_step", "epsilon", "a"};

TEST(SpellingTest, OneEditInThreeLettersIsNear) {
  EXPECT_EQ(nearest_name("tolerence", names), "tolerance");
  EXPECT_EQ(nearest_name("toleranec", names), "tolerance");
  EXPECT_EQ(nearest_name("Epsilon", names), "epsilon");
  EXPECT_EQ(nearest_name("espilo", names), "epsilon");
  EXPECT_EQ(nearest_name("step", names), "");
}

TEST(SpellingTest, NoSuggestionWithoutALetterInCommon) {
  EXPECT_EQ(nearest_name("b", names), "");
  EXPECT_EQ(suggestion("", names), "");
  EXPECT_EQ(suggestion(std::string(1000, 'a'), names), "");
}

TEST(SpellingTest, SuggestionsAndListsMakeOneSentence) {
  EXPECT_EQ(with_allowed(suggestion("epsilom", {"epsilon", "mu"}), "", {"epsilon", "mu"}), "; did you mean epsilon? Allowed: epsilon, mu");
  EXPECT_EQ(with_allowed("", " in [grid]", {"points"}), "; allowed in [grid]: points");
}

}  // namespace
}  // namespace stiffront
