// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/sbdf_wavefront.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <utility>

namespace stiffront {
namespace {

/// A history of more than this is not in cache from one step to the next, and several steps at a time gain.
constexpr std::ptrdiff_t last_level = 16 * 1024 * 1024;

/// Points that are taken through all sweeps at a time: enough to make what a call costs small. Measured.
constexpr int piece = 2048;
constexpr int piece_of_rows = 4096;

/// Sweeps that a step next to other ranks may have, at most: an exchange is made for each number.
constexpr std::array exchange_depths{1, 2, 3, 4, 6, 8, 12, 16};

/// Rows are aligned at their first point, and packs across two lines of a cache take a third longer: what is computed before that point
/// is rounded up to whole packs. Points too many have no meaning, and nobody looks at them.
constexpr int whole_packs(int points) { return (points + pack_size - 1) / pack_size * pack_size; }

}  // namespace

bool SbdfWavefront::serves(const Decomposition& d) { return !d.grid().periodic[0] || d.processes()[0] == 1; }

SbdfWavefront::Rings::Rings(const Field& shape, int rows, int width, int sweeps)
    : predictor(shape, window(rows, width, sweeps)), right_side(shape, window(rows, width, sweeps)) {
  for (int k = 1; k < sweeps; ++k) stages.emplace_back(shape, rows + 3 * width);
}

SbdfWavefront::SbdfWavefront(const Field& shape, const DiffusionOperator& diffusion, const SbdfKernel& kernel, int max_sweeps, int depth,
                             int together)
    : decomposition_(&shape.decomposition()),
      diffusion_(&diffusion),
      kernel_(&kernel),
      n_species_(shape.n_species()),
      n_x_(shape.n_x()),
      n_y_(shape.n_y()),
      width_(diffusion.halo_width()),
      free_(diffusion.boundary().free_box(*decomposition_)),
      row_halo_(*decomposition_, diffusion.boundary(), diffusion.halo_width()),
      periodic_y_(decomposition_->grid().periodic[1]),
      depth_(max_sweeps),
      together_(together) {
  const auto is_other = [&](int dx, int dy) {
    const int rank = decomposition_->neighbour(dx, dy);
    return rank != MPI_PROC_NULL && rank != decomposition_->comm().rank();
  };
  left_ = is_other(-1, 0);
  right_ = is_other(1, 0);
  lower_ = is_other(0, -1);
  upper_ = is_other(0, 1);
  has_neighbours_ = decomposition_->comm().size() > 1;
  // The depth decides whether ranks exchange once or for every sweep: it is made of what all of them know.
  const Grid& grid = decomposition_->grid();
  const std::array<int, 2> processes = decomposition_->processes();
  if (has_neighbours_) {
    std::int64_t thinnest = std::numeric_limits<std::int64_t>::max();
    for (std::size_t k = 0; k < static_cast<std::size_t>(grid.dimension); ++k) {
      if (processes[k] > 1 || grid.periodic[k]) thinnest = std::min(thinnest, grid.points[k] / processes[k]);
    }
    depth_ = 0;
    for (int sweeps : exchange_depths) {
      if (sweeps * width_ > thinnest || sweeps > std::max(max_sweeps, 1)) break;
      const std::vector<int> widths(2, sweeps * width_);
      exchanges_.push_back(
          {sweeps, std::make_unique<HaloExchange>(*decomposition_, diffusion.boundary(), n_species_, widths, width_, std::vector<int>())});
      depth_ = sweeps;
    }
    reach_ = depth_ * width_;
  }
  if (grid.dimension == 1) {
    for (int k = 0; k < 2 && has_neighbours_; ++k) line_states_.emplace_back(*decomposition_, n_species_, std::max(reach_, width_));
    return;
  }
  const int longest = static_cast<int>((grid.points[0] + processes[0] - 1) / processes[0]);
  constexpr int padding = 3 * 8;
  row_bytes_ = static_cast<std::ptrdiff_t>(longest + padding) * n_species_ * static_cast<std::ptrdiff_t>(sizeof(double));
  rows_ = std::clamp(piece_of_rows / longest, 1, 16);
  // A sweep adds its own window of rows and keeps those of predictor and right side alive longer.
  const std::ptrdiff_t fits = (wavefront_cache_share / row_bytes_ - 2 * rows_) / (rows_ + 5 * width_);
  const int wanted = depth > 0 ? depth : static_cast<int>(std::clamp<std::ptrdiff_t>(fits, 1, max_sweeps));
  depth_ = has_neighbours_ ? std::min(depth_, wanted) : wanted;
  // A periodic direction is unrolled once at most; a divided one has let pass no more than its thinnest part above.
  depth_ = std::min(depth_, std::max(1, n_y_ / width_));
  if (depth_ == 0) return;
  const Field wide(*decomposition_, n_species_, std::max(reach_, shape.halo()));
  rings_.emplace_back(wide, rows_, width_, depth_);
  int most = 1;
  for (int sweeps = 1; sweeps <= depth_; ++sweeps) most = std::max(most, steps_together(sweeps));
  for (int k = 1; k < most; ++k) rings_.emplace_back(wide, rows_, width_, depth_);
  for (int k = 0; k < 2; ++k) tests_.emplace_back(wide, window(rows_, width_, depth_));
}

int SbdfWavefront::steps_together(int sweeps) const {
  if (decomposition_->grid().dimension == 1 || periodic_y_ || has_neighbours_ || sweeps > depth_) return 1;
  if (together_ > 0) return std::min(together_, max_steps);
  return row_bytes_ * n_y_ * static_cast<std::ptrdiff_t>(bdf_max_points) > last_level ? max_steps : 1;
}

void SbdfWavefront::run(std::span<const Step> steps, Field& predictor, Field& right_side, Field& work, const Finished& finished) {
  if (diffusion_->boundary().has_dirichlet()) {
    for (const Step& step : steps) diffusion_->boundary().impose(*step.u_new, step.t);
  }
  if (has_neighbours_) exchange(steps[0], predictor, right_side);
  if (decomposition_->grid().dimension == 1) {
    line(steps[0], predictor, right_side, work, finished);
    return;
  }
  std::array<Leg, max_steps> legs;
  const auto sweeps = static_cast<int>(steps[0].shifts.size());
  const int passes = (sweeps + depth_ - 1) / depth_;
  if (passes == 1) {
    for (std::size_t k = 0; k < steps.size(); ++k) {
      legs[k] = Leg{};
      legs[k].step = k;
      legs[k].last = static_cast<int>(steps[k].shifts.size());
      legs[k].to = steps[k].u_new;
      legs[k].finishes = true;
    }
    pass_over_rows(steps, std::span(legs).first(steps.size()), predictor, right_side, finished);
    return;
  }
  const Field* from = nullptr;
  for (int p = 0; p < passes; ++p) {
    Leg& leg = legs[0];
    leg.first = sweeps * p / passes;
    leg.last = sweeps * (p + 1) / passes;
    leg.from = from;
    leg.to = (passes - 1 - p) % 2 == 0 ? steps[0].u_new : &work;
    leg.predictor = &predictor;
    leg.right_side = &right_side;
    leg.finishes = p == passes - 1;
    pass_over_rows(steps, std::span(legs).first(1), predictor, right_side, finished);
    from = leg.to;
  }
}

/// The points of Dirichlet sides that come into reach with a box, from where they have their values.
void SbdfWavefront::copy_fixed(const ConstRows& from, const Rows& to, const FreeBox& box) const {
  const auto is_fixed = [&](int direction, int which) {
    return decomposition_->at_boundary(direction, which) && diffusion_->boundary().side(direction, which).kind == BoundaryKind::dirichlet;
  };
  for (int which = 0; which < 2; ++which) {
    const int row = which == 0 ? 0 : n_y_ - 1;
    const bool is_near = box.j_begin - 1 <= row && row < box.j_end + width_;
    const int column = which == 0 ? 0 : n_x_ - 1;
    for (int s = 0; s < n_species_; ++s) {
      if (decomposition_->grid().dimension == 2 && is_fixed(1, which) && is_near) {
        std::copy(from.row(s, row) + box.i_begin, from.row(s, row) + box.i_end, to.row(s, row) + box.i_begin);
      }
      if (!is_fixed(0, which)) continue;
      for (int j = box.j_begin; j < box.j_end; ++j) {
        // Along a periodic direction of a single rank the rows go on as those of its other end.
        const int there = has_neighbours_ ? j : (j % n_y_ + n_y_) % n_y_;
        to.row(s, j)[column] = from.row(s, there)[column];
      }
    }
  }
}

/// What a sweep over a box reads at the sides of the domain.
void SbdfWavefront::complete(const Step& step, const Field& predictor, const Rows& v, const FreeBox& box) const {
  // Dirichlet points beyond the box of the rank came with the predictor.
  if (diffusion_->boundary().has_dirichlet()) {
    copy_fixed(rows_of(has_neighbours_ ? predictor : std::as_const(*step.u_new)), v, box);
  }
  for (int s = 0; s < n_species_; ++s) {
    row_halo_.fill_ends(v, s, box);
    if (!is_unrolled()) row_halo_.fill_rows(v, s, box);
  }
}

namespace {

void make_predictor(const SbdfWavefront::Step& step, const Rows& predictor, const Rows& right_side, const FreeBox& box, int shift = 0) {
  bdf_combine(step.states.first(static_cast<std::size_t>(step.points)), step.predictor, step.history, predictor, right_side, box, shift);
}

}  // namespace

/// Brings predictor and right side up to the depth of the step's sweeps around the box. Inside they are made here only as far as
/// neighbours look, or the other end of a periodic direction that is not divided, and while these travel the rest of a line.
void SbdfWavefront::exchange(const Step& step, Field& predictor, Field& right_side) {
  const auto sweeps = static_cast<int>(step.shifts.size());
  const Exchange& fitting = *std::find_if(exchanges_.begin(), exchanges_.end(), [&](const Exchange& e) { return e.sweeps >= sweeps; });
  const int depth = fitting.sweeps * width_;
  const int below = lower_ || periodic_y_ ? std::min(depth, n_y_) : 0;
  const int above = upper_ || periodic_y_ ? std::max(below, n_y_ - depth) : n_y_;
  const int before = left_ ? std::min(whole_packs(depth), n_x_) : 0;
  const int after = right_ ? std::max(before, (n_x_ - depth) / pack_size * pack_size) : n_x_;
  for (const FreeBox& strip :
       {FreeBox{0, n_x_, 0, below}, FreeBox{0, n_x_, above, n_y_}, FreeBox{0, before, below, above}, FreeBox{after, n_x_, below, above}}) {
    if (strip.i_begin >= strip.i_end || strip.j_begin >= strip.j_end) continue;
    make_predictor(step, rows_of(predictor), rows_of(right_side), strip);
  }
  diffusion_->boundary().impose(predictor, step.t);
  const std::array<Field*, 2> fields{&predictor, &right_side};
  fitting.halos->begin(fields);
  const FreeBox rest{std::max(before, free_.i_begin), std::min(after, free_.i_end), 0, 1};
  if (decomposition_->grid().dimension == 1 && rest.i_begin < rest.i_end) {
    make_predictor(step, rows_of(predictor), rows_of(right_side), rest);
  }
  fitting.halos->finish();
}

/// What the first sweep of a leg starts from, at rows of the box and beyond. On a single rank those beyond are the rows `shift` further
/// on, at the other end of a periodic direction; next to other ranks they and the columns beyond came from there.
void SbdfWavefront::begin_rows(const Step& step, const Leg& leg, Rings& rings, const FreeBox& box, int shift, const Field& predictor,
                               const Field& right_side) {
  const int alive = window(rows_, width_, leg.last - leg.first);
  const Rows start = rings.predictor.rows(alive);
  const Rows r = rings.right_side.rows(alive);
  const auto copy = [&](const ConstRows& from, int j_from, const Rows& to, int j_to, int i_begin, int i_end) {
    for (int s = 0; s < n_species_ && i_begin < i_end; ++s) {
      std::memcpy(to.row(s, j_to) + i_begin, from.row(s, j_from) + i_begin, static_cast<std::size_t>(i_end - i_begin) * sizeof(double));
    }
  };
  if (has_neighbours_) {
    const auto copy_both = [&](int j, int i_begin, int i_end) {
      copy(rows_of(predictor), j, start, j, i_begin, i_end);
      copy(rows_of(right_side), j, r, j, i_begin, i_end);
    };
    for (int j = box.j_begin; j < box.j_end; ++j) {
      if (shift == 0) {
        copy_both(j, box.i_begin, 0);
        copy_both(j, n_x_, box.i_end);
      } else {
        copy_both(j, box.i_begin, box.i_end);
      }
    }
    if (shift != 0) return;
  }
  const FreeBox own{0, n_x_, box.j_begin, box.j_end};
  if (leg.from == nullptr) {
    make_predictor(step, start, r, own, shift);
    if (leg.predictor == nullptr) {
      if (step.tests_order) {
        bdf_combine(step.states, step.lower, step.upper, tests_[0].rows(alive), tests_[1].rows(alive), own, shift);
      }
      return;
    }
    if (shift != 0) return;
  }
  for (int j = box.j_begin; j < box.j_end; ++j) {
    if (leg.from == nullptr) {
      copy(start, j, rows_of(*leg.predictor), j, 0, n_x_);
      copy(r, j, rows_of(*leg.right_side), j, 0, n_x_);
    } else {
      copy(rows_of(*leg.from), j + shift, start, j, 0, n_x_);
      copy(rows_of(*leg.right_side), j + shift, r, j, 0, n_x_);
    }
  }
}

void SbdfWavefront::pass_over_rows(std::span<const Step> steps, std::span<const Leg> legs, const Field& predictor, const Field& right_side,
                                   const Finished& finished) {
  // Pass 0 of a leg makes what its sweeps start from.
  passes_.clear();
  places_.clear();
  int all_sweeps = 0;
  for (const Leg& leg : legs) all_sweeps += leg.last - leg.first;
  int behind = 0;  // sweeps of the legs before
  for (std::size_t l = 0; l < legs.size(); ++l) {
    const int sweeps = legs[l].last - legs[l].first;
    for (int k = 0; k <= sweeps; ++k) {
      // One leg alone goes beyond the box as far as the sweeps to come look: into the halos next to other ranks, and on a single rank
      // along an unrolled periodic direction.
      const FreeBox box = box_of(all_sweeps, k);
      passes_.push_back({(behind + k) * width_, box.j_begin, box.j_end});
      places_.push_back({l, k});
    }
    behind += sweeps;
  }

  wavefront(passes_, rows_, [&](std::size_t p, int begin, int end) {
    const auto [l, k] = places_[p];
    const Leg& leg = legs[l];
    const Step& step = steps[leg.step];
    Rings& rings = rings_[l];
    const int sweeps = leg.last - leg.first;
    const int alive = window(rows_, width_, sweeps);
    const Rows start = rings.predictor.rows(alive);
    const auto state = [&](int which) {
      if (which == 0) return start;
      return which == sweeps ? rows_of(*leg.to) : rings.stages[static_cast<std::size_t>(which - 1)].rows(rows_ + 3 * width_);
    };
    FreeBox box = box_of(all_sweeps, k);
    box.j_begin = begin;
    box.j_end = end;
    if (k == 0) {
      // Rows before, in and after the box of the rank.
      const int cuts[] = {begin, std::clamp(0, begin, end), std::clamp(n_y_, begin, end), end};
      for (int part = 0; part < 3; ++part) {
        const FreeBox there{box.i_begin, box.i_end, cuts[part], cuts[part + 1]};
        if (cuts[part] < cuts[part + 1]) begin_rows(step, leg, rings, there, (1 - part) * n_y_, predictor, right_side);
      }
    } else {
      const Rows before = state(k - 1);
      complete(step, predictor, before, box);
      SbdfSweep sweep;
      sweep.t = step.t;
      sweep.gamma = step.gamma;
      sweep.shift = step.shifts[static_cast<std::size_t>(leg.first + k - 1)];
      sweep.decomposition = decomposition_;
      sweep.v = before;
      sweep.r = rings.right_side.rows(alive);
      sweep.out = state(k);
      kernel_->sweep(*diffusion_, sweep, box);
    }
    if (k < sweeps || !leg.finishes) return;
    if (leg.predictor != nullptr) {
      finished(leg.step, box, {rows_of(std::as_const(*leg.predictor)), {}, {}}, false);
    } else {
      finished(leg.step, box, {start, tests_[0].rows(alive), tests_[1].rows(alive)}, step.tests_order);
    }
  });
}

FreeBox SbdfWavefront::box_of(int sweeps, int k) const {
  // What the first sweep starts from is made at all points, the others at those that evolve.
  const FreeBox own = k == 0 ? FreeBox{0, n_x_, 0, n_y_} : free_;
  const int further = (sweeps - k) * width_;
  FreeBox box = own;
  if (left_) box.i_begin = -whole_packs(further);
  if (right_) box.i_end = n_x_ + further;
  if (lower_ || is_unrolled()) box.j_begin = -further;
  if (upper_ || is_unrolled()) box.j_end = n_y_ + further;
  return box;
}

void SbdfWavefront::line(const Step& step, Field& predictor, Field& right_side, Field& work, const Finished& finished) {
  const auto sweeps = static_cast<int>(step.shifts.size());
  const Boundary& boundary = diffusion_->boundary();
  if (boundary.has_dirichlet()) {
    boundary.impose(predictor, step.t);
    for (Field& u : line_states_) boundary.impose(u, step.t);
    boundary.impose(work, step.t);
  }
  const auto state = [&](int k) -> Field& {
    if (k == 0) return predictor;
    if (k == sweeps) return *step.u_new;
    if (has_neighbours_) return line_states_[static_cast<std::size_t>(k % 2)];
    return (sweeps - k) % 2 == 0 ? *step.u_new : work;
  };
  // Every sweep stays a pack behind the one before: further than the stencil reaches, and aligned.
  const bool around = row_halo_.wraps(0);
  passes_.clear();
  for (int k = 0; k <= sweeps; ++k) {
    FreeBox box = k == 0 ? free_ : box_of(sweeps, k);
    if (k == 0 && has_neighbours_) box.i_end = box.i_begin;  // made by the exchange
    const int from = around ? k * pack_size : box.i_begin;
    passes_.push_back({k * pack_size, from, from + box.i_end - box.i_begin});
  }
  const auto on_points = [&](std::size_t p, int begin, int end) {
    const auto k = static_cast<int>(p);
    const FreeBox box{begin, end, 0, 1};
    Field& u = state(k);
    if (k == 0) {
      make_predictor(step, rows_of(u), rows_of(right_side), box);
    } else {
      const Rows before = rows_of(state(k - 1));
      for (int s = 0; s < n_species_; ++s) row_halo_.fill_ends(before, s, box);
      SbdfSweep sweep;
      sweep.t = step.t;
      sweep.gamma = step.gamma;
      sweep.shift = step.shifts[static_cast<std::size_t>(k - 1)];
      sweep.decomposition = decomposition_;
      sweep.v = before;
      sweep.r = rows_of(std::as_const(right_side));
      sweep.out = rows_of(u);
      kernel_->sweep(*diffusion_, sweep, box);
    }
    if (k == sweeps) finished(0, box, {rows_of(std::as_const(predictor)), {}, {}}, false);
  };
  around ? wavefront_around(passes_, n_x_, piece, on_points) : wavefront(passes_, piece, on_points);
}

}  // namespace stiffront
