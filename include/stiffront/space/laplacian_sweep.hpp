// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstddef>
#include <utility>

#include "stiffront/core/simd.hpp"
#include "stiffront/mesh/boundary.hpp"
#include "stiffront/mesh/field.hpp"
#include "stiffront/space/laplacian.hpp"

namespace stiffront {

/// Every lane of a pack is a point of the tile.
struct AllLanes {
  void store(Pack x, double* to) const { x.store(to); }
  Pack or_zero(Pack x) const { return x; }
};

/// Some lanes are points of the tile, the others must not be written.
struct SomeLanes {
  Mask mask;
  void store(Pack x, double* to) const { store_lanes(x, to, mask); }
  Pack or_zero(Pack x) const { return select(mask, x, Pack(0.0)); }
};

namespace detail {

/// Rows neighbouring rows of a tile, swept together.
template <int Rows, int Order, int Dimension, class Row>
class RowBlock {
 public:
  RowBlock(const Laplacian<Order, Dimension>& laplacian, const double* first_row, std::array<Row, Rows> rows)
      : stride_(laplacian.row_stride), k_x_(laplacian.k_x), k_y_(laplacian.k_y), first_row_(first_row), rows_(rows) {}

  [[gnu::always_inline]] void sweep(int i_begin, int i_end) {
    int i = i_begin & -pack_size;  // rounded down, also in the halo
    for (int r = 0; r < Rows; ++r) {
      before_[r] = Pack::load(first_row_ + r * stride_ + i - pack_size);
      centre_[r] = Pack::load(first_row_ + r * stride_ + i);
    }
    const auto lanes_of = [=](int at) { return SomeLanes{Mask::first(i_end - at) & !Mask::first(i_begin - at)}; };
    if (i < i_begin) {
      visit(i, lanes_of(i));
      i += pack_size;
    }
    for (; i + pack_size <= i_end; i += pack_size) visit(i, AllLanes{});
    if (i < i_end) visit(i, lanes_of(i));
  }

 private:
  static constexpr int width = Order / 2;

  template <class Lanes>
  [[gnu::always_inline]] void visit(int i, const Lanes& lanes) {
    const double* const u = first_row_ + i;
    // The column of packs through the rows: those above and below from memory, the rows' own from registers.
    Pack column[Rows + 2 * width];
    if constexpr (Dimension == 2) {
      for (int k = 0; k < width; ++k) {
        column[k] = Pack::load(u + (k - width) * stride_);
        column[width + Rows + k] = Pack::load(u + (Rows + k) * stride_);
      }
      for (int r = 0; r < Rows; ++r) {
        column[width + r] = centre_[r];
        // The rows that come next: the processor does not foresee them.
        __builtin_prefetch(u + (r + Rows + width) * stride_);
      }
    }
#pragma GCC unroll 4
    for (int r = 0; r < Rows; ++r) {
      const Pack x = centre_[r];
      const Pack after = Pack::load(u + r * stride_ + pack_size);
      const Pack* const c = column + r + width;
      Pack f = Pack(k_x_) * second_difference<Order>(x, shifted<-1>(before_[r], x, after), shifted<1>(before_[r], x, after),
                                                     shifted<-width>(before_[r], x, after), shifted<width>(before_[r], x, after));
      if constexpr (Dimension == 2) f = f + Pack(k_y_) * second_difference<Order>(x, c[-1], c[1], c[-width], c[width]);
      if constexpr (Dimension == 2) rows_[static_cast<std::size_t>(r)].prefetch(i, Rows * stride_);
      rows_[static_cast<std::size_t>(r)](i, lanes, x, f);
      before_[r] = x;
      centre_[r] = after;
    }
  }

  /// The pack that begins `by` points after x.
  template <int by>
  static Pack shifted(Pack before, Pack x, Pack after) {
    if constexpr (by == -pack_size) {
      return before;
    } else if constexpr (by == pack_size) {
      return after;
    } else if constexpr (by < 0) {
      return straddle<pack_size + by>(before, x);
    } else {
      return straddle<by>(x, after);
    }
  }

  std::ptrdiff_t stride_;
  double k_x_, k_y_;
  const double* first_row_;
  std::array<Row, Rows> rows_;
  Pack before_[Rows], centre_[Rows];
};

template <int Order, int Dimension, class OnRow, int... r>
[[gnu::always_inline]] inline void sweep_rows(const Laplacian<Order, Dimension>& laplacian, const Field& u, int species,
                                              const FreeBox& tile, int j, OnRow& on_row, std::integer_sequence<int, r...>) {
  const std::array rows{on_row(j + r)...};
  RowBlock<sizeof...(r), Order, Dimension, typename decltype(rows)::value_type> block(laplacian, u.row(species, j), rows);
  block.sweep(tile.i_begin, tile.i_end);
}

}  // namespace detail

/// Visits the points of a tile with u and D Laplacian(u), at about the speed at which memory delivers u.
///
/// on_row(j) returns an object for row j with two members: operator()(i, lanes, x, f), called for the aligned packs
/// along the row with the values x = u, f = D Laplacian(u) at points i .. i + pack_size - 1 and lanes = AllLanes or
/// SomeLanes, through which everything must be written; and prefetch(i, ahead), which may ask for data of the row
/// `ahead` doubles later. u itself must not be written. Bits are those of Laplacian::operator(), whatever the tile.
/// @pre halos of u are up to date; tile is not empty
template <int Order, int Dimension, class OnRow>
void sweep(const Laplacian<Order, Dimension>& laplacian, const Field& u, int species, const FreeBox& tile, OnRow&& on_row) {
  // Packs straddling two loaded ones come from registers, and several rows share the loads of the wider stencil's
  // column: that halves the time where the data are in cache. Measured optima.
  constexpr int rows = Dimension == 2 && Order == 4 ? 4 : 1;
  int j = tile.j_begin;
  for (; j + rows <= tile.j_end; j += rows) {
    detail::sweep_rows(laplacian, u, species, tile, j, on_row, std::make_integer_sequence<int, rows>());
  }
  if constexpr (rows > 1) {
    for (; j < tile.j_end; ++j) detail::sweep_rows(laplacian, u, species, tile, j, on_row, std::make_integer_sequence<int, 1>());
  }
}

/// The same for values f that have been computed, D Laplacian(u) of an order that has no fused kernels.
template <class OnRow>
void sweep_values(const Field& u, const Field& f, int species, const FreeBox& tile, OnRow&& on_row) {
  for (int j = tile.j_begin; j < tile.j_end; ++j) {
    const auto row = on_row(j);
    const double* const x = u.row(species, j);
    const double* const value = f.row(species, j);
    for (int i = tile.i_begin / pack_size * pack_size; i < tile.i_end; i += pack_size) {
      if (i >= tile.i_begin && i + pack_size <= tile.i_end) {
        row(i, AllLanes{}, Pack::load(x + i), Pack::load(value + i));
      } else {
        row(i, SomeLanes{Mask::first(tile.i_end - i) & !Mask::first(tile.i_begin - i)}, Pack::load(x + i), Pack::load(value + i));
      }
    }
  }
}

}  // namespace stiffront
