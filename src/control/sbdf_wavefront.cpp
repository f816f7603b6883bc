// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/sbdf_wavefront.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

namespace stiffront {
namespace {

/// What the rows of a wavefront may take of a processor's caches, in bytes: some of the last level too, since a pass more
/// over memory costs more.
constexpr std::ptrdiff_t cache_share = 2048 * 1024;

/// A history of more than this is not in cache from one step to the next, and several steps at a time gain.
constexpr std::ptrdiff_t last_level = 16 * 1024 * 1024;

/// Points that are taken through all sweeps at a time: enough to make what a call costs small. Measured.
constexpr int piece = 2048;

}  // namespace

bool SbdfWavefront::serves(const Decomposition& d, const Boundary& boundary) {
  if (boundary.has_dirichlet() || d.processes() != std::array<int, 2>{1, 1}) return false;
  return d.grid().dimension == 2 || !d.grid().periodic[0];
}

SbdfWavefront::Rings::Rings(const Field& shape, int rows, int width, int sweeps)
    // Predictor and right side are read until the last sweep, `sweeps` stencils behind.
    : predictor(shape, rows + (sweeps + 1) * width), right_side(shape, rows + (sweeps + 1) * width) {
  for (int k = 1; k < sweeps; ++k) stages.emplace_back(shape, rows + 3 * width);
}

SbdfWavefront::SbdfWavefront(const Field& shape, const DiffusionOperator& diffusion, const SbdfKernel& kernel,
                             int max_sweeps, int depth, int together)
    : decomposition_(&shape.decomposition()),
      diffusion_(&diffusion),
      kernel_(&kernel),
      n_species_(shape.n_species()),
      n_x_(shape.n_x()),
      n_y_(shape.n_y()),
      width_(diffusion.halo_width()),
      periodic_x_(decomposition_->grid().periodic[0]),
      periodic_y_(decomposition_->grid().periodic[1]),
      row_length_(n_x_ + 2 * width_),
      row_bytes_(shape.row_stride() * n_species_ * static_cast<int>(sizeof(double))),
      depth_(max_sweeps),
      together_(together) {
  if (decomposition_->grid().dimension == 1) return;
  rows_ = std::clamp(piece / n_x_, 1, 16);
  // A sweep adds its own window of rows and keeps those of predictor and right side alive longer.
  const std::ptrdiff_t fits = (cache_share / row_bytes_ - 2 * rows_) / (rows_ + 5 * width_);
  depth_ = depth > 0 ? depth : static_cast<int>(std::clamp<std::ptrdiff_t>(fits, 1, max_sweeps));
  // A periodic direction is unrolled once at most.
  depth_ = std::clamp(depth_, 1, std::max(1, n_y_ / width_));
  rings_.emplace_back(shape, rows_, width_, depth_);
  int most = 1;
  for (int sweeps = 1; sweeps <= depth_; ++sweeps) most = std::max(most, steps_together(sweeps));
  for (int k = 1; k < most; ++k) rings_.emplace_back(shape, rows_, width_, depth_);
  for (int k = 0; k < 2; ++k) tests_.emplace_back(shape, rows_ + (depth_ + 1) * width_);
}

int SbdfWavefront::steps_together(int sweeps) const {
  if (decomposition_->grid().dimension == 1 || periodic_y_ || sweeps > depth_) return 1;
  if (together_ > 0) return std::min(together_, max_steps);
  return row_bytes_ * n_y_ * static_cast<std::ptrdiff_t>(bdf_max_points) > last_level ? max_steps : 1;
}

void SbdfWavefront::run(std::span<const Step> steps, Field& predictor, Field& right_side, Field& work, const Finished& finished) {
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
    pass_over_rows(steps, std::span(legs).first(steps.size()), finished);
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
    pass_over_rows(steps, std::span(legs).first(1), finished);
    from = leg.to;
  }
}

void SbdfWavefront::fill_row_ends(const Rows& rows, int j) const {
  for (int s = 0; s < n_species_; ++s) {
    double* const row = rows.row(s, j);
    for (int k = 1; k <= width_; ++k) {
      row[-k] = periodic_x_ ? row[n_x_ - k] : row[k];
      row[n_x_ - 1 + k] = periodic_x_ ? row[k - 1] : row[n_x_ - 1 - k];
    }
  }
}

void SbdfWavefront::mirror_row(const Rows& rows, int from, int to) const {
  for (int s = 0; s < n_species_; ++s) {
    std::memcpy(rows.row(s, to) - width_, rows.row(s, from) - width_,
                static_cast<std::size_t>(row_length_) * sizeof(double));
  }
}

/// What the first sweep of a leg starts from, at rows that are those `shift` further on.
void SbdfWavefront::begin_rows(const Step& step, const Leg& leg, Rings& rings, const FreeBox& box, int shift) {
  const Rows start = rings.predictor.rows();
  const Rows right_side = rings.right_side.rows();
  const auto copy = [&](const ConstRows& from, int j_from, const Rows& to, int j_to) {
    for (int s = 0; s < n_species_; ++s) {
      std::memcpy(to.row(s, j_to), from.row(s, j_from), static_cast<std::size_t>(n_x_) * sizeof(double));
    }
  };
  if (leg.from == nullptr) {
    bdf_combine(step.states.first(static_cast<std::size_t>(step.points)), step.predictor, step.history, start, right_side, box, shift);
    if (leg.predictor == nullptr) {
      if (step.tests_order) bdf_combine(step.states, step.lower, step.upper, tests_[0].rows(), tests_[1].rows(), box, shift);
      return;
    }
    if (shift != 0) return;
  }
  for (int j = box.j_begin; j < box.j_end; ++j) {
    if (leg.from == nullptr) {
      copy(start, j, rows_of(*leg.predictor), j);
      copy(right_side, j, rows_of(*leg.right_side), j);
    } else {
      copy(rows_of(*leg.from), j + shift, start, j);
      copy(rows_of(*leg.right_side), j + shift, right_side, j);
    }
  }
}

