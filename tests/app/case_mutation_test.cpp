// SPDX-License-Identifier: BSD-3-Clause
// Whatever the bytes, a case file is read or refused with one line; nothing else happens.
#include <gtest/gtest.h>

#include <cstdint>
#include <random>

#include "app/example_case.hpp"
#include "stiffront/core/error.hpp"

namespace stiffront::app {
namespace {

const std::vector<std::string> fragments = {"[",
                                            "]",
                                            "{",
                                            "}",
                                            "=",
                                            "\"",
                                            "'",
                                            "\"\"\"",
                                            ".",
                                            ",",
                                            "#",
                                            "\n",
                                            "\\",
                                            "-1",
                                            "nan",
                                            "inf",
                                            "1e999",
                                            "0x",
                                            "true",
                                            "1979-05-27",
                                            "[[grid]]",
                                            "[model.reaction]",
                                            "name = \"dcs\"",
                                            "name = \"custom\"",
                                            "name = \"sbdf\"",
                                            "boundary.x = \"periodic\"",
                                            "[converge]",
                                            "steps = [0.1]",
                                            "999999999999999999",
                                            "-9223372036854775808",
                                            "\xff\xfe",
                                            "\xc3\xa4",
                                            std::string(1, '\0'),
                                            "u = \"u^2\"",
                                            "[output]\nprobes = [[0.5]]",
                                            "species = [\"u\"]",
                                            "a.b.c.d = 1",
                                            "absolute_tolerance = { a = 1 }",
                                            "[[model.reactions]]"};

class Mutation {
 public:
  explicit Mutation(std::uint64_t seed) : random_(seed) {}

  std::string of(std::string text) {
    const bool gentle = pick(2) == 0;
    const int changes = 1 + static_cast<int>(pick(gentle ? 3 : 6));
    for (int i = 0; i < changes; ++i) {
      if (gentle) {  // one digit for another: most such texts are still cases
        const std::size_t digit = text.find_first_of("0123456789", pick(text.size()));
        if (digit != std::string::npos) text[digit] = static_cast<char>('0' + pick(10));
        continue;
      }
      const std::size_t at = pick(text.size() + 1);
      switch (pick(6)) {
        case 0:
          text.erase(at, pick(12));
          break;
        case 1:
          text.insert(at, fragments[pick(fragments.size())]);
          break;
        case 2:
          text.insert(at, 1, static_cast<char>(pick(256)));
          break;
        case 3:
          text.insert(at, text.substr(pick(text.size() + 1), pick(60)));
          break;
        case 4:
          text.resize(at);
          break;
        default:
          if (at < text.size()) text[at] = static_cast<char>(text[at] ^ (1 << pick(8)));
      }
    }
    return text;
  }
  std::size_t pick(std::size_t n) { return n == 0 ? 0 : static_cast<std::size_t>(random_() % n); }

 private:
  std::mt19937_64 random_;
};

TEST(CaseMutation, AnyTextIsReadOrRefusedInOneLine) {
  int read = 0;
  int refused = 0;
  const std::vector<std::string> starts = {example_text, custom_text, network_text,
                                           effective_configuration(parse_example())};
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    Mutation mutation(seed);
    const std::string text = mutation.of(starts[seed % starts.size()]);
    try {
      const Case c = parse_example({}, text);
      ++read;
      EXPECT_TRUE(c.same_options(parse_example({}, effective_configuration(c)))) << "seed " << seed;
    } catch (const Error& error) {
      ++refused;
      EXPECT_EQ(error.kind(), ErrorKind::input) << "seed " << seed << ": " << error.what();
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << "seed " << seed << ": " << error.what();
    }
  }
  EXPECT_GT(read, 200);
  EXPECT_GT(refused, 200);
}

TEST(CaseMutation, AnyOverrideIsReadOrRefusedInOneLine) {
  const std::vector<std::string> starts = {"time.end=0.5", "grid.points=[33, 44]",
                                           "method={ name = \"dcs\", step = 1e-3 }",
                                           "boundary.x={ type = \"dirichlet\", a = \"sin(t)\" }", "title=two words"};
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    Mutation mutation(seed);
    const std::string override = mutation.of(starts[seed % starts.size()]);
    try {
      parse_example({override});
    } catch (const Error& error) {
      EXPECT_TRUE(error.kind() == ErrorKind::input || error.kind() == ErrorKind::usage)
          << "seed " << seed << ": " << error.what();
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << "seed " << seed << ": " << error.what();
    }
  }
}

}  // namespace
}  // namespace stiffront::app
