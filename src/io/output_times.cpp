// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/io/output_times.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stiffront {

bool OutputTimes::same(double a, double b) const {
  return std::abs(a - b) <= 4.0 * std::numeric_limits<double>::epsilon() * std::max({std::abs(start), std::abs(end), end - start});
}

std::vector<double> OutputTimes::in(double from, double to) const {
  std::vector<double> r(std::lower_bound(times.begin(), times.end(), from), std::upper_bound(times.begin(), times.end(), to));
  if (every > 0.0) {
    const auto listed = static_cast<std::ptrdiff_t>(r.size());
    for (double k = std::max(1.0, std::floor((from - start) / every)); start + k * every <= to; k += 1.0) {
      if (start + k * every >= from) r.push_back(start + k * every);
    }
    std::inplace_merge(r.begin(), r.begin() + listed, r.end());
  }
  r.erase(std::unique(r.begin(), r.end(), [this](double a, double b) { return same(a, b); }), r.end());
  return r;
}

std::vector<double> OutputTimes::inner() const { return between(start, end); }

std::vector<double> OutputTimes::between(double t, double t_new) const {
  std::vector<double> r = in(t, t_new);
  std::erase_if(r, [&](double time) { return same(time, t) || same(time, t_new); });
  return r;
}

bool OutputTimes::due_at(double t_new, std::int64_t accepted) const {
  if (t_new >= end || (steps > 0 && accepted % steps == 0)) return true;
  const double little = 8.0 * std::numeric_limits<double>::epsilon() * std::max({std::abs(start), std::abs(end), end - start});
  const std::vector<double> near = in(t_new - little, t_new + little);
  return std::any_of(near.begin(), near.end(), [&](double time) { return same(time, t_new); });
}

}  // namespace stiffront
