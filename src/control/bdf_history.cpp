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
void combine(std::span<const Field* const> states, const BdfWeights& e, const BdfWeights& w, const Rows& predictor, const Rows& right_side,
             const FreeBox& box, int shift) {
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
      for_each_overlapping_pack(
          box.i_begin, box.i_end, [&](int i, int n, Mask) __attribute__((always_inline)) {
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

namespace {

/// Terms are made a block of packs at a time, a species or three of them after the other: what a loop over packs needs then is in
/// registers, and a sum takes many terms at less cost than one.
constexpr int block_size = 16;

template <int n_references>
struct Block {
  Pack squares[n_references][block_size];
};

/// Adds the squares of (v - reference)/(absolute + relative |v|) of some species to those of a block. The species share a
/// division: three would take longer than all the rest. Their scales may be from 1e-100 to 1e100.
/// @param v, references, absolute, largest, smallest  of the first of the species; the others follow
/// @tparam whole whether the packs are; else there is one, of a row with fewer cells
template <int n_references, int species, bool whole>
void add_squares(Block<n_references>& block, int packs, int cells, const double* v, std::ptrdiff_t v_stride,
                 const std::array<const double*, n_references>& references, const std::array<std::ptrdiff_t, n_references>& strides,
                 double relative, const double* absolute, Pack* extremes, std::ptrdiff_t n_species) {
  const double* value[species];
  const double* reference[n_references][species];
  Pack floor[species];
  Pack largest[species];
  Pack smallest[species];
  unroll<species>([&](auto s) __attribute__((always_inline)) {
    value[s] = v + s * v_stride;
    for (std::size_t r = 0; r < n_references; ++r) reference[r][s] = references[r] + s * strides[r];
    floor[s] = Pack(absolute[s]);
    largest[s] = extremes[s];
    smallest[s] = -extremes[n_species + s];
  });
  const Pack slope(relative);
  const auto read = [&](const double* p) __attribute__((always_inline)) { return whole ? Pack::load(p) : Pack::load_partial(p, cells); };
  for (int q = 0; q < packs; ++q) {
    const int i = q * pack_size;
    Pack x[species];
    Pack scale[species];
    unroll<species>([&](auto s) __attribute__((always_inline)) {
      x[s] = read(value[s] + i);
      largest[s] = max(largest[s], x[s]);
      smallest[s] = min(smallest[s], x[s]);
      scale[s] = mul_add(slope, abs(x[s]), floor[s]);
    });
    Pack inverse[species];
    if constexpr (species == 1) {
      inverse[0] = Pack(1.0) / scale[0];
    } else if constexpr (species == 2) {
      const Pack all = Pack(1.0) / (scale[0] * scale[1]);
      inverse[0] = scale[1] * all;
      inverse[1] = scale[0] * all;
    } else {
      const Pack first_two = scale[0] * scale[1];
      const Pack all = Pack(1.0) / (first_two * scale[2]);
      inverse[0] = scale[1] * scale[2] * all;
      inverse[1] = scale[0] * scale[2] * all;
      inverse[2] = first_two * all;
    }
    unroll<n_references>([&](auto r) __attribute__((always_inline)) {
      Pack sum = block.squares[r][q];
      unroll<species>([&](auto s) __attribute__((always_inline)) {
        const Pack off = (x[s] - read(reference[r][s] + i)) * inverse[s];
        sum = mul_add(off, off, sum);
      });
      block.squares[r][q] = sum;
    });
  }
  unroll<species>([&](auto s) __attribute__((always_inline)) {
    extremes[s] = largest[s];
    extremes[n_species + s] = -smallest[s];
  });
}

template <std::size_t n>
void add_differences(const Field& v, std::span<const ConstRows> references, const BdfTolerances& tolerances, const FreeBox& box,
                     std::span<ReproducibleSum> sums, std::span<Pack> extremes) {
  const auto n_species = static_cast<int>(tolerances.absolute.size());
  std::array<std::ptrdiff_t, n> strides;
  for (std::size_t r = 0; r < n; ++r) strides[r] = references[r].species_stride;
  Block<n> block;
  for (int j = box.j_begin; j < box.j_end; ++j) {
    const double* const row = v.row(0, j);
    std::array<const double*, n> reference_row;
    for (std::size_t r = 0; r < n; ++r) reference_row[r] = references[r].row(0, j);
    const auto add = [&](int i, int packs, int cells, Mask fresh) {
      for (auto& squares : block.squares) std::fill_n(squares, packs, Pack(0.0));
      for (int s = 0; s < n_species; s += 3) {
        std::array<const double*, n> at;
        for (std::size_t r = 0; r < n; ++r) at[r] = reference_row[r] + s * strides[r] + i;
        const auto add_species = [&]<int species>(std::integral_constant<int, species>) {
          constexpr auto n_references = static_cast<int>(n);
          const auto squares_of = cells == pack_size ? add_squares<n_references, species, true> : add_squares<n_references, species, false>;
          squares_of(block, packs, cells, row + s * v.species_stride() + i, v.species_stride(), at, strides, tolerances.relative,
                     &tolerances.absolute[static_cast<std::size_t>(s)], &extremes[static_cast<std::size_t>(s)], n_species);
        };
        switch (n_species - s) {
          case 1:
            add_species(std::integral_constant<int, 1>());
            break;
          case 2:
            add_species(std::integral_constant<int, 2>());
            break;
          default:
            add_species(std::integral_constant<int, 3>());
        }
      }
      for (std::size_t r = 0; r < n; ++r) {
        Pack* const squares = block.squares[r];
        for (int q = 0; q < packs; ++q) squares[q] = select(fresh, squares[q] * squares[q], Pack(0.0));
        sums[r].add(std::span(squares, static_cast<std::size_t>(packs)));
      }
    };
    const int full = (box.i_end - box.i_begin) / pack_size;
    const int rest = (box.i_end - box.i_begin) % pack_size;
    for (int q = 0; q < full; q += block_size) add(box.i_begin + q * pack_size, std::min(block_size, full - q), pack_size, Mask(true));
    if (rest == 0) continue;
    if (full == 0) {
      add(box.i_begin, 1, rest, Mask::first(rest));
    } else {
      add(box.i_end - pack_size, 1, pack_size, !Mask::first(pack_size - rest));
    }
  }
}

}  // namespace

void bdf_add_differences(const Field& v, std::span<const ConstRows> references, const BdfTolerances& tolerances, const FreeBox& box,
                         std::span<ReproducibleSum> sums, std::span<Pack> extremes) {
  switch (references.size()) {
    case 1:
      return add_differences<1>(v, references, tolerances, box, sums, extremes);
    case 2:
      return add_differences<2>(v, references, tolerances, box, sums, extremes);
    default:
      return add_differences<3>(v, references, tolerances, box, sums, extremes);
  }
}

}  // namespace stiffront
