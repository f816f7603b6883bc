// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/absent_species.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "stiffront/core/simd.hpp"
#include "stiffront/space/laplacian.hpp"

namespace stiffront {
namespace {

constexpr double absent = 1e-12;  // relative to the largest species
constexpr double floor_factor = 1e-2;
constexpr double look_ahead = 1e-2;  // of the interval
constexpr int fewest_steps = 3;
constexpr double growth = 4.0;

/// Largest modulus of every species on all ranks. @return whether all ranks are well
bool largest_moduli(const Field& u, bool well, const Communicator& comm, std::vector<double>& largest) {
  Agreement agreement(0, u.n_species());
  for (int s = 0; s < u.n_species(); ++s) {
    Pack m(0.0);
    for (int j = 0; j < u.n_y(); ++j) {
      const double* p = u.row(s, j);
      for_each_pack(0, u.n_x(), [&](int i, int n) { m = max(abs(Pack::load_partial(p + i, n)), m); });
    }
    agreement.maxima[static_cast<std::size_t>(s)] = max_lane(m);
  }
  agreement.flags = well ? 0U : 1U;
  comm.agree(agreement);
  largest = agreement.maxima;
  return agreement.flags == 0 && std::all_of(largest.begin(), largest.end(), [](double x) { return std::isfinite(x); });
}

}  // namespace

std::vector<double> floors_of_absent_species(const SplitFlows& flows, double t, double t_end, double first, Field& u,
                                             const Communicator& comm, Work& work) {
  std::vector<double> now;
  std::vector<double> floors(static_cast<std::size_t>(u.n_species()), 0.0);
  if (!largest_moduli(u, true, comm, now)) return floors;
  const double missing = absent * *std::max_element(now.begin(), now.end());
  if (std::none_of(now.begin(), now.end(), [&](double x) { return x <= missing; })) return floors;

  Field ahead = u.similar();
  ahead.copy_interior(u);
  const Composition composition = lie(SplittingOrder::reaction_last);
  const double horizon = t + look_ahead * (t_end - t);
  double time = t;
  double step = first;
  for (int n = 0; time < t_end && (n < fewest_steps || time < horizon); ++n) {
    const double dt = std::min(step, t_end - time);
    const bool well = !stiffront::advance(flows, composition, time, dt, ahead, ahead, work);
    std::vector<double> then;
    if (!largest_moduli(ahead, well, comm, then)) break;
    for (std::size_t s = 0; s < floors.size(); ++s) {
      if (now[s] <= missing) floors[s] = std::max(floors[s], floor_factor * then[s]);
    }
    time += dt;
    step *= growth;
  }
  return floors;
}

}  // namespace stiffront
