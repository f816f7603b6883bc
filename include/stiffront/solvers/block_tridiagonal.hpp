// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstddef>
#include <cstring>
#include <utility>
#include <vector>

#include "stiffront/core/aligned_array.hpp"
#include "stiffront/core/mpi.hpp"
#include "stiffront/core/simd.hpp"
#include "stiffront/mesh/decomposition.hpp"
#include "stiffront/solvers/cell_solve.hpp"

namespace stiffront {

namespace block_tridiagonal {

/// Zeros on 64-byte lines: `components` arrays of `n` numbers each, readable and writable for a pack before them and
/// three packs beyond their end.
class RowArrays {
 public:
  RowArrays() = default;
  RowArrays(int components, int n) : stride_((n + pack_size - 1) / pack_size * pack_size + 4 * pack_size) {
    data_ = aligned_zeros(static_cast<std::size_t>(components) * static_cast<std::size_t>(stride_));
  }
  double* operator()(int component) const { return data_.get() + component * stride_ + pack_size; }

 private:
  std::ptrdiff_t stride_ = 0;
  AlignedArray data_;
};

/// p[0], p[2], p[4] ...
inline Pack load_every_second(const double* p) {
  const Pack lo = Pack::load(p);
  const Pack hi = Pack::load(p + pack_size);
  return [&]<int... lane>(std::integer_sequence<int, lane...>) {
    return Pack(static_cast<Pack::Vector>(__builtin_shufflevector(lo.v, hi.v, (2 * lane)...)));
  }
  (std::make_integer_sequence<int, pack_size>());
}
/// first[0], second[0], first[1], second[1] ...
inline void store_in_turn(Pack first, Pack second, double* p) {
  [&]<int... lane>(std::integer_sequence<int, lane...>) {
    constexpr int half = pack_size / 2;
    const Pack lo(static_cast<Pack::Vector>(__builtin_shufflevector(first.v, second.v, (lane / 2 + (lane % 2) * pack_size)...)));
    const Pack hi(static_cast<Pack::Vector>(__builtin_shufflevector(first.v, second.v, (half + lane / 2 + (lane % 2) * pack_size)...)));
    lo.store(p);
    hi.store(p + pack_size);
  }
  (std::make_integer_sequence<int, pack_size>());
}

/// A side of this rank's rows at one level where a row of another rank (or, in a ring on one rank, of its own other
/// end) is next. One of the two rows is odd.
struct Edge {
  int partner = -1;  ///< its rank; -1: there is no such row, or none that matters
  bool mine_is_odd = false;
};

/// The rows of one level: those of level l are the points whose global index is a multiple of 2^l.
struct Level {
  int n_global = 0;
  int begin = 0;  ///< this rank's rows
  int end = 0;
  int n_odd = 0;
  std::array<Edge, 2> edges;  ///< left, right

  int n() const { return end - begin; }
  bool begins_odd() const { return begin % 2 != 0; }
  int first_odd() const { return begins_odd() ? 0 : 1; }   ///< local index
  int first_even() const { return begins_odd() ? 1 : 0; }  ///< local index
};

/// The levels down to a single row. From level `gathered` on, every rank has all rows.
struct Levels {
  Levels(const Decomposition& d, bool periodic, int gather_at_most);
  std::vector<Level> levels;
  std::size_t gathered = 0;
  std::vector<std::array<int, 2>> owned_at_gathering;  ///< first row and number of rows of each rank there
};

/// Sends rows over the edges of one level and receives others, of `width` numbers each.
class EdgeMessages {
 public:
  EdgeMessages(const Communicator& comm, int largest_width);
  double* outgoing(std::size_t side) { return out_[side].data(); }
  const double* incoming(std::size_t side) const { return in_[side].data(); }
  /// @param odd_sends the odd side of an edge sends and the even side receives; or the other way round
  void exchange(const Level& level, bool odd_sends, int width);

