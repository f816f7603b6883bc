// SPDX-License-Identifier: BSD-3-Clause
// What the tolerance of adaptive Strang splitting means at the end of a run: models, parameters and dimensions beyond those of the paper, with
// default keys, against the coupled solver.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "stiffront/app/case_file.hpp"
#include "stiffront/app/case_source.hpp"
#include "stiffront/app/method_stack.hpp"
#include "stiffront/app/problem.hpp"
#include "stiffront/control/evolve.hpp"
#include "stiffront/solvers/model_registry.hpp"

namespace stiffront::app {
namespace {

struct Variant {
  const char* name;
  const char* model_case;
  std::vector<std::string> overrides;
  std::string text{};  ///< instead of a case
};

/// A front of one species of its own.
std::string front(int half_width, double diffusion, const char* rate, const char* initial, double end) {
  return fmt::format(R"toml([grid]
points = [501]
lower = [-{0}.0]
upper = [{0}.0]
[model]
name = "custom"
species = ["u"]
diffusion = {{ u = {1} }}
[model.reaction]
u = "{2}"
[initial]
u = "{3}"
[time]
end = {4}
[method]
name = "adaptive-strang"
)toml",
                     half_width, diffusion, rate, initial, end);
}

struct Outcome {
  Field state;
  double estimate = 0.0;
  std::int64_t steps = 0;
};

class AdaptiveStrangVariant : public ::testing::TestWithParam<Variant> {
 protected:
  AdaptiveStrangVariant() : comm_(MPI_COMM_SELF) { register_builtin_models(models_); }

  Outcome run(std::string method) {
    std::vector<std::string> overrides = GetParam().overrides;
    overrides.push_back(std::move(method));
    const CaseSource source = !GetParam().text.empty() ? CaseSource{"variant.toml", GetParam().text, overrides}
                                                       : read_case_source(GetParam().model_case, overrides);
    const Case c = parse_case(source, models_.descriptions());
    Problem problem(c, models_, comm_);
    MethodStack stack(c, problem);
    Schedule schedule;
    schedule.end = c.time.end;
    schedule.breakpoints = c.time.breakpoints;
    schedule.restart_period = c.time.restart_step.period;
    schedule.restart_step = c.time.restart_step.step;
    Progress progress;
    Observer nobody;
    EXPECT_TRUE(evolve(stack.method(), schedule, problem.state, progress, nobody));
    Work work;
    const double estimate = stack.method().final_error(progress.t, problem.state, work).value_or(0.0);
    Outcome outcome{problem.state.similar(), estimate, progress.accepted};
    outcome.state.copy_interior(problem.state);
    return outcome;
  }

  /// Root mean square over maximum, the largest of all species.
  static double distance(const Field& u, const Field& reference) {
    double worst = 0.0;
    for (int s = 0; s < u.n_species(); ++s) {
      double sum = 0.0;
      double largest = 0.0;
      for (int j = 0; j < u.n_y(); ++j) {
        for (int i = 0; i < u.n_x(); ++i) {
          sum += std::pow(u.at(s, i, j) - reference.at(s, i, j), 2);
          largest = std::max(largest, std::abs(reference.at(s, i, j)));
        }
      }
      worst = std::max(worst, std::sqrt(sum / (u.n_x() * u.n_y())) / largest);
    }
    return worst;
  }

