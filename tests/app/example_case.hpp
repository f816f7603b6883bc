// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <vector>

#include "stiffront/app/case_file.hpp"

/// Models and cases that the tests of this area vary.
namespace stiffront::app {

inline std::vector<ModelDescription> example_models() {
  std::vector<ModelDescription> models;
  models.push_back({"bz",
                    "Field and Noyes 1974",
                    {"a", "b", "c"},
                    {{"epsilon", 1e-2}, {"mu", 1e-5}, {"f", 1.6}, {"q", 2e-3}},
                    {2.5e-3, 2.5e-3, 1.5e-3},
                    {{"bz-front", "a wave"}, {"bz-ignition", "two waves"}, {"bz-spiral", "a spiral", 2}}});
  models.push_back({"kpp", "Kolmogorov et al. 1937", {"u"}, {{"k", 1.0}}, {1.0}, {{"kpp-front", "a wave"}}});
  return models;
}

inline const char* example_text = R"toml(title = "A wave"
[grid]
points = [101]
[model]
name = "bz"
parameters = { f = 3.0 }
[initial]
profile = "bz-front"
[time]
end = 2.0
[method]
name = "adaptive-strang"
tolerance = 1e-5
)toml";

inline const char* custom_text = R"toml([grid]
points = [33, 65]
upper = [1, 2]
[model]
name = "custom"
species = ["u", "v"]
parameters = { B = 3.0, A = 1.0, nu = 2e-3 }
diffusion = { u = "nu" }
[model.reaction]
v = "B*u - u^2*v"
u = "A + u^2*v - (B + 1)*u"
[initial]
u = "1 + 0.1*sin(pi*x)"
v = 3
[time]
end = 2
[method]
name = "strang"
step = 1e-3
)toml";

inline const char* network_text = R"toml([grid]
points = [33]
[model]
name = "custom"
species = ["u", "v"]
[[model.reactions]]
equation = "2 u + v -> 3 u"
rate = 1.0
[[model.reactions]]
equation = "u <-> 0"
rate = "0.1*(1 + x)"
reverse_rate = 0.01
mass_action = false
[initial]
u = 1
v = 0
[time]
end = 2
)toml";

inline Case parse_example(const std::vector<std::string>& overrides = {}, const std::string& text = example_text) {
  return parse_case({"bz.toml", text, overrides}, example_models());
}

}  // namespace stiffront::app
