// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/starting_weights.hpp"

namespace stiffront {

StartingWeights starting_weights(double t, std::span<const double> past) {
  // In units of the last step, so that products of differences stay near one.
  const double unit = t - past[0];
  std::vector<double> x;
  for (double s : past) x.push_back((s - t) / unit);
  StartingWeights w;
  double d0 = 0.0;
  std::vector<double> d;
  for (std::size_t j = 0; j < x.size(); ++j) {
    double e = 1.0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      if (i != j) e *= -x[i] / (x[j] - x[i]);
    }
    w.extrapolation.push_back(e);
    d.push_back(e / x[j]);  // the Lagrange polynomial of s_j on all points has this slope at t
    d0 -= 1.0 / x[j];
  }
  w.h = unit / d0;
  for (std::size_t j = 0; j < x.size(); ++j) w.states.push_back(-d[j] / d0 - w.extrapolation[j]);
  return w;
}

}  // namespace stiffront
