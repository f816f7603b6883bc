// SPDX-License-Identifier: BSD-3-Clause
//
// Whatever tolerance or step is asked of dcs, it ends near the solution or says why not: every built-in case on a small grid. The whole
// campaign is drivers/reproduce/dcs_campaign.py.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "stiffront/app/builtin_cases.hpp"
#include "stiffront/app/case_file.hpp"
#include "stiffront/app/method_stack.hpp"
#include "stiffront/app/problem.hpp"
#include "stiffront/control/evolve.hpp"
#include "stiffront/core/error.hpp"
#include "stiffront/solvers/model_registry.hpp"

namespace stiffront::app {
namespace {

/// The part of the time span that is run.
double window(const std::string& name) {
  static const std::map<std::string, double> parts{{"bz-1d", 0.05},          {"bz-1d-long", 0.005},   {"bz-2d-spiral", 0.01},
                                                   {"discharge-1d", 0.0009}, {"gray-scott-1d", 0.05}, {"slaved-oscillator-1d", 0.02},
                                                   {"pulse-1d", 0.5},        {"ignition-1d", 0.3}};
  const auto found = parts.find(name);
  return found == parts.end() ? 0.02 : found->second;
}

struct Outcome {
  std::vector<std::vector<double>> state;  // by species
  std::string failure;
  Progress progress;
};

class DcsCampaign : public ::testing::TestWithParam<int> {
 protected:
  DcsCampaign() : self_(MPI_COMM_SELF) { register_builtin_models(models_); }

  static const BuiltinCase& tested() { return builtin_cases()[static_cast<std::size_t>(GetParam())]; }

  Case parsed(const std::string& method) const {
    const std::string points = tested().name.find("-2d") != std::string_view::npos ? "grid.points=[24, 24]" : "grid.points=[65]";
    return parse_case({std::string(tested().name), std::string(tested().text), {points, "method=" + method}}, models_.descriptions());
  }

  Outcome solve(const std::string& method) const {
    const Case c = parsed(method);
    Outcome r;
    Problem problem(c, models_, self_);
    MethodStack stack(c, problem);
    Schedule schedule;
    schedule.start = c.time.start;
    schedule.end = end(c);
    for (double t : c.time.breakpoints) {
      if (t < schedule.end) schedule.breakpoints.push_back(t);
    }
    schedule.max_steps = 20000;
    Observer nobody;
    try {
      evolve(stack.method(), schedule, problem.state, r.progress, nobody);
    } catch (const Error& e) {
      r.failure = e.what();
    }
    for (int s = 0; s < problem.state.n_species(); ++s) {
      r.state.emplace_back();
      for (int j = 0; j < problem.state.n_y(); ++j) {
        r.state.back().insert(r.state.back().end(), problem.state.row(s, j), problem.state.row(s, j) + problem.state.n_x());
      }
    }
    return r;
  }

  static double end(const Case& c) { return c.time.start + window(std::string(tested().name)) * (c.time.end - c.time.start); }

  /// Root mean square over largest modulus, the largest over the species.
  static double error(const Outcome& a, const Outcome& reference) {
    double worst = 0.0;
    for (std::size_t s = 0; s < reference.state.size(); ++s) {
      double sum = 0.0, largest = 0.0;
      for (std::size_t i = 0; i < reference.state[s].size(); ++i) {
        const double e = a.state[s][i] - reference.state[s][i];
        sum += e * e;
        largest = std::max(largest, std::abs(reference.state[s][i]));
      }
      const double e = std::sqrt(sum / static_cast<double>(reference.state[s].size())) / (largest > 0.0 ? largest : 1.0);
      worst = std::isfinite(e) ? std::max(worst, e) : e;
      if (std::isnan(worst)) return worst;
    }
    return worst;
  }

  ModelRegistry models_;
  Communicator self_;
};

TEST_P(DcsCampaign, KeepsEveryTolerance) {
  const Outcome reference = solve("{name=\"cvode\", relative_tolerance=1e-8, absolute_tolerance=1e-12}");
  ASSERT_EQ(reference.failure, "") << tested().name;
  for (double tolerance : {1e-2, 1e-4, 1e-6, 1e-9, 1e-12}) {
    const Outcome r = solve(fmt::format("{{name=\"dcs\", tolerance={:e}}}", tolerance));
    EXPECT_EQ(r.failure, "") << tested().name << " " << tolerance;
    EXPECT_LT(error(r, reference), 10.0 * tolerance * std::sqrt(static_cast<double>(r.progress.accepted)) + 1e-5)
        << tested().name << " " << tolerance;
  }
}

TEST_P(DcsCampaign, FixedStepsAreSolvedOrRefusedWithTheLimit) {
  const Outcome reference = solve("{name=\"cvode\", relative_tolerance=1e-6}");
  const Case c = parsed("{name=\"lie\", step=1}");
  for (int k : {1, 2, 4, 6}) {
    for (int n : {1, 8, 64, 512}) {
      const double step = (end(c) - c.time.start) / n;
      const Outcome r = solve(fmt::format("{{name=\"dcs\", step={:e}, iterations={}}}", step, k));
      if (r.failure.empty()) {
        EXPECT_LT(error(r, reference), 2.0) << tested().name << " k = " << k << ", " << n << " steps";
      } else {
        EXPECT_NE(r.failure.find("limit of stability"), std::string::npos)
            << tested().name << " k = " << k << ", " << n << " steps: " << r.failure;
      }
    }
  }
}

/// All but the cases of models with first derivatives, which dcs refuses.
std::vector<int> cases_for_dcs() {
  ModelRegistry models;
  register_builtin_models(models);
  std::vector<int> indices;
  for (std::size_t i = 0; i < builtin_cases().size(); ++i) {
    const BuiltinCase& each = builtin_cases()[i];
    const Case c = parse_case({std::string(each.name), std::string(each.text), {}}, models.descriptions());
    const auto known = models.descriptions();
    const bool refused =
        std::any_of(known.begin(), known.end(), [&](const ModelDescription& m) { return m.name == c.model.name && m.has_transport; });
    if (!refused) indices.push_back(static_cast<int>(i));
  }
  return indices;
}

INSTANTIATE_TEST_SUITE_P(BuiltinCases, DcsCampaign, ::testing::ValuesIn(cases_for_dcs()), [](const ::testing::TestParamInfo<int>& i) {
  std::string name(builtin_cases()[static_cast<std::size_t>(i.param)].name);
  for (char& letter : name) letter = letter == '-' ? '_' : letter;
  return name;
});

}  // namespace
}  // namespace stiffront::app
