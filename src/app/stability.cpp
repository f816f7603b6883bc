// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/app/stability.hpp"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>

#include "choices.hpp"
#include "sdc_defaults.hpp"
#include "stiffront/app/case_file.hpp"
#include "stiffront/control/stability_domain.hpp"
#include "stiffront/core/error.hpp"

namespace stiffront::app {
namespace {

// What a case file needs besides its method.
constexpr const char* any_case = R"toml(
[grid]
points = [3]
lower = [0.0]
upper = [1.0]
[model]
name = "brusselator"
[initial]
u = "1"
v = "1"
[time]
end = 1.0
[method]
name = "sdc"
step = 1.0
)toml";

std::string number_or(const std::optional<double>& x, double largest) {
  return x ? fmt::format("{:.5g}", *x) : fmt::format("> {:g}", largest);
}

nlohmann::ordered_json json_or_null(const std::optional<double>& x) {
  return x ? nlohmann::ordered_json(*x) : nlohmann::ordered_json(nullptr);
}

template <class Choice>
std::string word(Choice c) {
  return choice_words<Choice>[static_cast<std::size_t>(c)];
}

}  // namespace

std::string measure_stability(const StabilityCommand& command, const std::vector<ModelDescription>& models) {
  std::vector<std::string> overrides;
  for (const std::string& o : command.overrides) overrides.push_back(o.starts_with("method.") ? o : "method." + o);
  const Case c = parse_case({"stability", any_case, overrides}, models);
  const auto* o = std::get_if<SdcOptions>(&c.method);
  if (o == nullptr) throw Error(ErrorKind::input, "method.name: domains of stability are measured for \"sdc\"");
  if (!o->step) throw Error(ErrorKind::input, "method.tolerance: the domain of stability is that of fixed steps; leave it out");
  if (o->acceleration)
    throw Error(ErrorKind::input, "method.acceleration: accelerated sweeps are not linear and have no amplification matrix");
  if (o->splitting == SdcSplitting::diagonal) {
    throw Error(ErrorKind::input,
                "method.splitting: docs/sdc.md has the limits of \"diagonal\"; domains are measured for \"preconditioned\" and \"imex\"");
  }
  const SpectralDeferredCorrectionOptions parameters = sdc_parameters(*o);
  const StabilityDomain d =
      stability_domain(parameters, {command.implicit_real, command.implicit_imaginary}, {-0.1, -1.0, -5.0, -10.0, -20.0, -40.0});

  std::string text = fmt::format("{}, {} nodes, starting order {}, {} corrections, {}, final update {}\n", word(o->nodes), o->node_count,
                                 *o->starting_order, *o->corrections, o->consistent ? "consistent" : "inconsistent", word(o->final_update));
  text += fmt::format("implicit: {:g} Re z + {:g} i Im z; z = step x eigenvalue\n\n", command.implicit_real, command.implicit_imaginary);
  text += fmt::format("{:<38}{:.1f}\n", "stable area of [-60, 0] x [0, 40]", d.area);
  text += fmt::format("{:<38}{}\n", "first exit along the real axis", number_or(d.real_axis, d.axis_end));
  for (std::size_t i = 0; i < d.at.size(); ++i) {
    text += fmt::format("{:<38}{}\n", fmt::format("first exit upwards at Re z = {:g}", d.at[i]), number_or(d.beta[i], d.strip_end));
  }
  text += fmt::format("{:<38}{:.4g}\n", "spectral radius at z = -1e8", d.at_infinity);

  if (!command.output.empty()) {
    nlohmann::ordered_json j;
    j["method"] = {{"nodes", word(o->nodes)},
                   {"node_count", o->node_count},
                   {"starting_order", *o->starting_order},
                   {"corrections", *o->corrections},
                   {"consistent", o->consistent},
                   {"correction", word(o->correction)},
                   {"final_update", word(o->final_update)}};
    j["implicit"] = {{"real", command.implicit_real}, {"imaginary", command.implicit_imaginary}};
    j["area"] = d.area;
    j["real_axis"] = json_or_null(d.real_axis);
    j["strip"] = nlohmann::ordered_json::array();
    for (std::size_t i = 0; i < d.at.size(); ++i) j["strip"].push_back({{"alpha", d.at[i]}, {"beta", json_or_null(d.beta[i])}});
    j["at_infinity"] = d.at_infinity;
    j["raster"] = {{"alpha", {d.raster_left, 0.0}}, {"beta", {0.0, d.raster_top}}};
    // Five digits are enough for a picture; whether a cell is stable is kept.
    for (int row = 0; row < d.cells; ++row) {
      nlohmann::ordered_json line = nlohmann::ordered_json::array();
      for (int column = 0; column < d.cells; ++column) {
        const double r = d.raster[static_cast<std::size_t>(row * d.cells + column)];
        const double rounded = std::stod(fmt::format("{:.5g}", r));
        line.push_back(is_stable(rounded) == is_stable(r) ? rounded : r);
      }
      j["spectral_radius"].push_back(std::move(line));
    }
    std::error_code status;
    std::filesystem::create_directories(command.output, status);
    const std::filesystem::path path = std::filesystem::path(command.output) / "stability.json";
    std::ofstream file(path);
    file << j.dump() << '\n';
    file.close();
    if (!file) throw Error(ErrorKind::io, fmt::format("{}: cannot be written", path.string()));
  }
  return text;
}

}  // namespace stiffront::app
