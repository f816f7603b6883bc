// SPDX-License-Identifier: BSD-3-Clause
#include "advice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "stiffront/control/sbdf.hpp"
#include "stiffront/control/state_norm.hpp"
#include "stiffront/core/agree.hpp"
#include "stiffront/mesh/halo_exchange.hpp"

namespace stiffront::app {
namespace {

/// What order four misses where order two misses so much: of a wave of number k these are k^4 h^4 / 90 and k^2 h^2 / 12.
double of_order_four(double of_order_two) { return 1.6 * of_order_two * of_order_two; }

constexpr double far_from_kept = 1.6;  // times method.final_error: the rule keeps it within a few per cent where it can

double kept_final_error(const MethodOptions& method) {
  const auto* strang = std::get_if<AdaptiveStrangOptions>(&method);
  return strang != nullptr && strang->critical_step ? strang->final_error.value_or(0.0) : 0.0;
}

}  // namespace

ErrorRecord::ErrorRecord(const MethodOptions& method) {
  if (const auto* strang = std::get_if<AdaptiveStrangOptions>(&method)) tolerance_ = strang->tolerance;
  if (const auto* dcs = std::get_if<DcsOptions>(&method)) tolerance_ = dcs->tolerance.value_or(0.0);
  if (const auto* sbdf = std::get_if<SbdfOptions>(&method)) unit_ = tolerance_ = sbdf_step_tolerance(sbdf->relative_tolerance);
  if (const auto* sdc = std::get_if<SdcOptions>(&method); sdc != nullptr && sdc->splitting == SdcSplitting::diagonal)
    tolerance_ = sdc->tolerance.value_or(0.0);
  if (const auto* cvode = std::get_if<CvodeOptions>(&method)) unit_ = tolerance_ = cvode->relative_tolerance;
}

void ErrorRecord::add(const StepRecord& record) {
  const Attempt& a = record.attempt;
  if (!a.accepted || !std::isfinite(a.error)) return;
  step_before_ = std::exchange(last_step_, record.dt);
  if (a.error > 0.0) ++estimates_;
  sum_ += a.error;
  largest_ = std::max(largest_, a.error);
  if (a.critical_dt > 0.0 && record.dt > 0.85 * a.critical_dt) ++at_critical_step_;
}

SpatialError spatial_error(Problem& problem) {
  const int m = problem.model->n_species();
  SpatialError result;
  result.missed.assign(static_cast<std::size_t>(m), 0.0);
  const std::vector<int>& diffusing = problem.diffusion.diffusing_species();
  constexpr int width = 2;
  for (int d = 0; d < problem.grid.dimension; ++d) {
    const auto k = static_cast<std::size_t>(d);
    // Each rank's part has to hold the wider halo of its neighbours, a mirrored one included.
    if (problem.grid.points[k] < static_cast<std::int64_t>(problem.decomposition.processes()[k]) * (width + 2)) return result;
  }
  if (diffusing.empty() || problem.diffusion.order() == 8) return result;  // the estimate is one of orders two and four

  const Decomposition wide(problem.comm, problem.grid, problem.decomposition.processes(), width);
  std::vector<double> coefficients;
  for (int s = 0; s < m; ++s) coefficients.push_back(problem.diffusion.coefficient(s));
  const DiffusionOperator second(problem.grid, problem.boundary, coefficients, 2);
  const DiffusionOperator fourth(problem.grid, problem.boundary, coefficients, 4);
  Field u(wide, m, width);
  Field by_second = u.similar();
  Field by_fourth = u.similar();
  u.copy_interior(problem.state);
  HaloExchange halo(wide, problem.boundary, m, 1, width, diffusing);
  halo.exchange(u);
  const FreeBox box = problem.boundary.free_box(wide);
  second.apply(u, by_second, box);
  fourth.apply(u, by_fourth, box);

  Agreement largest(0, 2 * m);
  for (const int s : diffusing) {
    double& difference = largest.maxima[static_cast<std::size_t>(2 * s)];
    double& term = largest.maxima[static_cast<std::size_t>(2 * s + 1)];
    for (int j = box.j_begin; j < box.j_end; ++j) {
      for (int i = box.i_begin; i < box.i_end; ++i) {
        difference = std::max(difference, std::abs(by_fourth.at(s, i, j) - by_second.at(s, i, j)));
        term = std::max(term, std::abs(by_fourth.at(s, i, j)));
      }
    }
  }
  problem.comm.agree(largest);
  for (const int s : diffusing) {
    const double term = largest.maxima[static_cast<std::size_t>(2 * s + 1)];
    if (!(term > 0.0)) continue;
    const double missed = largest.maxima[static_cast<std::size_t>(2 * s)] / term;
    result.missed[static_cast<std::size_t>(s)] = problem.diffusion.order() == 2 ? missed : of_order_four(missed);
  }

  const StateNorm norm(wide, problem.boundary, m, {});
  Agreement norms = norm.agreement(2);
  Field nothing = u.similar();
  norm.add_difference(by_fourth, by_second, 0, norms);
  norm.add_difference(by_fourth, nothing, 1, norms);
  norm.add_scale(u, norms);
  problem.comm.agree(norms);
  for (const int s : diffusing) {
    const double difference = norm.value(0, s, norms);
    const double term = norm.value(1, s, norms);
    if (!(term > 0.0)) continue;
    result.rate = std::max(result.rate, problem.diffusion.order() == 2 ? difference : of_order_four(difference / term) * term);
  }
  return result;
}

std::vector<std::string> advice(const Case& c, const Summary& summary, const ErrorRecord& errors, const SpatialError& in_space) {
  std::vector<std::string> lines;
  const double attempts = static_cast<double>(summary.accepted + summary.rejected);
  if (summary.final_error) {
    lines.push_back(
        fmt::format("error in time at the end: about {:.2g}, {:.2g} times the tolerance of a step, by a second solution with four times "
                    "the step",
                    *summary.final_error, *summary.final_error / errors.tolerance()));
    if (const double asked = kept_final_error(c.method); asked > 0.0 && *summary.final_error > far_from_kept * asked * errors.tolerance()) {
      lines.push_back(fmt::format(
          "that is more than method.final_error = {:.3g} tolerances: errors that were small when they were made have grown, or what they "
          "are measured by has shrunk. A run with method.final_error={:.2g} ends nearer to it",
          asked, asked * asked * errors.tolerance() / *summary.final_error));
    }
  } else if (errors.tolerance() > 0.0 && errors.estimates() > 0) {
    lines.push_back(fmt::format(
        "error in time: every step's estimate is within the tolerance {:.2g} (largest {:.2g}, sum over {} steps {:.2g}). What is "
        "left of that at the end is up to the model: waves and patterns that attract forget most of it, chaos amplifies it. A "
        "run with a tolerance ten times smaller tells.",
        errors.tolerance(), errors.largest(), summary.accepted, errors.sum()));
  } else if (!(errors.tolerance() > 0.0)) {
    lines.emplace_back("error in time: not estimated with fixed steps; run again with half the step, or see stiffront converge");
  }
  const std::vector<double>& missed = in_space.missed;
  const auto worst = std::max_element(missed.begin(), missed.end());
  if (worst != missed.end() && *worst > 0.0) {
    const std::string& species = c.model.species[static_cast<std::size_t>(worst - missed.begin())];
    const char* remedy =
        c.space.order == 2 ? "twice the points divide that by 4; space.order=4 helps more" : "twice the points divide that by 16";
    lines.push_back(fmt::format(
        "error in space: the differences of order {} miss {:.2g} % of the diffusion of {} in the final state; speeds and widths of "
        "fronts may be off by about as much{}{}",
        c.space.order, 100.0 * *worst, species, *worst > 0.01 ? "; " : "", *worst > 0.01 ? remedy : ""));
    if (errors.tolerance() > 0.0 && errors.estimates() > 0 && *worst > 100.0 * summary.final_error.value_or(errors.sum())) {
      lines.emplace_back("the error in space is far above the one in time: a larger tolerance would do as well, and be faster");
    }
  }
  if (const auto* dcs = std::get_if<DcsOptions>(&c.method); dcs != nullptr && dcs->tolerance && in_space.rate > 0.0) {
    const double of_step = in_space.rate * errors.recent_step();
    if (of_step > *dcs->tolerance) {
      lines.push_back(fmt::format(
          "method.tolerance is finer than the grid deserves: in a step of {:.3g} the error in space is about {:.2g}, that in time is "
          "held at {:.2g}; {}",
          errors.recent_step(), of_step, *dcs->tolerance,
          c.space.order == 2 ? "take more points, space.order=4, or a tolerance nearer to it"
                             : "take more points, or a tolerance nearer to it"));
    } else {
      lines.push_back(fmt::format("error in space of one step of {:.3g}: about {:.2g}, below the tolerance {:.2g}", errors.recent_step(),
                                  of_step, *dcs->tolerance));
    }
  }
  if (summary.accepted > 20 && static_cast<double>(summary.rejected) > 0.2 * attempts) {
    lines.push_back(fmt::format(
        "{:.0f} % of the attempts were rejected: data that jump belong in time.breakpoints; otherwise a smaller tolerance may even "
        "be faster",
        100.0 * static_cast<double>(summary.rejected) / attempts));
  }
  if (2 * errors.at_critical_step() > summary.accepted) {
    lines.emplace_back(
        "most steps were as long as the critical splitting step allows, not the tolerance: method sbdf or dcs would go farther");
  }
  if (summary.ranks > 1 && summary.imbalance > 1.25) {
    lines.push_back(
        fmt::format("imbalance {:.2f}: the busiest rank does {:.0f} % more of the reaction than the mean; grid.processes cuts the domain "
                    "differently, fewer ranks waste less",
                    summary.imbalance, 100.0 * (summary.imbalance - 1.0)));
  }
  double output = 0.0;
  double total = 0.0;
  double communication = 0.0;
  for (const auto& [phase, seconds] : summary.wall_seconds) {
    if (phase == "output") output = seconds;
    if (phase == "total") total = seconds;
    if (phase == "communication") communication = seconds;
  }
  if (total + output > 5.0 && output > 0.5 * total)
    lines.emplace_back("output took long: fewer times in [output], or a faster disk for its directory");
  if (total > 5.0 && communication > 0.4 * total) {
    lines.emplace_back("much time went into waiting for other ranks: fewer ranks, or a larger grid for as many");
  }
  if (summary.negatives > 0) {
    lines.push_back(
        fmt::format("{} states held negative values: of the size of the error if the model's solutions are positive; a smaller tolerance "
                    "makes them smaller, reaction_solver.positivity=reject-step refuses them",
                    summary.negatives));
  }
  return lines;
}

}  // namespace stiffront::app