 private:
  ModelRegistry models_;
  Communicator comm_;
};

TEST_P(AdaptiveStrangVariant, EndsWithinFiveTolerancesAndKnowsIt) {
  const bool plane = std::string(GetParam().name).find("plane") != std::string::npos;
  const Outcome reference =
      run(std::string("method={ name = \"cvode\", relative_tolerance = 1e-9, absolute_tolerance = 1e-12, linear_solver = ") +
          (plane ? "\"gmres\" }" : "\"band\" }"));
  for (const char* tolerance : {"1e-4", "1e-5", "1e-6"}) {
    const Outcome outcome = run(std::string("method={ name = \"adaptive-strang\", tolerance = ") + tolerance + " }");
    const double error = distance(outcome.state, reference.state);
    EXPECT_LT(error, 5.0 * std::stod(tolerance)) << tolerance;
    EXPECT_GT(outcome.estimate, error / 3.0) << tolerance;
    EXPECT_LT(outcome.estimate, 3.0 * error) << tolerance;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Models, AdaptiveStrangVariant,
    ::testing::Values(Variant{"kpp_steep",
                              "kpp-1d",
                              {"model.parameters.k=30.0", "model.diffusion.u=0.0333", "grid.lower=[-5.0]", "grid.upper=[5.0]",
                               "grid.points=[501]", "time.end=3.0"}},
                      Variant{"bistable", nullptr, {}, front(20, 1.0, "10*u*(1 - u)*(u - 0.25)", "1/(1 + exp(sqrt(5)*(x + 10)))", 8.0)},
                      Variant{"fisher", nullptr, {}, front(10, 0.1, "8*u*(1 - u)", "1/(1 + exp(4*(x + 5)))^2", 4.0)},
                      Variant{"bz_other_f", "bz-1d", {"model.parameters.f=2.0", "grid.points=[301]", "time.end=0.04"}},
                      Variant{"bz_other_q", "bz-1d", {"model.parameters.q=8e-4", "grid.points=[301]", "time.end=0.04"}},
                      Variant{"bz_of_two_variables", "bz2-1d", {"model.parameters.f=2.5", "grid.points=[301]", "time.end=0.2"}},
                      Variant{"nerve_impulse", "fhn-1d", {"grid.points=[201]", "grid.upper=[20.0]", "time.end=1.0"}},
                      Variant{"brusselator", "brusselator-1d", {"model.parameters.B=3.4", "grid.points=[101]", "time.end=4.0"}},
                      Variant{"flame", "flame-1d", {"model.parameters.Ze=8.0", "grid.points=[201]", "time.end=3.0"}},
                      Variant{"switched_source",
                              "pulse-1d",
                              {"model.parameters.on=0.17", "model.parameters.off=0.41", "time.breakpoints=[0.17, 0.41]", "time.end=0.8"}},
                      Variant{"discharge_in_a_weaker_field",
                              "discharge-1d",
                              {"model.parameters.field=3e4", "grid.points=[201]", "grid.upper=[0.1]", "time.end=1.01e-6",
                               "time.breakpoints=[1e-8]", "output.times=[1.01e-6]"}},
                      Variant{"discharge_in_a_stronger_field_by_other_pulses",
                              "discharge-1d",
                              {"model.parameters={ field = 5e4, period = 3.7e-7, pulse = 4e-9 }", "grid.points=[201]", "grid.upper=[0.1]",
                               "time.end=6e-7", "time.breakpoints=[4e-9, 3.74e-7]", "time.restart_step={ period = 3.7e-7, step = 4e-9 }",
                               "output.times=[6e-7]"}},
                      Variant{"brusselator_in_the_plane", "brusselator-2d", {"grid.points=[24, 24]", "time.end=1.0"}},
                      Variant{"bz_in_the_plane", "bz-2d-spiral", {"grid.points=[24, 24]", "time.end=0.02"}}),
    [](const auto& info) { return std::string(info.param.name); });

using AdaptiveStrangAtFineTolerances = AdaptiveStrangVariant;

TEST_P(AdaptiveStrangAtFineTolerances, EndsWithinTenTolerancesInLittleMoreThanTheStepsThatAsksFor) {
  const Outcome reference =
      run("method={ name = \"cvode\", relative_tolerance = 1e-12, absolute_tolerance = 1e-14, linear_solver = \"band\" }");
  const Outcome kept = run("method={ name = \"adaptive-strang\", tolerance = 1e-8 }");
  const Outcome free = run("method={ name = \"adaptive-strang\", tolerance = 1e-8, final_error = 0 }");
  const double error = distance(kept.state, reference.state);
  EXPECT_LT(error, 1e-7);
  // The error falls with the square of the step. A quarter more is for beginning with small ones.
  const double needed = std::sqrt(std::max(1.0, distance(free.state, reference.state) / error));
  EXPECT_LT(static_cast<double>(kept.steps), 1.25 * needed * static_cast<double>(free.steps));
}

INSTANTIATE_TEST_SUITE_P(Models, AdaptiveStrangAtFineTolerances,
                         ::testing::Values(Variant{"bz", "bz-1d", {"grid.points=[251]", "time.end=0.02"}},
                                           Variant{"kpp",
                                                   "kpp-1d",
                                                   {"model.parameters.k=10.0", "grid.lower=[-5.0]", "grid.upper=[5.0]", "grid.points=[201]",
                                                    "time.end=2.0"}}),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace stiffront::app