void SbdfWavefront::pass_over_rows(std::span<const Step> steps, std::span<const Leg> legs, const Finished& finished) {
  int all_sweeps = 0;
  for (const Leg& leg : legs) all_sweeps += leg.last - leg.first;
  // A periodic direction, if there is one leg, is unrolled as far as the sweeps to come look: state k of it goes through
  // rows -extra .. n_y - 1 + extra.
  const auto extra = [&](int k) { return periodic_y_ ? (all_sweeps - k) * width_ : 0; };

  for (int front = -extra(0); front < n_y_ + all_sweeps * width_; front += rows_) {
    int behind = 0;  // sweeps of the legs before
    for (std::size_t l = 0; l < legs.size(); ++l) {
      const Leg& leg = legs[l];
      const Step& step = steps[leg.step];
      Rings& rings = rings_[l];
      const int sweeps = leg.last - leg.first;
      const Rows start = rings.predictor.rows();
      const auto state = [&](int k) {
        if (k == 0) return start;
        return k == sweeps ? rows_of(*leg.to) : rings.stages[static_cast<std::size_t>(k - 1)].rows();
      };
      SbdfSweep sweep;
      sweep.t = step.t;
      sweep.gamma = step.gamma;
      sweep.decomposition = decomposition_;
      sweep.r = rings.right_side.rows();
      for (int k = 0; k <= sweeps; ++k) {
        const int at = front - (behind + k) * width_;
        const FreeBox box{0, n_x_, std::max(at, -extra(k)), std::min(at + rows_, n_y_ + extra(k))};
        if (box.j_begin >= box.j_end) continue;
        const Rows rows = state(k);
        if (k == 0) {
          // Rows before, in and after the box of the rank.
          const int cuts[] = {box.j_begin, std::clamp(0, box.j_begin, box.j_end), std::clamp(n_y_, box.j_begin, box.j_end),
                              box.j_end};
          for (int part = 0; part < 3; ++part) {
            const FreeBox there{0, n_x_, cuts[part], cuts[part + 1]};
            if (cuts[part] < cuts[part + 1]) begin_rows(step, leg, rings, there, (1 - part) * n_y_);
          }
        } else {
          const Rows before = state(k - 1);
          if (!periodic_y_ && box.j_begin == 0) {
            for (int g = 1; g <= width_; ++g) mirror_row(before, g, -g);
          }
          sweep.shift = step.shifts[static_cast<std::size_t>(leg.first + k - 1)];
          sweep.v = before;
          sweep.out = rows;
          kernel_->sweep(*diffusion_, sweep, box);
        }
        if (k == sweeps) {
          if (!leg.finishes) continue;
          if (leg.predictor != nullptr) {
            finished(leg.step, box, {rows_of(std::as_const(*leg.predictor)), {}, {}}, false);
          } else {
            finished(leg.step, box, {start, tests_[0].rows(), tests_[1].rows()}, step.tests_order);
          }
          continue;
        }
        for (int j = box.j_begin; j < box.j_end; ++j) fill_row_ends(rows, j);
        if (!periodic_y_ && box.j_end == n_y_) {
          for (int g = 1; g <= width_; ++g) mirror_row(rows, n_y_ - 1 - g, n_y_ - 1 + g);
        }
      }
      behind += sweeps;
    }
  }
}

void SbdfWavefront::line(const Step& step, Field& predictor, Field& right_side, Field& work, const Finished& finished) {
  const auto sweeps = static_cast<int>(step.shifts.size());
  SbdfSweep sweep;
  sweep.t = step.t;
  sweep.gamma = step.gamma;
  sweep.decomposition = decomposition_;
  sweep.r = rows_of(right_side);
  const auto state = [&](int k) -> Field& {
    if (k == 0) return predictor;
    return (sweeps - k) % 2 == 0 ? *step.u_new : work;
  };
  const auto fill_end = [&](Field& u, int end, int inwards) {
    for (int s : diffusion_->diffusing_species()) {
      double* const row = u.row(s, 0);
      for (int k = 1; k <= width_; ++k) row[end - k * inwards] = row[end + k * inwards];
    }
  };
  for (int begin = 0; begin < n_x_; begin += piece) {
    const bool last = begin + piece >= n_x_;
    for (int k = 0; k <= sweeps; ++k) {
      // Every sweep stays a pack behind the one before: further than the stencil reaches, and aligned.
      FreeBox box{std::max(0, begin - k * pack_size), last ? n_x_ : std::max(0, begin + piece - k * pack_size), 0, 1};
      if (box.i_begin == box.i_end) break;
      Field& u = state(k);
      if (k == 0) {
        bdf_combine(step.states.first(static_cast<std::size_t>(step.points)), step.predictor, step.history, rows_of(u),
                    rows_of(right_side), box);
      } else {
        sweep.shift = step.shifts[static_cast<std::size_t>(k - 1)];
        sweep.v = rows_of(state(k - 1));
        sweep.out = rows_of(u);
        kernel_->sweep(*diffusion_, sweep, box);
      }
      if (k == sweeps) {
        finished(0, box, {rows_of(std::as_const(predictor)), {}, {}}, false);
        break;
      }
      if (box.i_begin == 0) fill_end(u, 0, 1);
      if (last) fill_end(u, n_x_ - 1, -1);
    }
  }
}

}  // namespace stiffront
