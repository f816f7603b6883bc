// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/app/stability.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "stiffront/core/error.hpp"
#include "stiffront/solvers/model_registry.hpp"
#include "support/temporary_folder.hpp"

namespace stiffront::app {
namespace {

std::vector<ModelDescription> models() {
  ModelRegistry registry;
  register_builtin_models(registry);
  return registry.descriptions();
}

std::string refusal(std::vector<std::string> overrides) {
  StabilityCommand command;
  command.overrides = std::move(overrides);
  try {
    measure_stability(command, models());
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::input);
    return e.what();
  }
  return "none";
}

TEST(StabilityTest, TablesAndFilesHoldTheSameNumbers) {
  const Communicator comm(MPI_COMM_SELF);
  const testing::TemporaryFolder folder(comm);
  StabilityCommand command;
  command.overrides = {"nodes=gauss-lobatto", "method.node_count=5", "corrections=6", "final_update=quadrature"};
  command.output = folder.file("domain");
  const std::string text = measure_stability(command, models());
  EXPECT_NE(text.find("247.4"), std::string::npos) << text;
  EXPECT_NE(text.find("49.44"), std::string::npos) << text;
  const auto j = nlohmann::json::parse(std::ifstream(std::filesystem::path(command.output) / "stability.json"));
  EXPECT_NEAR(j["area"].get<double>(), 247.4, 0.1);
  EXPECT_NEAR(j["real_axis"].get<double>(), 49.44, 0.01);
  int stable = 0;
  for (const auto& row : j["spectral_radius"]) {
    for (const double r : row) stable += r <= 1.0 + 1e-8 ? 1 : 0;
  }
  EXPECT_NEAR(stable * 2400.0 / (241.0 * 241.0), j["area"].get<double>(), 1e-9);
}

TEST(StabilityTest, WhatIsNotLinearOrNoKeyIsRefusedByName) {
  EXPECT_NE(refusal({"node_cuont=5"}).find("method.node_cuont"), std::string::npos);
  EXPECT_NE(refusal({"acceleration=true"}).find("method.acceleration"), std::string::npos);
  EXPECT_NE(refusal({"tolerance=1e-3"}).find("method.step"), std::string::npos);
  EXPECT_NE(refusal({"starting_order=9"}).find("method.starting_order"), std::string::npos);
}

}  // namespace
}  // namespace stiffront::app
