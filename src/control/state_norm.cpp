// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/state_norm.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "stiffront/control/method.hpp"
#include "stiffront/core/simd.hpp"
#include "stiffront/space/laplacian.hpp"

namespace stiffront {

StateNorm::StateNorm(const Decomposition& decomposition, const Boundary& boundary, int n_species, std::vector<int> species)
    : free_(boundary.free_box(decomposition)),
      points_(static_cast<double>(boundary.free_points(decomposition.grid()))),
      species_(std::move(species)) {
  if (species_.empty()) {
    species_.resize(static_cast<std::size_t>(n_species));
    std::iota(species_.begin(), species_.end(), 0);
  }
}

/// Adds the squares of value(species, i, j, load) over the cells; load reads a pack of a row, at its end what is left of it.
template <class Value>
void StateNorm::add_squares(int slot, Agreement& agreement, Value&& value) const {
  for (std::size_t k = 0; k < species_.size(); ++k) {
    ReproducibleSum& sum = agreement.sums[static_cast<std::size_t>(slot) * species_.size() + k];
    for (int j = free_.j_begin; j < free_.j_end; ++j) {
      for_each_pack(free_.i_begin, free_.i_end, [&](int i, int n) {
        if (n == pack_size) {
          const Pack d = value(species_[k], i, j, [](const double* p) { return Pack::load(p); });
          sum.add(d * d);
        } else {
          const Pack d = value(species_[k], i, j, [n](const double* p) { return Pack::load_partial(p, n); });
          sum.add(d * d, Mask::first(n));
        }
      });
    }
  }
}

void StateNorm::add_difference(const Field& a, const Field& b, int slot, Agreement& agreement) const {
  add_squares(
      slot, agreement, [&](int species, int i, int j, auto load) __attribute__((always_inline)) {
        return load(a.row(species, j) + i) - load(b.row(species, j) + i);
      });
}

void StateNorm::add_combination(std::span<const Term> terms, int slot, Agreement& agreement) const {
  add_squares(
      slot, agreement, [&](int species, int i, int j, auto load) __attribute__((always_inline)) {
        Pack sum(0.0);
        for (const Term& term : terms) sum = mul_add(Pack(term.factor), load(term.field->row(species, j) + i), sum);
        return sum;
      });
}

void StateNorm::add_scale(const Field& u, Agreement& agreement) const {
  for (std::size_t k = 0; k < species_.size(); ++k) {
    Pack largest(0.0);
    for (int j = 0; j < u.n_y(); ++j) {
      const double* p = u.row(species_[k], j);
      for_each_pack(0, u.n_x(), [&](int i, int n) { largest = max(abs(Pack::load_partial(p + i, n)), largest); });
    }
    agreement.maxima[k] = std::max(agreement.maxima[k], max_lane(largest));
  }
}

double StateNorm::value(int slot, int k, const Agreement& agreement) const {
  const auto n = static_cast<std::size_t>(k);
  const double sum = agreement.sums[static_cast<std::size_t>(slot) * species_.size() + n].value();
  const double floor = floors_.empty() ? 0.0 : floors_[static_cast<std::size_t>(species_[n])];
  const double largest = std::max(agreement.maxima[n], floor);
  const double scale = largest > 0.0 ? largest : 1.0;
  const double rms = std::sqrt(sum / points_) / scale;
  return rms < std::numeric_limits<double>::infinity() ? rms : std::numeric_limits<double>::quiet_NaN();
}

double StateNorm::value(int slot, const Agreement& agreement) const {
  double norm = 0.0;
  for (int k = 0; k < n_controlled(); ++k) {
    const double rms = value(slot, k, agreement);
    if (std::isnan(rms)) return rms;
    norm = std::max(norm, rms);
  }
  return norm;
}

std::uint64_t inspect(const Field& u, const FreeBox& box) {
  Pack bad(0.0);  // stays 0 unless something is not finite
  Pack smallest(0.0);
  for (int s = 0; s < u.n_species(); ++s) {
    for (int j = box.j_begin; j < box.j_end; ++j) {
      const double* p = u.row(s, j);
      for_each_pack(box.i_begin, box.i_end, [&](int i, int n) {
        const Pack x = Pack::load_partial(p + i, n);
        bad += x - x;
        smallest = min(smallest, x);
      });
    }
  }
  std::uint64_t flags = 0;
  if (!all(bad == Pack(0.0))) flags |= step_flags::not_finite;
  if (min_lane(smallest) < 0.0) flags |= step_flags::negative;
  return flags;
}

}  // namespace stiffront
