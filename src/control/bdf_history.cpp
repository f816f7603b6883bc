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
void combine(std::span<const Field* const> states, const BdfWeights& e, const BdfWeights& w, const Rows& predictor,
             const Rows& right_side, const FreeBox& box, int shift) {
  // In registers: what is reached through a reference would be read again after every store.
  Pack to_predictor[points];
  Pack to_right_side[points];
  for (std::size_t k = 0; k < points; ++k) {
    to_predictor[k] = Pack(e[k]);
    to_right_side[k] = Pack(w[k]);
  }
  for (int s = 0; s < states[0]->n_species(); ++s) {
    for (int j = box.j_begin; j < box.j_end; ++j) {
      const double* v[points];
      for (std::size_t k = 0; k < points; ++k) v[k] = states[k]->row(s, j + shift);
      double* const p = predictor.row(s, j);
      double* const r = right_side.row(s, j);
      for_each_overlapping_pack(box.i_begin, box.i_end, [&](int i, int n, Mask) __attribute__((always_inline)) {
        Pack x = load(v[0] + i, n);
        Pack p_sum = to_predictor[0] * x;
        Pack r_sum = to_right_side[0] * x;
        for (std::size_t k = 1; k < points; ++k) {
          x = load(v[k] + i, n);
          p_sum = mul_add(to_predictor[k], x, p_sum);
          r_sum = mul_add(to_right_side[k], x, r_sum);
        }
        store(p_sum, p + i, n);
        store(r_sum, r + i, n);
      });
    }
  }
}

}  // namespace

void bdf_combine(std::span<const Field* const> states, const BdfWeights& e, const BdfWeights& w, const Rows& predictor,
                 const Rows& right_side, const FreeBox& box, int shift) {
  switch (states.size()) {
    case 1:
      return combine<1>(states, e, w, predictor, right_side, box, shift);
    case 2:
      return combine<2>(states, e, w, predictor, right_side, box, shift);
    case 3:
      return combine<3>(states, e, w, predictor, right_side, box, shift);
    case 4:
      return combine<4>(states, e, w, predictor, right_side, box, shift);
    case 5:
      return combine<5>(states, e, w, predictor, right_side, box, shift);
    default:
      return combine<6>(states, e, w, predictor, right_side, box, shift);
  }
}

bool bdf_add_difference(const Field& v, const ConstRows& reference, const BdfTolerances& tolerances, const FreeBox& box,
                        ReproducibleSum& sum) {
  const Pack relative(tolerances.relative);
  const int n_species = v.n_species();
  const double* const absolute = tolerances.absolute.data();
  const std::ptrdiff_t stride = v.species_stride();
  const std::ptrdiff_t r_stride = reference.species_stride;
  Pack smallest(0.0);
  ReproducibleSum total = sum;
  for (int j = box.j_begin; j < box.j_end; ++j) {
    const double* v_row = v.row(0, j);
    const double* r_row = reference.row(0, j);
    for_each_overlapping_pack(box.i_begin, box.i_end, [&](int i, int n, Mask fresh) __attribute__((always_inline)) {
      Pack squares(0.0);
      for (int s = 0; s < n_species; ++s) {
        const Pack x = load(v_row + s * stride + i, n);
        const Pack scale = mul_add(relative, abs(x), Pack(absolute[s]));
        const Pack scaled = (x - load(r_row + s * r_stride + i, n)) / scale;
        squares = mul_add(scaled, scaled, squares);
        smallest = min(smallest, x);
      }
      total.add(squares * squares, fresh);
    });
  }
  sum = total;
  return min_lane(smallest) < 0.0;
}

namespace {

template <bool with_upper>
void add_order_differences(const Field& v, const BdfPredictors& predictors, const BdfTolerances& tolerances, const FreeBox& box,
                           const BdfOrderSums& sums, std::span<Pack> extremes) {
  const Pack relative(tolerances.relative);
  const int n_species = v.n_species();
  const double* const absolute = tolerances.absolute.data();
  Pack* const largest = extremes.data();
  const std::ptrdiff_t stride = v.species_stride();
  ReproducibleSum total_lower = sums.lower;
  ReproducibleSum total = sums.same;
  ReproducibleSum total_upper = sums.upper;
  for (int j = box.j_begin; j < box.j_end; ++j) {
    const double* const v_row = v.row(0, j);
    const double* const same_row = predictors.same.row(0, j);
    const double* const lower_row = predictors.lower.row(0, j);
    const double* const upper_row = with_upper ? predictors.upper.row(0, j) : nullptr;
    for_each_overlapping_pack(box.i_begin, box.i_end, [&](int i, int n, Mask fresh) __attribute__((always_inline)) {
      Pack low(0.0);
      Pack same(0.0);
      Pack high(0.0);
      for (int s = 0; s < n_species; ++s) {
        const Pack x = load(v_row + s * stride + i, n);
        const Pack scale = Pack(1.0) / mul_add(relative, abs(x), Pack(absolute[s]));
        const auto add = [&](const double* row, std::ptrdiff_t row_stride, Pack& squares) __attribute__((always_inline)) {
          const Pack off = (x - load(row + s * row_stride + i, n)) * scale;
          squares = mul_add(off, off, squares);
        };
        add(lower_row, predictors.lower.species_stride, low);
        add(same_row, predictors.same.species_stride, same);
        if constexpr (with_upper) add(upper_row, predictors.upper.species_stride, high);
        largest[s] = max(largest[s], x);
        largest[n_species + s] = max(largest[n_species + s], -x);
      }
      total_lower.add(low * low, fresh);
      total.add(same * same, fresh);
      if constexpr (with_upper) total_upper.add(high * high, fresh);
    });
  }
  sums.lower = total_lower;
  sums.same = total;
  sums.upper = total_upper;
}

}  // namespace

void bdf_add_order_differences(const Field& v, const BdfPredictors& predictors, bool with_upper, const BdfTolerances& tolerances,
                               const FreeBox& box, const BdfOrderSums& sums, std::span<Pack> extremes) {
  with_upper ? add_order_differences<true>(v, predictors, tolerances, box, sums, extremes)
             : add_order_differences<false>(v, predictors, tolerances, box, sums, extremes);
}

}  // namespace stiffront