 private:
  const Communicator* comm_;
  std::array<std::vector<double>, 2> out_;
  std::array<std::vector<double>, 2> in_;
};

}  // namespace block_tridiagonal

/// Block-tridiagonal systems along the points of a line that is shared by the ranks: for each point i, with m x m
/// blocks,
///
///     diag(lower_i) x_{i-1} + diagonal_i x_i + diag(upper_i) x_{i+1} = right_side_i,
///
/// where the off-diagonal blocks are diagonal, as those of diffusion are. On a ring the first and the last point are
/// neighbours; on a line lower of the first and upper of the last point must be zero.
///
/// Cyclic reduction by global index: on every level the odd rows are eliminated and the even ones are numbered anew.
/// What is computed at a point depends on its index alone, so the bits do not depend on the number of ranks; all rows
/// of a level are independent and fill packs. A level costs one message per neighbour forwards and one back; once at
/// most 32 rows are left, every rank gathers them and goes on alone.
///
/// Blocks are factored with exchanges where a pivot is small, but not across blocks: meant for matrices in which the
/// diagonal blocks dominate or that are close to it, such as 1 - gamma (J + D Laplacian). A singular block gives a
/// solution that is not finite.
///
/// @mpi    factor and solve are collective
/// @cost   about 4 m^3 + 6 m^2 multiply-adds per point to factor and 6 m^2 to solve; 7 m^2 + 4 m numbers of memory
/// @see    Heller, SIAM J. Numer. Anal. 13(4), 1976, 484-496 (stability of block cyclic reduction)
template <int m>
class BlockTridiagonal {
 public:
  /// @param decomposition of a grid of one dimension, which must outlive the solver
  /// @param gather_at_most see above; smaller numbers mean more messages, the bits are the same
  BlockTridiagonal(const Decomposition& decomposition, bool periodic, int gather_at_most = 32);

  /// Arrays over this rank's points, to be filled before factor(). Whole packs may be written at their ends.
  double* diagonal(int row, int column) { return storage_[0].diagonal(row * m + column); }
  double* lower(int s) { return storage_[0].lower(s); }
  double* upper(int s) { return storage_[0].upper(s); }
  /// To be filled before solve(), which puts the solution there.
  double* right_side(int s) { return storage_[0].right_side(s); }

  void factor() { run<true, false>(); }
  /// @pre factor() has been called and the matrix was not touched since.
  void solve() { run<false, true>(); }
  /// Both, with half the messages.
  void factor_and_solve() { run<true, true>(); }

 private:
  using Level = block_tridiagonal::Level;
  using RowArrays = block_tridiagonal::RowArrays;
  static constexpr int mm = m * m;

  struct Storage {
    RowArrays lower, diagonal, upper;  ///< of all rows; m components at level 0, else m x m
    RowArrays right_side;
    // Of the odd rows, with those of the neighbours at either end (slot -1 and the last): diagonal^-1 times the others
    RowArrays inverse, by_lower, by_upper, solved;
  };

  template <bool factors, bool solves>
  void run();
  template <bool diagonal_sides, bool factors, bool solves>
  void eliminate(std::size_t level);
  template <bool factors, bool solves>
  void exchange_odd_rows(std::size_t level);
  template <bool diagonal_sides, bool factors, bool solves>
  void reduce(std::size_t level);
  template <bool factors, bool solves>
  void gather();
  void solve_last();
  void substitute(std::size_t level);

