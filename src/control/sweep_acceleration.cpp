// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/sweep_acceleration.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "stiffront/core/mpi.hpp"
#include "stiffront/mesh/field_algebra.hpp"
#include "stiffront/space/laplacian.hpp"

namespace stiffront {
namespace {

std::vector<Field> fields(const Field& shape, std::size_t n) {
  std::vector<Field> f;
  for (std::size_t i = 0; i < n; ++i) f.push_back(shape.similar());
  return f;
}

/// y = a x + b y
void combine_sets(double a, std::span<const Field> x, double b, std::span<Field> y) {
  for (std::size_t i = 0; i < y.size(); ++i) {
    const std::array<Term, 2> terms{Term{a, &x[i]}, Term{b, &y[i]}};
    combine(terms, y[i]);
  }
}

void copy_sets(std::span<const Field> from, std::span<Field> to) {
  for (std::size_t i = 0; i < to.size(); ++i) to[i].copy_interior(from[i]);
}

// A new difference of which the older ones leave less than this adds nothing but round-off.
constexpr double least_new_part = 1e-10;

}  // namespace

SweepAcceleration::SweepAcceleration(const Field& shape, const FreeBox& free, std::size_t n_fields, std::size_t depth)
    : free_(free), n_fields_(n_fields), comm_(&shape.comm()), last_v_(fields(shape, n_fields)), last_residual_(fields(shape, n_fields)) {
  for (std::size_t k = 0; k < depth; ++k) {
    q_.push_back(fields(shape, n_fields));
    w_.push_back(fields(shape, n_fields));
  }
}

void SweepAcceleration::reset(std::span<const double> scales) {
  inverse_scales_.clear();
  for (double s : scales) inverse_scales_.push_back(s > 0.0 ? 1.0 / s : 1.0);
  known_ = 0;
  has_last_ = false;
}

std::vector<double> SweepAcceleration::products(std::span<const std::span<const Field>> sets, std::span<const Field> x) const {
  Agreement agreement(static_cast<int>(sets.size()), 0);
  for (std::size_t k = 0; k < sets.size(); ++k) {
    for (std::size_t f = 0; f < n_fields_; ++f) {
      for (int s = 0; s < x[f].n_species(); ++s) {
        const Pack weight(inverse_scales_[static_cast<std::size_t>(s)] * inverse_scales_[static_cast<std::size_t>(s)]);
        for (int j = free_.j_begin; j < free_.j_end; ++j) {
          const double* p = sets[k][f].row(s, j);
          const double* q = x[f].row(s, j);
          for_each_pack(free_.i_begin, free_.i_end, [&](int i, int n) {
            const Pack product = Pack::load_partial(p + i, n) * Pack::load_partial(q + i, n) * weight;
            agreement.sums[k].add(product, Mask::first(n));
          });
        }
      }
    }
  }
  comm_->agree(agreement);
  std::vector<double> values;
  for (const ReproducibleSum& sum : agreement.sums) values.push_back(sum.value());
  return values;
}

void SweepAcceleration::next(std::span<Field> v, std::span<const Field> residual) {
  if (has_last_ && known_ < q_.size()) {
    // The new differences, made orthogonal to the older ones, twice for the digits.
    std::vector<Field>& q = q_[known_];
    std::vector<Field>& w = w_[known_];
    copy_sets(residual, q);
    copy_sets(v, w);
    combine_sets(-1.0, last_residual_, 1.0, q);
    combine_sets(-1.0, last_v_, 1.0, w);
    double whole = 0.0;
    double left = 0.0;
    for (int pass = 0; pass < 2; ++pass) {
      std::vector<std::span<const Field>> sets(q_.begin(), q_.begin() + static_cast<std::ptrdiff_t>(known_) + 1);
      const std::vector<double> c = products(sets, q);
      if (pass == 0) whole = c.back();
      left = c.back();
      for (std::size_t k = 0; k < known_; ++k) {
        combine_sets(-c[k], q_[k], 1.0, q);
        combine_sets(-c[k], w_[k], 1.0, w);
        left -= c[k] * c[k];
      }
    }
    if (left > least_new_part * least_new_part * whole && std::isfinite(left)) {
      const double scale = 1.0 / std::sqrt(left);
      combine_sets(0.0, q, scale, q);
      combine_sets(0.0, w, scale, w);
      ++known_;
    }
  }
  copy_sets(v, last_v_);
  copy_sets(residual, last_residual_);
  has_last_ = true;

  std::vector<double> c;
  if (known_ > 0) {
    std::vector<std::span<const Field>> sets(q_.begin(), q_.begin() + static_cast<std::ptrdiff_t>(known_));
    c = products(sets, residual);
  }
  combine_sets(1.0, residual, 1.0, v);
  for (std::size_t k = 0; k < known_; ++k) {
    combine_sets(-c[k], w_[k], 1.0, v);
    combine_sets(-c[k], q_[k], 1.0, v);
  }
}

}  // namespace stiffront
