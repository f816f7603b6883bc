// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/solvers/rock4.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "stiffront/core/error.hpp"
#include "stiffront/core/mpi.hpp"
#include "stiffront/space/laplacian_sweep.hpp"

namespace stiffront {
namespace {

/// Points that are taken through all stages at a time: enough to make what a call costs small. Measured.
constexpr int points_at_a_time = 8192;

/// Pointers into one row of the arrays a stage works on point by point, and its arithmetic: to = x + weight f(x).
struct EulerRow {
  double* to;
  Pack weight;

  void prefetch(int, std::ptrdiff_t) const {}
  template <class Lanes>
  void operator()(int i, const Lanes& lanes, Pack x, Pack f) const {
    lanes.store(mul_add(weight, f, x), to + i);
  }
};

/// to = x + kappa (before - x) + weight f(x). With nu = 1 - kappa this is the recurrence, but constants pass exactly
/// and x is rounded once only. `to` may be `before`.
struct RecurrenceRow {
  const double* before;
  double* to;
  Pack weight, kappa;

  void prefetch(int i, std::ptrdiff_t ahead) const { __builtin_prefetch(before + i + ahead); }
  template <class Lanes>
  void operator()(int i, const Lanes& lanes, Pack x, Pack f) const {
    lanes.store(x + mul_add(weight, f, kappa * (Pack::load(before + i) - x)), to + i);
  }
};

/// to = g + w2 (x2 - g) + w3 (x - g) + weight f(x): the argument of the last slope.
struct LastArgumentRow {
  const double *g, *x2;
  double* to;
  Pack weight, w2, w3;

  void prefetch(int i, std::ptrdiff_t ahead) const {
    __builtin_prefetch(g + i + ahead);
    __builtin_prefetch(x2 + i + ahead);
  }
  template <class Lanes>
  void operator()(int i, const Lanes& lanes, Pack x, Pack f) const {
    const Pack base = Pack::load(g + i);
    const Pack part = mul_add(w3, x - base, w2 * (Pack::load(x2 + i) - base));
    lanes.store(base + mul_add(weight, f, part), to + i);
  }
};

/// The solution, over g, and its weighted error estimate, into a sum of squares.
struct SolutionRow {
  const double *start, *x2, *x3;
  double* g;
  Pack weight, w2, w3, w4;
  Pack error_start, error_weight, error_w2, error_w3, error_w4;
  Pack relative, absolute;
  ReproducibleSum* sum;

  void prefetch(int i, std::ptrdiff_t ahead) const {
    for (const double* p : {start, x2, x3, static_cast<const double*>(g)}) __builtin_prefetch(p + i + ahead);
  }
  template <class Lanes>
  void operator()(int i, const Lanes& lanes, Pack x, Pack f) const {
    const Pack base = Pack::load(g + i);
    const Pack d2 = Pack::load(x2 + i) - base;
    const Pack d3 = Pack::load(x3 + i) - base;
    const Pack d4 = x - base;
    const Pack before = Pack::load(start + i);
    const Pack after = base + mul_add(weight, f, mul_add(w4, d4, mul_add(w3, d3, w2 * d2)));
    const Pack estimate =
        mul_add(error_weight, f, mul_add(error_start, before - base, mul_add(error_w4, d4, mul_add(error_w3, d3, error_w2 * d2))));
    const Pack scaled = estimate / mul_add(relative, max(abs(before), abs(after)), absolute);
    sum->add(lanes.or_zero(scaled * scaled));
    lanes.store(after, g + i);
  }
};

}  // namespace

/// The four finishing stages in terms of their arguments instead of their slopes, so that no slope is stored.
///
/// With x_1 = g and x_i = g + h sum_l a_il k_l, every combination of k_1 .. k_{i-1} is one of x_2 - g .. x_i - g.
struct Rock4::Finish {
  double x3_x2;                    ///< x_3 = g + x3_x2 (x_2 - g) + h a_32 k_2
  double x4_x2, x4_x3;             ///< x_4 = g + x4_x2 (x_2 - g) + x4_x3 (x_3 - g) + h a_43 k_3
  std::array<double, 3> y, error;  ///< weights of x_2 - g, x_3 - g, x_4 - g in y_1 - g - h b_4 k_4 and in the estimate