  const Communicator* comm_;
  bool periodic_;
  block_tridiagonal::Levels plan_;
  std::vector<Storage> storage_;
  block_tridiagonal::EdgeMessages messages_;
  std::vector<double> gather_mine_;
  std::vector<double> gather_all_;
};

template <int m>
BlockTridiagonal<m>::BlockTridiagonal(const Decomposition& decomposition, bool periodic, int gather_at_most)
    : comm_(&decomposition.comm()), periodic_(periodic), plan_(decomposition, periodic, gather_at_most), messages_(*comm_, 2 * mm + m) {
  for (std::size_t l = 0; l < plan_.levels.size(); ++l) {
    const Level& level = plan_.levels[l];
    Storage s;
    const int side = l == 0 ? m : mm;
    s.lower = RowArrays(side, level.n());
    s.upper = RowArrays(side, level.n());
    s.diagonal = RowArrays(mm, level.n());
    s.right_side = RowArrays(m, level.n());
    s.inverse = RowArrays(mm, level.n_odd);
    s.by_lower = RowArrays(mm, level.n_odd);
    s.by_upper = RowArrays(mm, level.n_odd);
    s.solved = RowArrays(m, level.n_odd);
    storage_.push_back(std::move(s));
  }
}

template <int m>
template <bool factors, bool solves>
void BlockTridiagonal<m>::run() {
  const std::size_t last = plan_.levels.size() - 1;
  for (std::size_t l = 0; l < last; ++l) {
    l == 0 ? eliminate<true, factors, solves>(l) : eliminate<false, factors, solves>(l);
    exchange_odd_rows<factors, solves>(l);
    l == 0 ? reduce<true, factors, solves>(l) : reduce<false, factors, solves>(l);
    if (comm_->size() > 1 && l + 1 == plan_.gathered) gather<factors, solves>();
  }
  if constexpr (solves) {
    solve_last();
    for (std::size_t l = last; l-- > 0;) substitute(l);
  }
}

/// The odd rows in units of their diagonal block.
template <int m>
template <bool diagonal_sides, bool factors, bool solves>
void BlockTridiagonal<m>::eliminate(std::size_t l) {
  using block_tridiagonal::load_every_second;
  const Level& level = plan_.levels[l];
  const Storage& s = storage_[l];
  for (int k = 0; k < level.n_odd; k += pack_size) {
    const int i = level.first_odd() + 2 * k;
    Pack inverse[m][m];
    if constexpr (factors) {
      const auto invert = [&](auto lu) {
        for (int r = 0; r < m; ++r) {
          for (int q = 0; q < m; ++q) lu(r, q) = load_every_second(s.diagonal(r * m + q) + i);
        }
        const bool good = lu.factor();
        for (int q = 0; q < m; ++q) {
          Pack unit[m];
          for (int r = 0; r < m; ++r) unit[r] = Pack(r == q ? 1.0 : 0.0);
          lu.solve(unit);
          for (int r = 0; r < m; ++r) inverse[r][q] = unit[r];
        }
        return good;
      };
      if (!invert(CellLu<Pack, m, false>())) invert(CellLu<Pack, m, true>());
      const auto times = [&](const RowArrays& side, const RowArrays& result) {
        for (int q = 0; q < m; ++q) {
          if constexpr (diagonal_sides) {
            const Pack x = load_every_second(side(q) + i);
            for (int r = 0; r < m; ++r) (inverse[r][q] * x).store(result(r * m + q) + k);
          } else {
            Pack x[m];
            for (int p = 0; p < m; ++p) x[p] = load_every_second(side(p * m + q) + i);
            for (int r = 0; r < m; ++r) {
              Pack sum = inverse[r][0] * x[0];
              for (int p = 1; p < m; ++p) sum = mul_add(inverse[r][p], x[p], sum);
              sum.store(result(r * m + q) + k);
            }
          }
        }
      };
      times(s.lower, s.by_lower);
      times(s.upper, s.by_upper);
      for (int c = 0; c < mm; ++c) inverse[c / m][c % m].store(s.inverse(c) + k);
    } else {
      for (int c = 0; c < mm; ++c) inverse[c / m][c % m] = Pack::load(s.inverse(c) + k);
    }
    if constexpr (solves) {
      Pack x[m];
      for (int p = 0; p < m; ++p) x[p] = load_every_second(s.right_side(p) + i);
      for (int r = 0; r < m; ++r) {
        Pack sum = inverse[r][0] * x[0];
        for (int p = 1; p < m; ++p) sum = mul_add(inverse[r][p], x[p], sum);
        sum.store(s.solved(r) + k);
      }
    }
  }
}

template <int m>
template <bool factors, bool solves>
void BlockTridiagonal<m>::exchange_odd_rows(std::size_t l) {
  const Level& level = plan_.levels[l];
  const Storage& s = storage_[l];
  if (level.n() == 0) return;
  // One row in the order of a message: f(place in the message, component, slot).
  const auto each = [&](double* row, int slot, auto f) {
    if constexpr (factors) {
      for (int c = 0; c < mm; ++c) f(*row++, s.by_lower(c)[slot]);
      for (int c = 0; c < mm; ++c) f(*row++, s.by_upper(c)[slot]);
    }
    if constexpr (solves) {
      for (int c = 0; c < m; ++c) f(*row++, s.solved(c)[slot]);
    }
  };
  constexpr int width = (factors ? 2 * mm : 0) + (solves ? m : 0);
  const std::array<int, 2> outermost{0, level.n_odd - 1};
  for (std::size_t side = 0; side < 2; ++side) {
    if (level.edges[side].partner >= 0 && level.edges[side].mine_is_odd)
      each(messages_.outgoing(side), outermost[side], [](double& message, double mine) { message = mine; });
  }
  messages_.exchange(level, true, width);
  for (std::size_t side = 0; side < 2; ++side) {
    const int slot = side == 0 ? -1 : level.n_odd;
    if (level.edges[side].partner >= 0) {
      if (level.edges[side].mine_is_odd) continue;
      double row[2 * mm + m];
      std::memcpy(row, messages_.incoming(side), width * sizeof(double));
      each(row, slot, [](double message, double& mine) { mine = message; });
    } else {
      // Where there is no odd row the off-diagonal block stays as it is: a neighbour that is minus the next but one.
      if constexpr (factors) {
        for (int c = 0; c < mm; ++c) {
          const double minus_one = c / m == c % m ? -1.0 : 0.0;
          s.by_lower(c)[slot] = side == 0 ? minus_one : 0.0;
          s.by_upper(c)[slot] = side == 0 ? 0.0 : minus_one;
        }
      }
      if constexpr (solves) {
        for (int c = 0; c < m; ++c) s.solved(c)[slot] = 0.0;
      }
    }
  }
}

/// The even rows with their odd neighbours replaced: the rows of the next level.
template <int m>
template <bool diagonal_sides, bool factors, bool solves>
void BlockTridiagonal<m>::reduce(std::size_t l) {
  using block_tridiagonal::load_every_second;
  const Level& level = plan_.levels[l];
  const Storage& s = storage_[l];
  const bool gathers = comm_->size() > 1 && l + 1 == plan_.gathered;
  const Storage& next = storage_[l + 1];
  // Before gathering every rank puts its rows where they belong in the whole.
  const int first = (level.begin + 1) / 2;
  const int target = gathers ? first : 0;
  const int n_even = (level.end + 1) / 2 - first;
  for (int k = 0; k < n_even; k += pack_size) {
    const int i = level.first_even() + 2 * k;
    const int left = k - 1 + (level.begins_odd() ? 1 : 0);
    const int right = left + 1;
    Pack a[m][m];
    Pack c[m][m];
    if constexpr (diagonal_sides) {
      for (int r = 0; r < m; ++r) {
        a[r][0] = load_every_second(s.lower(r) + i);
        c[r][0] = load_every_second(s.upper(r) + i);
      }
    } else {
      for (int e = 0; e < mm; ++e) {
        a[e / m][e % m] = load_every_second(s.lower(e) + i);
        c[e / m][e % m] = load_every_second(s.upper(e) + i);
      }
    }
    // x - (a or c) times component `of` of the neighbours, entry (r, q) of columns
    const auto subtract = [&](Pack x, const Pack(&side)[m][m], const RowArrays& of, int r, int columns, int q, int slot) {
      if constexpr (diagonal_sides) return neg_mul_add(side[r][0], Pack::load(of(r * columns + q) + slot), x);
      for (int p = 0; p < m; ++p) x = neg_mul_add(side[r][p], Pack::load(of(p * columns + q) + slot), x);
      return x;
    };
    if constexpr (factors) {
      for (int r = 0; r < m; ++r) {
        for (int q = 0; q < m; ++q) {
          Pack x = load_every_second(s.diagonal(r * m + q) + i);
          x = subtract(x, a, s.by_upper, r, m, q, left);
          x = subtract(x, c, s.by_lower, r, m, q, right);
          x.store(next.diagonal(r * m + q) + target + k);
          subtract(Pack(0.0), a, s.by_lower, r, m, q, left).store(next.lower(r * m + q) + target + k);
          subtract(Pack(0.0), c, s.by_upper, r, m, q, right).store(next.upper(r * m + q) + target + k);
        }
      }
    }
    if constexpr (solves) {
      for (int r = 0; r < m; ++r) {
        Pack x = load_every_second(s.right_side(r) + i);
        x = subtract(x, a, s.solved, r, 1, 0, left);
        x = subtract(x, c, s.solved, r, 1, 0, right);
        x.store(next.right_side(r) + target + k);
      }
    }
  }
}

template <int m>
template <bool factors, bool solves>
void BlockTridiagonal<m>::gather() {
  const Storage& s = storage_[plan_.gathered];
  constexpr int width = (factors ? 3 * mm : 0) + (solves ? m : 0);
  const auto each_component = [&](auto f) {
    if constexpr (factors) {
      for (int c = 0; c < mm; ++c) f(s.lower(c)), f(s.diagonal(c)), f(s.upper(c));
    }
    if constexpr (solves) {
      for (int c = 0; c < m; ++c) f(s.right_side(c));
    }
  };
  const auto [begin, n] = plan_.owned_at_gathering[static_cast<std::size_t>(comm_->rank())];
  gather_mine_.clear();
  each_component([&, b = begin, n_mine = n](const double* x) { gather_mine_.insert(gather_mine_.end(), x + b, x + b + n_mine); });
  std::vector<int> counts;
  std::vector<int> displacements;
  int total = 0;
  for (const auto& [b, count] : plan_.owned_at_gathering) {
    counts.push_back(count * width);
    displacements.push_back(total);
    total += count * width;
  }
  gather_all_.resize(static_cast<std::size_t>(total));
  check_mpi(MPI_Allgatherv(gather_mine_.data(), static_cast<int>(gather_mine_.size()), MPI_DOUBLE, gather_all_.data(), counts.data(),
                           displacements.data(), MPI_DOUBLE, comm_->get()),
            "MPI_Allgatherv");
  const double* from = gather_all_.data();
  for (const auto& [b, count] : plan_.owned_at_gathering) {
    each_component([&, first = b, rows = count](double* x) {
      std::memcpy(x + first, from, static_cast<std::size_t>(rows) * sizeof(double));
      from += rows;
    });
  }
}

/// The one row that is left; on a ring it is its own neighbour.
template <int m>
void BlockTridiagonal<m>::solve_last() {
  const Storage& s = storage_.back();
  CellLu<double, m, true> lu;
  double x[m];
  for (int r = 0; r < m; ++r) {
    for (int q = 0; q < m; ++q) {
      const int c = r * m + q;
      lu(r, q) = periodic_ ? s.diagonal(c)[0] + (s.lower(c)[0] + s.upper(c)[0]) : s.diagonal(c)[0];
    }
    x[r] = s.right_side(r)[0];
  }
  lu.factor();
  lu.solve(x);
  for (int r = 0; r < m; ++r) s.right_side(r)[0] = x[r];
}

/// The odd rows' unknowns from those of the even ones.
template <int m>
void BlockTridiagonal<m>::substitute(std::size_t l) {
  const Level& level = plan_.levels[l];
  const Storage& s = storage_[l];
  const Storage& next = storage_[l + 1];
  if (level.n() == 0) return;
  const bool gathers = comm_->size() > 1 && l + 1 == plan_.gathered;
  const int first = (level.begin + 1) / 2;
  const int offset = gathers ? first : 0;
  const int n_even = (level.end + 1) / 2 - first;
  const std::array<int, 2> outermost{offset, offset + n_even - 1};
  for (std::size_t side = 0; side < 2; ++side) {
    if (level.edges[side].partner < 0 || level.edges[side].mine_is_odd) continue;
    for (int c = 0; c < m; ++c) messages_.outgoing(side)[c] = next.right_side(c)[outermost[side]];
  }
  messages_.exchange(level, false, m);
  // Beyond an end without neighbour the coefficient is zero and the value must be finite.
  for (std::size_t side = 0; side < 2; ++side) {
    const bool came = level.edges[side].partner >= 0 && level.edges[side].mine_is_odd;
    const int at = side == 0 ? offset - 1 : offset + n_even;
    const bool is_odd = side == 0 ? level.begins_odd() : level.end % 2 == 0;
    if (!is_odd) continue;
    for (int c = 0; c < m; ++c) next.right_side(c)[at] = came ? messages_.incoming(side)[c] : 0.0;
  }
  const int shift = offset - (level.begins_odd() ? 1 : 0);
  for (int k = 0; k < level.n_odd; k += pack_size) {
    for (int r = 0; r < m; ++r) {
      Pack x = Pack::load(s.solved(r) + k);
      for (int p = 0; p < m; ++p) {
        x = neg_mul_add(Pack::load(s.by_lower(r * m + p) + k), Pack::load(next.right_side(p) + shift + k), x);
        x = neg_mul_add(Pack::load(s.by_upper(r * m + p) + k), Pack::load(next.right_side(p) + shift + k + 1), x);
      }
      x.store(s.solved(r) + k);
    }
  }
  const int right = level.begins_odd() ? 1 : 0;
  for (int r = 0; r < m; ++r) {
    for (int k = 0; k < n_even; k += pack_size) {
      block_tridiagonal::store_in_turn(Pack::load(next.right_side(r) + offset + k), Pack::load(s.solved(r) + right + k),
                                       s.right_side(r) + level.first_even() + 2 * k);
    }
    if (level.begins_odd()) s.right_side(r)[0] = s.solved(r)[0];
  }
}

// Compiled once, in block_tridiagonal.cpp.
extern template class BlockTridiagonal<1>;
extern template class BlockTridiagonal<2>;
extern template class BlockTridiagonal<3>;
extern template class BlockTridiagonal<4>;
extern template class BlockTridiagonal<5>;
extern template class BlockTridiagonal<6>;
extern template class BlockTridiagonal<7>;
extern template class BlockTridiagonal<8>;

}  // namespace stiffront
