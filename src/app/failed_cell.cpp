// SPDX-License-Identifier: BSD-3-Clause
#include "failed_cell.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "stiffront/app/case_file.hpp"

namespace stiffront::app {
namespace {

/// Width of a domain that begins at x and whose points all but coincide.
double small_width(double x) { return std::ldexp(1.0, std::ilogb(std::max(std::abs(x), 1e-300)) - 20); }

}  // namespace

const CellFailure& most_telling(const std::vector<CellFailure>& failures) {
  const CellFailure& last = failures.back();
  return *std::find_if(failures.begin(), failures.end(), [&](const CellFailure& f) { return f.i == last.i && f.j == last.j; });
}

std::string describe(const CellFailure& failure, const std::vector<std::string>& species) {
  std::string text =
      fmt::format("cell ({}, {}) at x = {:.10g}, y = {:.10g}, t = {:.17g}: ", failure.i, failure.j, failure.x, failure.y, failure.t);
  if (failure.species >= 0) text += fmt::format("species {}: ", species[static_cast<std::size_t>(failure.species)]);
  text += failure.reason;
  if (failure.dt > 0.0) text += fmt::format(" (inner step {:.3g})", failure.dt);
  text += fmt::format("; state at t = {:.17g}, {:.3g} before the end of the sub-step:", failure.begin, failure.interval);
  for (std::size_t s = 0; s < failure.state.size(); ++s)
    text += fmt::format("{} {} = {:.17g}", s == 0 ? "" : ",", species[s], failure.state[s]);
  return text;
}

std::string failed_cell_case(const Case& c, const CellFailure& failure, double reaction_tolerance) {
  Case alone = c;
  alone.title = fmt::format("The cell ({}, {}) at x = {:.10g}, y = {:.10g} that failed at t = {:.17g}", failure.i, failure.j, failure.x,
                            failure.y, failure.t);
  const double place[] = {failure.x, failure.y};
  for (std::size_t d = 0; d < c.grid.points.size(); ++d) {
    alone.grid.points[d] = 3;
    alone.grid.lower[d] = place[d];  // of equal failures the first point's is reported, which is at the very place
    alone.grid.upper[d] = place[d] + small_width(place[d]);
    alone.grid.processes[d] = 0;
    alone.boundary.sides[d] = {};
  }
  alone.space = SpaceOptions{2, 2};
  for (auto& [species, coefficient] : alone.model.diffusion) coefficient = 0.0;
  alone.initial = {};
  for (std::size_t s = 0; s < failure.state.size(); ++s) alone.initial.expressions.emplace_back(c.model.species[s], failure.state[s]);
  alone.time = {};
  alone.time.start = failure.begin;
  alone.time.end = failure.begin + failure.interval;
  alone.method = LieOptions{failure.interval, SplittingOrder::reaction_last};
  alone.reaction_solver.tolerance = reaction_tolerance;
  alone.output = {};
  alone.output.directory = (std::filesystem::path(c.output.directory) / "failed-cell").string();
  alone.limits = {};
  alone.converge.reset();
  return fmt::format("# {}\n\n", describe(failure, c.model.species)) + effective_configuration(alone);
}

}  // namespace stiffront::app
