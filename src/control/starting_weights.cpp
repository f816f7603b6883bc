// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/starting_weights.hpp"

#include "stiffront/control/lagrange.hpp"

namespace stiffront {

StartingWeights starting_weights(double t, std::span<const double> past) {
  // In units of the last step, so that products of differences stay near one.
  const double unit = t - past[0];
  std::vector<double> x;
  for (double s : past) x.push_back((s - t) / unit);
  StartingWeights w;
  w.extrapolation = lagrange(x, 0.0);
  double d0 = 0.0;
  for (const double at : x) d0 -= 1.0 / at;
  w.h = unit / d0;
  for (std::size_t j = 0; j < x.size(); ++j) {
    const double d = w.extrapolation[j] / x[j];  // the Lagrange polynomial of s_j on all points has this slope at t
    w.states.push_back(-d / d0 - w.extrapolation[j]);
  }
  return w;
}

}  // namespace stiffront