  explicit Finish(const Rock4Coefficients& m) {
    const auto& a = m.a;
    x3_x2 = a[2][0] / a[1][0];
    x4_x3 = a[3][1] / a[2][1];
    x4_x2 = (a[3][0] - x4_x3 * a[2][0]) / a[1][0];
    y = in_arguments(a, m.b);
    error = in_arguments(a, m.e);
    for (double& weight : error) weight *= m.d0;
  }

 private:
  /// The weights w with sum_{i<4} weights_i h k_i = sum_i w_i (x_{i+1} - g).
  static std::array<double, 3> in_arguments(const std::array<std::array<double, 4>, 4>& a, const std::array<double, 4>& weights) {
    const double w4 = weights[2] / a[3][2];
    const double w3 = (weights[1] - w4 * a[3][1]) / a[2][1];
    const double w2 = (weights[0] - w4 * a[3][0] - w3 * a[2][0]) / a[1][0];
    return {w2, w3, w4};
  }
};

Rock4::Rock4(const Decomposition& decomposition, const DiffusionOperator& diffusion, Rock4Tolerances tolerances, int halo_depth)
    : decomposition_(&decomposition),
      diffusion_(&diffusion),
      tolerances_(std::move(tolerances)),
      rho_(diffusion.spectral_radius()),
      max_stages_(rock4_max_stages(tolerances_.relative)),
      alone_(decomposition.comm().size() == 1),
      free_(diffusion.boundary().free_box(decomposition)),
      free_variables_(static_cast<double>(diffusion.boundary().free_points(decomposition.grid())) *
                      static_cast<double>(diffusion.diffusing_species().size())),
      inner_(free_),
      asked_depth_(diffusion.order() == 8 ? 1 : halo_depth),
      row_halo_(decomposition, diffusion.boundary(), diffusion.halo_width()),
      depth_in_cache_(max_stages_),
      rows_at_a_time_(points_at_a_time) {
  const auto demand_positive = [](double x) {
    if (!(x > 0.0 && std::isfinite(x)))
      throw Error(ErrorKind::input, fmt::format("diffusion_solver.tolerance: expected a positive number, got {}", x));
  };
  demand_positive(tolerances_.relative);
  if (tolerances_.relative < 1e-14) {
    throw Error(ErrorKind::input, fmt::format("diffusion_solver.tolerance: {} is below what double precision can meet; the least "
                                              "is 1e-14",
                                              tolerances_.relative));
  }
  if (tolerances_.absolute.size() != static_cast<std::size_t>(diffusion.n_species()))
    throw Error(ErrorKind::bug, "ROCK4 needs one absolute tolerance per species");
  std::for_each(tolerances_.absolute.begin(), tolerances_.absolute.end(), demand_positive);

  // Whole packs next to the sides wait for the halo, so that the interior consists of aligned packs.
  const int width = diffusion.halo_width();
  const bool two_dimensional = diffusion.dimension() == 2;
  bool has_neighbour = false;
  for (int direction = 0; direction < 2; ++direction) {
    for (int side : {-1, 1}) {
      const int rank = decomposition.neighbour(direction == 0 ? side : 0, direction == 1 ? side : 0);
      has_neighbour = has_neighbour || (rank != MPI_PROC_NULL && rank != decomposition.comm().rank());
    }
  }
  inner_.i_begin = (width + pack_size - 1) / pack_size * pack_size;
  inner_.i_end = (decomposition.n_x() - width) / pack_size * pack_size;
  if (two_dimensional) {
    inner_.j_begin = std::max(width, free_.j_begin);
    inner_.j_end = std::min(decomposition.n_y() - width, free_.j_end);
  }
  if (!has_neighbour || inner_.i_begin >= inner_.i_end || inner_.j_begin >= inner_.j_end) inner_ = {0, 0, 0, 0};
  if (asked_depth_ == 0 && !alone_) halo_cost_.emplace(decomposition, width, measure_exchange(decomposition));

  const std::int64_t row = static_cast<std::int64_t>(decomposition.n_x() + 3 * 8) * static_cast<std::int64_t>(sizeof(double));
  is_large_ = 2 * row * decomposition.n_y() > own_cache;
  if (two_dimensional) {
    rows_at_a_time_ = std::clamp(points_at_a_time / decomposition.n_x(), 4, 16);
    // Two buffers take turns.
    const std::int64_t rows = wavefront_cache_share / row;
    depth_in_cache_ = static_cast<int>(std::clamp<std::int64_t>((rows / 2 - rows_at_a_time_) / width, 1, max_stages_));
  }
}

/// The points that evolve, and those of neighbours at most `by` away.
FreeBox Rock4::extended(int by) const {
  FreeBox box = free_;
  const Decomposition& d = *decomposition_;
  const auto is_other = [&](int dx, int dy) {
    const int rank = d.neighbour(dx, dy);
    return rank != MPI_PROC_NULL && rank != d.comm().rank();
  };
  if (is_other(-1, 0)) box.i_begin -= by;
  if (is_other(1, 0)) box.i_end += by;
  if (d.grid().dimension == 1) return box;
  if (is_other(0, -1)) box.j_begin -= by;
  if (is_other(0, 1)) box.j_end += by;
  return box;
}

/// What the tile has outside inner_.
std::array<FreeBox, 4> Rock4::around_inner(const FreeBox& tile) const {
  const int below = std::clamp(inner_.j_begin, tile.j_begin, tile.j_end);
  const int above = std::clamp(inner_.j_end, tile.j_begin, tile.j_end);
  const int before = std::clamp(inner_.i_begin, tile.i_begin, tile.i_end);
  const int after = std::clamp(inner_.i_end, tile.i_begin, tile.i_end);
  return {FreeBox{tile.i_begin, tile.i_end, tile.j_begin, below}, FreeBox{tile.i_begin, before, below, above},
          FreeBox{after, tile.i_end, below, above}, FreeBox{tile.i_begin, tile.i_end, above, tile.j_end}};
}

void Rock4::set_state(std::span<const double> state) {
  if (state.size() != 1 || !(state[0] >= 0.0)) throw Error(ErrorKind::bug, "the state of ROCK4 is one step size");
  first_step_ = state[0];
}

double Rock4::largest_step() const {
  // A little less, so that the stages computed from step times radius are never one more.
  return rock4_interval(max_stages_) * (1.0 - 1e-12) / rho_;
}

Field* Rock4::scratch(const Field& like) {
  if (scratch_used_ == scratch_.size()) scratch_.push_back(like.similar());
  return &scratch_[scratch_used_++];
}

void Rock4::prepare(std::span<const Transition> states, double t) {
  const Boundary& boundary = diffusion_->boundary();
  const Field& shape = *states.front().to;
  if (shape.halo() < diffusion_->halo_width()) throw Error(ErrorKind::bug, "the halo is narrower than the diffusion stencil");
  if (!scratch_.empty() && (scratch_.front().halo() != shape.halo() || scratch_.front().n_species() != shape.n_species())) scratch_.clear();
  // Alone, the stages of a pass need no halo but that of a stencil.
  largest_depth_ =
      alone_ ? max_stages_
             : std::min(largest_halo_depth(*decomposition_, boundary, diffusion_->halo_width()), shape.halo() / diffusion_->halo_width());
  if (asked_depth_ == 1) largest_depth_ = 1;
  scratch_used_ = 0;
  buffers_.assign(states.size(), {});
  kept_.assign(states.size(), nullptr);
  for (std::size_t k = 0; k < states.size(); ++k) {
    Buffers& b = buffers_[k];
    b[start] = states[k].from;
    std::size_t next = 1;
    if (states[k].from != states[k].to) {
      b[next++] = states[k].to;
      if (boundary.depends_on_time()) {
        // In a splitting the boundary has run ahead with the other process.
        b[start] = scratch(shape);
        for (int s : diffusion_->diffusing_species()) b[start]->copy_interior(*states[k].from, s);
      } else {
        kept_[k] = states[k].from;
      }
    }
    while (next < b.size()) b[next++] = scratch(shape);
    for (std::size_t i = boundary.depends_on_time() ? start : 1; i < b.size(); ++i) boundary.impose(*b[i], t, reach());
  }
}

HaloExchange& Rock4::exchange_for(int together, std::size_t n_fields) {
  auto& exchange = exchanges_[{together, n_fields}];
  if (exchange) return *exchange;
  const int width = diffusion_->halo_width();
  if (together == 1) {
    exchange = std::make_unique<HaloExchange>(*decomposition_, diffusion_->boundary(), diffusion_->n_species(), static_cast<int>(n_fields),
                                              width, diffusion_->diffusing_species());
  } else {
    // The inputs of the first stage, and what it reads at the point itself.
    std::vector<int> widths(n_fields, (together - 1) * width);
    std::fill_n(widths.begin(), buffers_.size(), together * width);
    exchange = std::make_unique<HaloExchange>(*decomposition_, diffusion_->boundary(), diffusion_->n_species(), std::move(widths), width,
                                              diffusion_->diffusing_species());
  }
  return *exchange;
}

/// Makes stages of all states; make(stage, state, species, tile) makes one on part of the box.
///
/// One exchange serves all of them: where its halos have points to spare, those of neighbours that later stages need are made too.
template <class Make>
void Rock4::pass(std::span<const Stage> stages, const Make& make) {
  const Boundary& boundary = diffusion_->boundary();
  const std::vector<int>& species = diffusion_->diffusing_species();
  const int width = diffusion_->halo_width();
  const auto together = static_cast<int>(stages.size());
  const int beyond = alone_ ? 1 : together;  // stencils that the halos are deep
  const auto on = [&](const Stage& stage, std::size_t k, int s, const FreeBox& tile) {
    if (tile.i_begin < tile.i_end && tile.j_begin < tile.j_end) make(stage, k, s, tile);
  };

  const Stage& first = stages.front();
  exchanged_.clear();
  for (const Buffers& b : buffers_) exchanged_.push_back(b[first.input]);
  if (beyond > 1) {
    for (std::size_t other : first.others) {
      if (other == none) continue;
      for (const Buffers& b : buffers_) exchanged_.push_back(b[other]);
    }
  }
  if (first.input != start && boundary.depends_on_time()) {
    for (const Buffers& b : buffers_) boundary.impose(*b[first.input], first.time);
  }
  HaloExchange& exchange = exchange_for(beyond, exchanged_.size());
  ++exchanges_made_;
  // Work on the interior hides the messages, but is a pass over memory of its own where the box is large.
  const bool hides_messages = inner_.i_begin < inner_.i_end && (together == 1 || !is_large_);
  exchange.begin(exchanged_);
  for (std::size_t k = 0; k < buffers_.size() && hides_messages; ++k) {
    for (int s : species) on(first, k, s, inner_);
  }
  exchange.finish();

  // In the plane the stages follow each other along y, a stencil apart, on a line a pack apart.
  const bool in_plane = diffusion_->dimension() == 2;
  const int distance = in_plane ? width : pack_size;
  const bool around = row_halo_.wraps(in_plane ? 1 : 0);
  const auto box_of = [&](int p) { return extended((together - 1 - p) * width); };
  passes_.clear();
  for (int p = 0; p < together; ++p) {
    const FreeBox box = box_of(p);
    const auto [begin, end] = in_plane ? std::pair(box.j_begin, box.j_end) : std::pair(box.i_begin, box.i_end);
    const int from = around ? p * distance : begin;
    passes_.push_back({p * distance, from, from + end - begin});
  }
  // A single stage needs no pieces.
  const int at_a_time = together == 1 ? std::numeric_limits<int>::max() / 2 : rows_at_a_time_;
  for (std::size_t k = 0; k < buffers_.size(); ++k) {
    for (int s : species) {
      const auto on_rows = [&](std::size_t p, int begin, int end) {
        FreeBox tile = box_of(static_cast<int>(p));
        (in_plane ? tile.j_begin : tile.i_begin) = begin;
        (in_plane ? tile.j_end : tile.i_end) = end;
        const Stage& stage = stages[p];
        if (p > 0) {
          const Rows input = rows_of(*buffers_[k][stage.input]);
          if (boundary.depends_on_time()) row_halo_.impose(input, s, tile, stage.time);
          row_halo_.fill(input, s, tile);
        }
        if (p > 0 || !hides_messages) {
          on(stage, k, s, tile);
        } else {
          for (const FreeBox& part : around_inner(tile)) on(stage, k, s, part);
        }
      };
      if (around) {
        wavefront_around(passes_, in_plane ? decomposition_->n_y() : decomposition_->n_x(), at_a_time, on_rows);
      } else {
        wavefront(passes_, at_a_time, on_rows);
      }
    }
  }
}

/// What a step of length h does, stage by stage. The result is in the buffer that result_ names.
void Rock4::plan(const Rock4Coefficients& m, const Finish& finish, double t, double h) {
  stages_.clear();
  const auto euler = [&](std::size_t u, std::size_t to, double time, double weight) {
    stages_.push_back({.kind = Stage::euler, .input = u, .to = to, .time = time, .weight = weight});
  };
  const auto recur = [&](std::size_t u, std::size_t before, std::size_t to, double time, double weight, double kappa) {
    stages_.push_back(
        {.kind = Stage::recurrence, .input = u, .others = {before, none}, .to = to, .time = time, .weight = weight, .kappa = kappa});
  };
  std::size_t g = 1;
  std::size_t other = start;
  euler(start, g, t, h * m.mu[0]);
  for (std::size_t j = 1; j < m.mu.size(); ++j) {
    const std::size_t out = j == 1 ? 2 : other;
    recur(g, other, out, t + m.ct[j] * h, h * m.mu[j], m.kappa[j]);
    other = g;
    g = out;
  }
  const std::size_t x2 = 3 - g;
  const std::size_t x3 = 3;
  const std::size_t x4 = 4;
  euler(g, x2, t + m.c[0] * h, h * m.a[1][0]);
  recur(x2, g, x3, t + m.c[1] * h, h * m.a[2][1], 1.0 - finish.x3_x2);
  stages_.push_back(
      {.kind = Stage::last_argument, .input = x3, .others = {g, x2}, .to = x4, .time = t + m.c[2] * h, .weight = h * m.a[3][2]});
  stages_.push_back({.kind = Stage::solution, .input = x4, .others = {x2, x3}, .to = g, .time = t + m.c[3] * h, .weight = h * m.b[3]});
  result_ = g;
}

/// Stages per pass and exchange in a step of so many.
int Rock4::depth_of(int stages) const {
  int depth = std::max(asked_depth_, 1);
  if (halo_cost_) {
    depth = halo_cost_->best_depth(largest_depth_, stages, static_cast<int>(buffers_.size() * diffusion_->diffusing_species().size()));
  } else if (asked_depth_ == 0) {
    depth = depth_in_cache_;
  }
  return std::min({depth, largest_depth_, stages});
}

double Rock4::attempt(double t, double h, Work& work) {
  for (std::size_t k = 0; k < buffers_.size(); ++k) {
    for (std::size_t i = 1; i < buffers_[k].size(); ++i) {
      if (buffers_[k][i] != kept_[k]) continue;
      // After the first accepted step: the place of the field that must not change is taken by one that may.
      buffers_[k][i] = scratch(*buffers_[k][start]);
      diffusion_->boundary().impose(*buffers_[k][i], t, reach());
    }
  }
  const int stages = std::min(rock4_stages(h * rho_), max_stages_);
  const int depth = depth_of(stages);
  exchanges_made_ = 0;
  const Rock4Coefficients& m = table_[stages];
  const Finish finish(m);
  plan(m, finish, t, h);
  Agreement agreement(static_cast<int>(buffers_.size()), 0);
  if (diffusion_->order() == 8 && slope_.empty()) slope_.push_back(buffers_.front()[start]->similar());
  const auto all_stages = [&]<int Order, int Dimension>() {
    const auto make = [&](const Stage& stage, std::size_t k, int s, const FreeBox& tile) {
      const Buffers& b = buffers_[k];
      const Field& u = *b[stage.input];
      const auto over = [&](auto&& on_row) {
        if constexpr (Order == 8) {
          diffusion_->apply_of_order_8(u, slope_.front(), s, tile);
          sweep_values(u, slope_.front(), s, tile, on_row);
        } else {
          sweep(diffusion_->stencil<Order, Dimension>(s, u), u, s, tile, on_row);
        }
      };
      switch (stage.kind) {
        case Stage::euler:
          over([&](int j) { return EulerRow{b[stage.to]->row(s, j), Pack(stage.weight)}; });
          break;
        case Stage::recurrence:
          over([&](int j) {
            return RecurrenceRow{b[stage.others[0]]->row(s, j), b[stage.to]->row(s, j), Pack(stage.weight), Pack(stage.kappa)};
          });
          break;
        case Stage::last_argument:
          over([&](int j) {
            return LastArgumentRow{.g = b[stage.others[0]]->row(s, j),
                                   .x2 = b[stage.others[1]]->row(s, j),
                                   .to = b[stage.to]->row(s, j),
                                   .weight = Pack(stage.weight),
                                   .w2 = Pack(finish.x4_x2),
                                   .w3 = Pack(finish.x4_x3)};
          });
          break;
        case Stage::solution:
          over([&](int j) {
            return SolutionRow{.start = b[start]->row(s, j),
                               .x2 = b[stage.others[0]]->row(s, j),
                               .x3 = b[stage.others[1]]->row(s, j),
                               .g = b[stage.to]->row(s, j),
                               .weight = Pack(stage.weight),
                               .w2 = Pack(finish.y[0]),
                               .w3 = Pack(finish.y[1]),
                               .w4 = Pack(finish.y[2]),
                               .error_start = Pack(m.d0),
                               .error_weight = Pack(h * m.d0 * m.e[3]),
                               .error_w2 = Pack(finish.error[0]),
                               .error_w3 = Pack(finish.error[1]),
                               .error_w4 = Pack(finish.error[2]),
                               .relative = Pack(tolerances_.relative),
                               .absolute = Pack(tolerances_.absolute[static_cast<std::size_t>(s)]),
                               .sum = &agreement.sums[k]};
          });
          break;
      }
    };
    // Passes of nearly the same number of stages.
    const int passes = (stages + depth - 1) / depth;
    for (int p = 0; p < passes; ++p) {
      const int first = stages * p / passes;
      const int last = stages * (p + 1) / passes;
      pass(std::span(std::as_const(stages_)).subspan(static_cast<std::size_t>(first), static_cast<std::size_t>(last - first)), make);
    }
  };
  if (diffusion_->order() == 8) {
    all_stages.operator()<8, 0>();
  } else {
    diffusion_->dispatch(all_stages);
  }
  work.diffusion_stages += stages;
  work.halo_exchanges += exchanges_made_;

  decomposition_->comm().agree(agreement);
  double largest = 0.0;
  for (std::size_t k = 0; k < buffers_.size(); ++k) {
    const double error = std::sqrt(agreement.sums[k].value() / free_variables_);
    if (!std::isfinite(error)) return std::numeric_limits<double>::infinity();
    largest = std::max(largest, error);
  }
  return largest;
}

void Rock4::accept(double time) {
  for (Buffers& b : buffers_) {
    std::swap(b[start], b[result_]);
    if (diffusion_->boundary().depends_on_time()) diffusion_->boundary().impose(*b[start], time);
  }
}

void Rock4::deliver(std::span<const Transition> states, double time) {
  for (std::size_t k = 0; k < states.size(); ++k) {
    Field& from = *states[k].from;
    Field& to = *states[k].to;
    Field& result = *buffers_[k][start];
    if (&result != &to) swap(result, to);
    // What does not diffuse has stayed in the storage of `from`; in place, that is what `result` names now.
    const Field& old = &from == &to ? result : from;
    for (int s = 0; s < diffusion_->n_species(); ++s) {
      if (&old != &to && !(diffusion_->coefficient(s) > 0.0)) to.copy_interior(old, s);
    }
    if (diffusion_->boundary().depends_on_time()) diffusion_->boundary().impose(to, time);
  }
}

std::optional<CellFailure> Rock4::advance(double t, double dt, std::span<const Transition> states, Work& work) {
  if (!(dt >= 0.0)) throw Error(ErrorKind::bug, fmt::format("diffusion over a time of {}", dt));
  if (states.empty()) return std::nullopt;
  if (!(rho_ > 0.0) || dt == 0.0) {
    for (const Transition& state : states) {
      if (state.from != state.to) state.to->copy_interior(*state.from);
      if (diffusion_->boundary().depends_on_time()) diffusion_->boundary().impose(*state.to, t + dt);
    }
    return std::nullopt;
  }
  prepare(states, t);

  const double limit = largest_step();
  double planned = first_step_ > 0.0 ? first_step_ : rock4_interval(rock4_min_stages) / rho_;
  double elapsed = 0.0;
  double last_h = 0.0;  // of the last accepted step; 0: there is none yet
  double last_error = 0.0;
  bool just_rejected = false;
  while (elapsed < dt) {
    // Steps of one length to the end instead of a short one there: the result is smoother in dt.
    const double remaining = dt - elapsed;
    const double steps_left = std::max(std::ceil(remaining / (1.01 * planned)), std::ceil(remaining / limit));
    const double h = remaining / steps_left;
    if (h < 1e-13 * dt) return fail(states, t + elapsed, dt, h, "the step of the diffusion solver became too small");
    const double error = attempt(t + elapsed, h, work);
    if (!std::isfinite(error)) return fail(states, t + elapsed, dt, h, "diffusion met a value that is not finite");

    const double bounded = std::max(error, 1e-10);
    double factor = 0.8 / std::sqrt(std::sqrt(bounded));
    if (error > 1.0) {
      ++work.diffusion_rejections;
      planned = h * std::max(0.1, 0.8 * factor);
      just_rejected = true;
      continue;
    }
    accept(t + elapsed + h);
    ++work.diffusion_steps;
    elapsed = steps_left == 1.0 ? dt : elapsed + h;
    const bool first = last_h == 0.0;
    if (!first && !just_rejected) factor = std::min(factor, factor * (h / last_h) * std::sqrt(std::sqrt(last_error / bounded)));
    const double growth = first ? 5.0 : 2.0;
    // A step shortened to meet the end says nothing against the longer one planned.
    const double ceiling = just_rejected ? h : std::max(growth * h, planned);
    planned = std::min(std::max(0.1, factor) * h, ceiling);
    // The next call begins with data of the kind this one began with, often less smooth than those it ended with.
    if (first) first_step_ = planned;
    last_h = h;
    last_error = bounded;
    just_rejected = false;
  }
  deliver(states, t + dt);
  return std::nullopt;
}

std::optional<CellFailure> Rock4::fail(std::span<const Transition> states, double t, double dt, double h, const char* reason) {
  // Species that do not diffuse are where they always were, the others where the step began.
  const auto value = [&](std::size_t k, int s, int i, int j) {
    return (diffusion_->coefficient(s) > 0.0 ? *buffers_[k][start] : *states[k].from).at(s, i, j);
  };
  const Field& shape = *states.front().to;
  struct {
    std::size_t k = 0;
    int i = 0, j = 0;
  } where;
  bool found = false;
  for (std::size_t k = 0; k < states.size(); ++k) {
    for (int j = 0; j < shape.n_y(); ++j) {
      for (int i = 0; i < shape.n_x(); ++i) {
        for (int s = 0; s < shape.n_species(); ++s) {
          if (found || std::isfinite(value(k, s, i, j))) continue;
          found = true;
          where = {k, i, j};
        }
      }
    }
  }
  // All ranks are here. The one with a value that is not finite reports it; if there is none, the step itself has
  // failed and each reports its first cell.
  const bool found_anywhere = decomposition_->comm().max(std::int64_t{found}) != 0;
  std::optional<CellFailure> failure;
  if (found || !found_anywhere) {
    const Grid& grid = decomposition_->grid();
    failure.emplace();
    failure->i = decomposition_->offset_x() + where.i;
    failure->j = decomposition_->offset_y() + where.j;
    failure->x = grid.position(0, failure->i);
    failure->y = grid.dimension == 2 ? grid.position(1, failure->j) : 0.0;
    failure->t = t;
    failure->dt = h;
    failure->interval = dt;
    failure->reason = reason;
    for (int s = 0; s < shape.n_species(); ++s) failure->state.push_back(value(where.k, s, where.i, where.j));
  }
  for (std::size_t k = 0; k < states.size(); ++k) {
    for (int s = 0; s < shape.n_species(); ++s) {
      for (int j = 0; j < shape.n_y(); ++j) {
        for (int i = 0; i < shape.n_x(); ++i) {
          const double x = value(k, s, i, j);
          states[k].to->at(s, i, j) = std::isfinite(x) ? x : 0.0;
        }
      }
    }
  }
  return failure;
}

}  // namespace stiffront
