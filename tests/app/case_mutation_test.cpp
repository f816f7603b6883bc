// SPDX-License-Identifier: BSD-3-Clause
// Whatever the bytes, a case file is read or refused with one line; nothing else happens.
#include <gtest/gtest.h>

#include <cstdint>

#include "app/example_case.hpp"
#include "stiffront/app/builtin_cases.hpp"
#include "stiffront/core/error.hpp"
#include "stiffront/solvers/model_registry.hpp"
#include "support/mutation.hpp"

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

TEST(CaseMutation, AnyTextIsReadOrRefusedInOneLine) {
  int read = 0;
  int refused = 0;
  const std::vector<std::string> starts = {example_text, custom_text, network_text, effective_configuration(parse_example())};
  for (std::uint64_t seed = 0; seed < testing::mutation_rounds(2000); ++seed) {
    testing::Mutation mutation(seed);
    const std::string text = mutation.of(starts[seed % starts.size()], fragments);
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

TEST(CaseMutation, AnyTextCloseToABuiltinCaseIsReadOrRefusedInOneLine) {
  ModelRegistry registry;
  register_builtin_models(registry);
  const std::vector<ModelDescription> models = registry.descriptions();
  const auto& starts = builtin_cases();
  for (std::uint64_t seed = 0; seed < testing::mutation_rounds(1500); ++seed) {
    testing::Mutation mutation(seed);
    const std::string text = mutation.of(std::string(starts[seed % starts.size()].text), fragments);
    try {
      parse_case({"case.toml", text, {}}, models);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::input) << "seed " << seed << ": " << error.what();
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << "seed " << seed << ": " << error.what();
    }
  }
}

TEST(CaseMutation, AnyOverrideIsReadOrRefusedInOneLine) {
  const std::vector<std::string> starts = {"time.end=0.5", "grid.points=[33, 44]", "method={ name = \"dcs\", step = 1e-3 }",
                                           "boundary.x={ type = \"dirichlet\", a = \"sin(t)\" }", "title=two words"};
  for (std::uint64_t seed = 0; seed < testing::mutation_rounds(2000); ++seed) {
    testing::Mutation mutation(seed);
    const std::string override = mutation.of(starts[seed % starts.size()], fragments);
    try {
      parse_example({override});
    } catch (const Error& error) {
      EXPECT_TRUE(error.kind() == ErrorKind::input || error.kind() == ErrorKind::usage) << "seed " << seed << ": " << error.what();
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << "seed " << seed << ": " << error.what();
    }
  }
}

}  // namespace
}  // namespace stiffront::app
