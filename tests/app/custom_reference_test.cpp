// SPDX-License-Identifier: BSD-3-Clause
// Models typed into case files against solutions computed elsewhere: references/reference_solutions.py.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "stiffront/app/case_file.hpp"
#include "stiffront/app/method_stack.hpp"
#include "stiffront/app/problem.hpp"
#include "stiffront/control/evolve.hpp"
#include "stiffront/solvers/model_registry.hpp"

namespace stiffront::app {
namespace {

struct Reference {
  const char* name;
  std::vector<int> points;
  std::vector<double> scale;  ///< largest value of each species at the end
  std::vector<std::vector<double>> values;
};

const Reference references[] = {{"barkley",
                                 {0, 25, 50, 75, 100},
                                 {1, 0.8864},
                                 {{0.924145314856, 0.999977239941, 0.0601816802831, 1.31294362306e-11, 5.50566801844e-21},
                                  {0.88641710647, 0.678432034321, 0.00337833735928, 7.21418082008e-13, 2.92372986334e-22}}},
                                {"hires",
                                 {0, 10, 20, 30, 40},
                                 {0.003471, 0.0006788, 0.0005918, 0.005976, 0.09608, 0.3827, 0.01109, 0.005943},
                                 {{0.00347060211761, 0.00335961150078, 0.00233542643608, 0.00100945931859, 0.000695152660321},
                                  {0.00067868761467, 0.000657092017043, 0.000457069316926, 0.00019792777116, 0.000135994535848},
                                  {0.000591770862935, 0.000569561461746, 0.000368688256321, 0.000109598396506, 5.0962665785e-05},
                                  {0.00597564297417, 0.00576124741097, 0.00399430857556, 0.00171269180448, 0.00111250734411},
                                  {0.0960619521552, 0.0923071199328, 0.056417859754, 0.0102006583786, 0.000905586943786},
                                  {0.382724978405, 0.365661214486, 0.218066649095, 0.0286209988218, 0.00175379661653},
                                  {0.00558159652275, 0.00704189608718, 0.00852406234773, 0.0103118161059, 0.00161492207709},
                                  {9.42872970653e-05, 0.000124475457577, 0.000252682677693, 0.00232441509326, 0.00594342029782}}},
                                {"arrhenius",
                                 {0, 30, 36, 40, 44},
                                 {1936, 1},
                                 {{1501.45641409, 1777.5541441, 301.749474807, 300.013532185, 300.001086922},
                                  {8.03543765054e-38, 1.16766149004e-12, 0.999948914748, 0.999998423396, 0.999999900917}}},
                                {"forced",
                                 {0, 20, 40, 60, 80},
                                 {0.8961, 0.4846},
                                 {{0.889324395526, 0.809572516665, 0.866799663832, 0.867975799838, 0.88722987357},
                                  {0.424725465881, 0.444770312617, 0.441812324737, 0.482752551778, 0.431814638397}}}};

std::string text_of(const std::string& name) {
  std::ifstream file(std::string(STIFFRONT_SOURCE_DIR) + "/tests/app/references/" + name + ".toml");
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

/// The largest error at the points of the reference, relative to each species' largest value.
double error_of(const Reference& reference, std::vector<std::string> overrides) {
  overrides.insert(overrides.end(), {"diffusion_solver.tolerance=1e-13", "reaction_solver.tolerance=1e-13"});
  const Case c = parse_case({reference.name, text_of(reference.name), overrides}, {});
  const ModelRegistry models;
  const Communicator comm(MPI_COMM_SELF);
  Problem problem(c, models, comm);
  MethodStack stack(c, problem);
  Schedule schedule;
  schedule.end = c.time.end;
  schedule.breakpoints = c.time.breakpoints;
  Progress progress;
  Observer observer;
  EXPECT_TRUE(evolve(stack.method(), schedule, problem.state, progress, observer));
  double error = 0.0;
  for (std::size_t s = 0; s < reference.values.size(); ++s) {
    for (std::size_t k = 0; k < reference.points.size(); ++k) {
      const double difference = problem.state.at(static_cast<int>(s), reference.points[k], 0) - reference.values[s][k];
      error = std::max(error, std::abs(difference) / reference.scale[s]);
    }
  }
  return error;
}

class CustomReference : public ::testing::TestWithParam<Reference> {};

TEST_P(CustomReference, IsMetToOneInAHundredMillionBySbdf) {
  EXPECT_LT(error_of(GetParam(), {"method={ name = \"sbdf\", relative_tolerance = 1e-12, absolute_tolerance = 1e-14 }"}), 1e-8);
}

TEST_P(CustomReference, IsMetToOneInAHundredMillionByCvode) {
  EXPECT_LT(error_of(GetParam(), {"method={ name = \"cvode\", relative_tolerance = 1e-12, absolute_tolerance = 1e-14 }"}), 1e-8);
}

INSTANTIATE_TEST_SUITE_P(Models, CustomReference, ::testing::ValuesIn(references),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(CustomReferenceBySplitting, IsMetToOneInAHundredMillionByDeferredCorrection) {
  for (const Reference& reference : references) {
    if (reference.name == std::string("arrhenius")) continue;  // 7 s
    EXPECT_LT(error_of(reference, {"method={ name = \"dcs\", tolerance = 1e-10 }"}), 1e-8) << reference.name;
  }
}

}  // namespace
}  // namespace stiffront::app
