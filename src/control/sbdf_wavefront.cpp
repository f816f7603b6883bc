// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/sbdf_wavefront.hpp"

#include <algorithm>
#include <cstring>

namespace stiffront {
namespace {

/// What the rows of a wavefront may take of a processor's own cache, in bytes; the rest is for the history on its way
/// through.
constexpr std::ptrdiff_t cache_share = 512 * 1024;

/// Points that are taken through all sweeps at a time: enough to make what a call costs small. Measured.
constexpr int piece = 2048;

}  // namespace

/// Sweeps first .. last - 1 of a step: one pass over memory.
struct SbdfWavefront::Pass {
  int first;
  int last;
  const Field* from;  ///< the state before; nullptr: the predictor, to be made from the history
  Field* to;
  Field* predictor;   ///< kept here if there are several passes, else nullptr
  Field* right_side;  ///< likewise
  bool finishes;
};

bool SbdfWavefront::serves(const Decomposition& d, const Boundary& boundary) {
  if (boundary.has_dirichlet() || d.processes() != std::array<int, 2>{1, 1}) return false;
  return d.grid().dimension == 2 || !d.grid().periodic[0];
}

SbdfWavefront::SbdfWavefront(const Field& shape, const DiffusionOperator& diffusion, const SbdfKernel& kernel,
                             int max_sweeps, int depth)
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
      depth_(max_sweeps) {
  if (decomposition_->grid().dimension == 1) return;
  rows_ = std::clamp(piece / n_x_, 1, 16);
  // A sweep adds its own window of rows and keeps those of predictor and right side alive longer.
  const std::ptrdiff_t row = shape.row_stride() * n_species_ * static_cast<int>(sizeof(double));
  const std::ptrdiff_t fits = (cache_share / row - 2 * rows_) / (rows_ + 5 * width_);
  depth_ = depth > 0 ? depth : static_cast<int>(std::clamp<std::ptrdiff_t>(fits, 1, max_sweeps));
  // A periodic direction is unrolled once at most.
  depth_ = std::clamp(depth_, 1, std::max(1, n_y_ / width_));
  // Predictor and right side are read until the last sweep, `depth` stencils behind.
  const int alive = rows_ + (depth_ + 1) * width_;
  predictor_ring_.emplace_back(shape, alive);
  right_side_ring_.emplace_back(shape, alive);
  for (int k = 1; k < depth_; ++k) stage_rings_.emplace_back(shape, rows_ + 3 * width_);
}

void SbdfWavefront::run(const Step& step, Field& predictor, Field& right_side, Field& work, Field& u_new,
                        const Finished& finished) {
  if (decomposition_->grid().dimension == 1) {
    line(step, predictor, right_side, work, u_new, finished);
    return;
  }
  const auto sweeps = static_cast<int>(step.shifts.size());
  const int passes = (sweeps + depth_ - 1) / depth_;
  const Field* from = nullptr;
  for (int p = 0; p < passes; ++p) {
    Pass pass{};
    pass.first = sweeps * p / passes;
    pass.last = sweeps * (p + 1) / passes;
    pass.from = from;
    pass.to = (passes - 1 - p) % 2 == 0 ? &u_new : &work;
    pass.predictor = passes > 1 ? &predictor : nullptr;
    pass.right_side = passes > 1 ? &right_side : nullptr;
    pass.finishes = p == passes - 1;
    pass_over_rows(step, pass, finished);
    from = pass.to;
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

void SbdfWavefront::pass_over_rows(const Step& step, const Pass& pass, const Finished& finished) {
  const int sweeps = pass.last - pass.first;
  const Rows start = predictor_ring_[0].rows();
  const Rows right_side = right_side_ring_[0].rows();
  const auto copy = [&](const ConstRows& from, int j_from, const Rows& to, int j_to) {
    for (int s = 0; s < n_species_; ++s) {
      std::memcpy(to.row(s, j_to), from.row(s, j_from), static_cast<std::size_t>(n_x_) * sizeof(double));
    }
  };
  // What the first sweep starts from, at rows that are those `shift` further on.
  const auto begin = [&](const FreeBox& box, int shift) {
    if (pass.from == nullptr) {
      bdf_combine(step.states, step.predictor, step.history, start, right_side, box, shift);
      if (pass.predictor == nullptr || shift != 0) return;
    }
    for (int j = box.j_begin; j < box.j_end; ++j) {
      if (pass.from == nullptr) {
        copy(start, j, rows_of(*pass.predictor), j);
        copy(right_side, j, rows_of(*pass.right_side), j);
      } else {
        copy(rows_of(*pass.from), j + shift, start, j);
        copy(rows_of(*pass.right_side), j + shift, right_side, j);
      }
    }
  };

  SbdfSweep sweep;
  sweep.t = step.t;
  sweep.gamma = step.gamma;
  sweep.decomposition = decomposition_;
  sweep.r = right_side;
  // State k of the pass goes through rows -extra .. n_y - 1 + extra: a periodic direction is unrolled as far as the sweeps
  // to come look.
  const auto extra = [&](int k) { return periodic_y_ ? (sweeps - k) * width_ : 0; };
  const auto state = [&](int k) {
    if (k == 0) return start;
    return k == sweeps ? rows_of(*pass.to) : stage_rings_[static_cast<std::size_t>(k - 1)].rows();
  };
  for (int front = -extra(0); front < n_y_ + sweeps * width_; front += rows_) {
    for (int k = 0; k <= sweeps; ++k) {
      FreeBox box{0, n_x_, std::max(front - k * width_, -extra(k)),
                  std::min(front - k * width_ + rows_, n_y_ + extra(k))};
      if (box.j_begin >= box.j_end) continue;
      const Rows rows = state(k);
      if (k == 0) {
        // Rows before, in and after the box.
        const int cuts[] = {box.j_begin, std::clamp(0, box.j_begin, box.j_end), std::clamp(n_y_, box.j_begin, box.j_end),
                            box.j_end};
        for (int part = 0; part < 3; ++part) {
          const FreeBox rows_there{0, n_x_, cuts[part], cuts[part + 1]};
          if (cuts[part] < cuts[part + 1]) begin(rows_there, (1 - part) * n_y_);
        }
      } else {
        const Rows before = state(k - 1);
        if (!periodic_y_ && box.j_begin == 0) {
          for (int g = 1; g <= width_; ++g) mirror_row(before, g, -g);
        }
        sweep.shift = step.shifts[static_cast<std::size_t>(pass.first + k - 1)];
        sweep.v = before;
        sweep.out = rows;
        kernel_->sweep(*diffusion_, sweep, box);
      }
      if (k == sweeps) {
        if (pass.finishes) finished(box, pass.predictor != nullptr ? rows_of(*pass.predictor) : start);
        continue;
      }
      for (int j = box.j_begin; j < box.j_end; ++j) fill_row_ends(rows, j);
      if (!periodic_y_ && box.j_end == n_y_) {
        for (int g = 1; g <= width_; ++g) mirror_row(rows, n_y_ - 1 - g, n_y_ - 1 + g);
      }
    }
  }
}

void SbdfWavefront::line(const Step& step, Field& predictor, Field& right_side, Field& work, Field& u_new,
                         const Finished& finished) {
  const auto sweeps = static_cast<int>(step.shifts.size());
  SbdfSweep sweep;
  sweep.t = step.t;
  sweep.gamma = step.gamma;
  sweep.decomposition = decomposition_;
  sweep.r = rows_of(right_side);
  const auto state = [&](int k) -> Field& {
    if (k == 0) return predictor;
    return (sweeps - k) % 2 == 0 ? u_new : work;
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
        bdf_combine(step.states, step.predictor, step.history, rows_of(u), rows_of(right_side), box);
      } else {
        sweep.shift = step.shifts[static_cast<std::size_t>(k - 1)];
        sweep.v = rows_of(state(k - 1));
        sweep.out = rows_of(u);
        kernel_->sweep(*diffusion_, sweep, box);
      }
      if (k == sweeps) {
        finished(box, rows_of(predictor));
        break;
      }
      if (box.i_begin == 0) fill_end(u, 0, 1);
      if (last) fill_end(u, n_x_ - 1, -1);
    }
  }
}

}  // namespace stiffront
