// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/app/builtin_cases.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <sstream>

#include "stiffront/app/case_source.hpp"
#include "stiffront/core/error.hpp"
#include "stiffront/solvers/model_registry.hpp"

namespace stiffront::app {
namespace {

std::vector<ModelDescription> builtin_models() {
  ModelRegistry registry;
  register_builtin_models(registry);
  return registry.descriptions();
}

TEST(BuiltinCases, AreTheFilesOfTheFolderByteForByte) {
  ASSERT_GE(builtin_cases().size(), 6U);
  for (const BuiltinCase& c : builtin_cases()) {
    std::ifstream file(std::string(STIFFRONT_SOURCE_DIR "/drivers/cases/") + std::string(c.name) + ".toml");
    std::stringstream text;
    text << file.rdbuf();
    EXPECT_EQ(c.text, text.str()) << c.name;
  }
}

TEST(BuiltinCases, AreValidHaveATitleAndAnOutputDirectoryOfTheirOwn) {
  for (const BuiltinCase& c : builtin_cases()) {
    const Case parsed = parse_case({std::string(c.name), std::string(c.text), {}}, builtin_models());
    EXPECT_FALSE(parsed.title.empty()) << c.name;
    EXPECT_EQ(parsed.output.directory, "out/" + std::string(c.name));
    const Case again = parse_case({"effective.toml", effective_configuration(parsed), {}}, builtin_models());
    EXPECT_TRUE(parsed.same_options(again)) << c.name;
  }
}

TEST(BuiltinCases, TheWaveOfDuarteAndEmmettHasThePapersParameters) {
  const CaseSource source = read_case_source("bz-1d", {});
  const Case c = parse_case(source, builtin_models());
  EXPECT_EQ(c.grid.points, std::vector<std::int64_t>{1001});
  EXPECT_EQ(c.model.parameters, (NamedList<double>{{"epsilon", 1e-2}, {"mu", 1e-5}, {"f", 1.6}, {"q", 2e-3}}));
  EXPECT_EQ(c.model.diffusion, (NamedList<Value>{{"a", 2.5e-3}, {"b", 2.5e-3}, {"c", 1.5e-3}}));
}

TEST(CaseSource, AFileComesBeforeABuiltinCaseOfItsName) {
  const std::string name = ::testing::TempDir() + "/bz-1d";
  std::ofstream(name) << "title = \"mine\"\n";
  EXPECT_EQ(read_case_source(name, {"a=1"}).text, "title = \"mine\"\n");
  EXPECT_EQ(read_case_source(name, {"a=1"}).overrides, std::vector<std::string>{"a=1"});
}

TEST(CaseSource, WhatCannotBeReadIsExplained) {
  const auto message_of = [](const std::string& name) -> std::string {
    try {
      read_case_source(name, {});
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::io);
      return error.what();
    }
    return "no error";
  };
  EXPECT_EQ(message_of("bz-1e").substr(0, 78), "bz-1e: No such file or directory; did you mean bz-1d? Allowed built-in cases: ");
  EXPECT_EQ(message_of("/"), "/: Is a directory");
}

}  // namespace
}  // namespace stiffront::app
