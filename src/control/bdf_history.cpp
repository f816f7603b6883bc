// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/bdf_history.hpp"

#include <algorithm>
#include <utility>

#include "stiffront/core/unroll.hpp"

namespace stiffront {
namespace {

/// Calls f(i, n, fresh) for the packs of a row. A row of at least a pack ends with a full pack that overlaps the one
/// before; `fresh` are the lanes not seen before.
template <class F>
void for_each_overlapping_pack(int i_begin, int i_end, F&& f) {
  int i = i_begin;
  for (; i + pack_size <= i_end; i += pack_size) f(i, pack_size, Mask(true));
  if (i == i_end) return;
  if (i_end - i_begin < pack_size) {
    f(i, i_end - i, Mask::first(i_end - i));
  } else {
    f(i_end - pack_size, pack_size, !Mask::first(pack_size - (i_end - i)));
  }
}

Pack load(const double* p, int n) { return n == pack_size ? Pack::load(p) : Pack::load_partial(p, n); }
void store(Pack x, double* p, int n) { n == pack_size ? x.store(p) : x.store_partial(p, n); }

template <int points>
void combine(std::span<const Field* const> states, const BdfWeights& e, const BdfWeights& w, Field& predictor,
             Field& right_side, const FreeBox& box) {
  for (int s = 0; s < predictor.n_species(); ++s) {
    for (int j = box.j_begin; j < box.j_end; ++j) {
      const double* v[points];
      for (std::size_t k = 0; k < points; ++k) v[k] = states[k]->row(s, j);
      double* p = predictor.row(s, j);
      double* r = right_side.row(s, j);
      for_each_overlapping_pack(box.i_begin, box.i_end, [&](int i, int n, Mask) {
        Pack x = load(v[0] + i, n);
        Pack p_sum = Pack(e[0]) * x;
        Pack r_sum = Pack(w[0]) * x;
        for (std::size_t k = 1; k < points; ++k) {
          x = load(v[k] + i, n);
          p_sum = mul_add(Pack(e[k]), x, p_sum);
          r_sum = mul_add(Pack(w[k]), x, r_sum);
        }
        store(p_sum, p + i, n);
        store(r_sum, r + i, n);
      });
    }
  }
}

}  // namespace

void bdf_combine(std::span<const Field* const> states, const BdfWeights& e, const BdfWeights& w, Field& predictor,
                 Field& right_side, const FreeBox& box) {
  switch (states.size()) {
    case 1:
      return combine<1>(states, e, w, predictor, right_side, box);
    case 2:
      return combine<2>(states, e, w, predictor, right_side, box);
    case 3:
      return combine<3>(states, e, w, predictor, right_side, box);
    case 4:
      return combine<4>(states, e, w, predictor, right_side, box);
    case 5:
      return combine<5>(states, e, w, predictor, right_side, box);
    default:
      return combine<6>(states, e, w, predictor, right_side, box);
  }
}

bool bdf_add_difference(const Field& v, const Field& reference, const BdfTolerances& tolerances, const FreeBox& box,
                        ReproducibleSum& sum) {
  const Pack relative(tolerances.relative);
  Pack smallest(0.0);
  const int n_species = v.n_species();
  const std::ptrdiff_t stride = v.species_stride();
  for (int j = box.j_begin; j < box.j_end; ++j) {
    const double* v_row = v.row(0, j);
    const double* r_row = reference.row(0, j);
    for_each_overlapping_pack(box.i_begin, box.i_end, [&](int i, int n, Mask fresh) {
      Pack squares(0.0);
      for (int s = 0; s < n_species; ++s) {
        const Pack x = load(v_row + s * stride + i, n);
        const Pack scale = mul_add(relative, abs(x), Pack(tolerances.absolute[static_cast<std::size_t>(s)]));
        const Pack scaled = (x - load(r_row + s * stride + i, n)) / scale;
        squares = mul_add(scaled, scaled, squares);
        smallest = min(smallest, x);
      }
      sum.add(squares * squares, fresh);
    });
  }
  return min_lane(smallest) < 0.0;
}

namespace {

template <std::size_t points>
void add_order_differences(const Field& v, const Field& predictor, std::span<const Field* const> states,
                           const BdfWeights& lower, const BdfWeights& upper, const BdfTolerances& tolerances,
                           const FreeBox& box, BdfOrderSums& sums, std::span<double> extremes) {
  const Pack relative(tolerances.relative);
  const auto n_species = static_cast<std::size_t>(v.n_species());
  const std::ptrdiff_t stride = v.species_stride();
  for (int j = box.j_begin; j < box.j_end; ++j) {
    const double* v_row = v.row(0, j);
    const double* p_row = predictor.row(0, j);
    const double* state_row[points];
    for (std::size_t k = 0; k < points; ++k) state_row[k] = states[k]->row(0, j);
    for_each_overlapping_pack(box.i_begin, box.i_end, [&](int i, int n, Mask fresh) {
      Pack low(0.0);
      Pack same(0.0);
      Pack high(0.0);
      for (std::size_t s = 0; s < n_species; ++s) {
        const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(s) * stride + i;
        const Pack x = load(v_row + at, n);
        Pack to_lower = x;
        Pack to_upper = x;
        for (std::size_t k = 0; k < points; ++k) {
          const Pack y = load(state_row[k] + at, n);
          to_lower = neg_mul_add(Pack(lower[k]), y, to_lower);
          to_upper = neg_mul_add(Pack(upper[k]), y, to_upper);
        }
        const Pack scale = mul_add(relative, abs(x), Pack(tolerances.absolute[s]));
        const Pack to_same = (x - load(p_row + at, n)) / scale;
        to_lower /= scale;
        to_upper /= scale;
        low = mul_add(to_lower, to_lower, low);
        same = mul_add(to_same, to_same, same);
        high = mul_add(to_upper, to_upper, high);
        extremes[s] = std::max(extremes[s], max_lane(x));
        extremes[n_species + s] = std::max(extremes[n_species + s], max_lane(-x));
      }
      sums.lower.add(low * low, fresh);
      sums.same.add(same * same, fresh);
      sums.upper.add(high * high, fresh);
    });
  }
}

}  // namespace

void bdf_add_order_differences(const Field& v, const Field& predictor, std::span<const Field* const> states,
                               const BdfWeights& lower, const BdfWeights& upper, const BdfTolerances& tolerances,
                               const FreeBox& box, BdfOrderSums& sums, std::span<double> extremes) {
  const auto add = [&]<std::size_t points>() {
    add_order_differences<points>(v, predictor, states, lower, upper, tolerances, box, sums, extremes);
  };
  switch (states.size()) {
    case 1:
      return add.template operator()<1>();
    case 2:
      return add.template operator()<2>();
    case 3:
      return add.template operator()<3>();
    case 4:
      return add.template operator()<4>();
    case 5:
      return add.template operator()<5>();
    default:
      return add.template operator()<6>();
  }
}

}  // namespace stiffront
