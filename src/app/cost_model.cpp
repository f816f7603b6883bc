// SPDX-License-Identifier: BSD-3-Clause
#include "cost_model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "stiffront/control/parallel_deferred_correction.hpp"
#include "stiffront/control/sbdf.hpp"
#include "stiffront/control/sbdf_tables.hpp"

namespace stiffront::app {
namespace {

// Of the tolerance asked for, what the methods are given: errors of runs may exceed those of steps.
constexpr double kept = 0.3;
// Below this a step of sdc sees nothing but rounding.
constexpr double least_sdc_tolerance = 2e-14;

// Counted on problem A. sbdf: 7433 steps where a step is held to 1e-9, like the power -1/6; its sweeps a step, and 1.5 + 0.35 k sweeps' worth
// of work on the history. Each step rounds by a quarter of a unit, and that adds up.
constexpr double sbdf_steps = 235.0;
constexpr double sbdf_overhead = 3.25;
constexpr double round_off_of_a_step = 0.25 * std::numeric_limits<double>::epsilon();

// sdc: 4603 steps at 1e-10 with four nodes and four sweeps, 3830 at 1e-11 with five and six, like the power -1/(k + L). A sweep of a node is
// worth 1.8 sweeps of sbdf.
struct SdcCount {
  int nodes;
  int corrections;
  double steps;
};
constexpr int sdc_starting_order = 3;
constexpr std::array<SdcCount, 2> sdc_counts{{{4, 4, 180.0}, {5, 6, 240.0}}};
constexpr double cost_of_node_sweep = 1.8;

double sdc_tolerance(double tolerance) { return std::max(kept * tolerance, least_sdc_tolerance); }

}  // namespace

PredictedWork predicted_sbdf(const AutoProblem& p) {
  constexpr int order = sbdf_max_order;
  PredictedWork work;
  work.steps = sbdf_steps * std::pow(sbdf_step_tolerance(kept * p.tolerance), -1.0 / 6.0);
  const double z = p.spectral_radius * p.span / work.steps;
  const auto enough = std::find_if(sbdf_sweep_counts.begin(), sbdf_sweep_counts.end(),
                                   [z](int s) { return z <= sbdf_z_safety(order) * sbdf_z_limit(order, s); });
  double sweeps = enough == sbdf_sweep_counts.end() ? sbdf_max_sweeps : *enough;
  const double coupled = p.dimension == 1 ? sbdf_line_cost(p.n_species) : sbdf_plane_cost(p.n_species);
  if (std::isfinite(coupled)) {
    sweeps = std::min(sweeps, coupled);
  } else if (enough == sbdf_sweep_counts.end()) {
    work.steps *= z / (sbdf_z_safety(order) * sbdf_z_limit(order, sbdf_max_sweeps));
  }
  work.sweeps = work.steps * (sweeps + sbdf_overhead);
  work.round_off = round_off_of_a_step * work.steps;
  return work;
}

PredictedWork predicted_sdc(const AutoProblem& p, int nodes) {
  const SdcCount& count = *std::find_if(sdc_counts.begin(), sdc_counts.end(), [nodes](const SdcCount& c) { return c.nodes == nodes; });
  PredictedWork work;
  const double exponent = -1.0 / (sdc_starting_order + count.corrections);
  work.steps = std::max(count.steps * std::pow(sdc_tolerance(p.tolerance), exponent),
                        p.spectral_radius * p.span / ParallelDeferredCorrection::stable_z);
  work.sweeps = work.steps * count.nodes * (1.0 + cost_of_node_sweep * count.corrections);
  work.round_off = round_off_of_a_step * work.steps;
  return work;
}

AutoChoice choose_method(const AutoProblem& p) {
  const PredictedWork sbdf = predicted_sbdf(p);
  PredictedWork sdc = predicted_sdc(p, sdc_counts[0].nodes);
  const SdcCount* count = &sdc_counts[0];
  for (const SdcCount& candidate : sdc_counts) {
    const PredictedWork work = predicted_sdc(p, candidate.nodes);
    if (work.sweeps < sdc.sweeps) {
      sdc = work;
      count = &candidate;
    }
  }
  const bool takes_sdc =
      sbdf.round_off <= p.tolerance ? sdc.round_off <= p.tolerance && sdc.sweeps < sbdf.sweeps : sdc.round_off < sbdf.round_off;
  AutoChoice choice;
  const std::string work =
      fmt::format("work of {:.2g} sweeps against {:.2g}", takes_sdc ? sdc.sweeps : sbdf.sweeps, takes_sdc ? sbdf.sweeps : sdc.sweeps);
  if (takes_sdc) {
    SdcOptions o;
    o.splitting = SdcSplitting::diagonal;
    o.node_count = count->nodes;
    o.corrections = count->corrections;
    o.starting_order = sdc_starting_order;
    o.tolerance = sdc_tolerance(p.tolerance);
    choice.reason = fmt::format(
        "method auto: sdc, {} nodes in parallel, {} sweeps, with tolerance = {:.3g}: {}", count->nodes, count->corrections, *o.tolerance,
        sbdf.round_off <= p.tolerance ? work + " of sbdf"
                                      : fmt::format("rounding in some {:.2g} steps of sbdf leaves about {:.1g}, in {:.2g} of sdc {:.1g}",
                                                    sbdf.steps, sbdf.round_off, sdc.steps, sdc.round_off));
    choice.method = std::move(o);
  } else {
    SbdfOptions o;
    o.relative_tolerance = kept * p.tolerance;
    choice.reason = fmt::format("method auto: sbdf with relative_tolerance = {:.3g}: {}", o.relative_tolerance,
                                sdc.round_off <= p.tolerance || sbdf.round_off <= p.tolerance
                                    ? work + " of sdc"
                                    : fmt::format("rounding leaves about {:.1g}, in sdc {:.1g}", sbdf.round_off, sdc.round_off));
    choice.method = std::move(o);
  }
  return choice;
}

}  // namespace stiffront::app
