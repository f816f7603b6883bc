// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "stiffront/core/mpi.hpp"
#include "stiffront/mesh/boundary.hpp"
#include "stiffront/mesh/field.hpp"
#include "stiffront/mesh/field_algebra.hpp"

namespace stiffront {

/// The norm of the splitting methods: for each controlled species the root mean square of a difference over the evolving points,
/// divided by the largest modulus of the species or its floor if that is larger; the largest over the controlled species.
///
/// Contributions of all ranks travel in one agreement, several norms at a time: a norm takes one slot, n_species sums each; the
/// scales take n_species maxima.
class StateNorm {
 public:
  /// @param species controlled species; empty: all.
  StateNorm(const Decomposition& decomposition, const Boundary& boundary, int n_species, std::vector<int> species);

  int n_controlled() const { return static_cast<int>(species_.size()); }
  /// Least scale of every species, one entry each; empty: none. See floors_of_absent_species.
  void set_floors(std::vector<double> floors) { floors_ = std::move(floors); }
  std::vector<double>& floors() { return floors_; }
  /// An agreement with room for the given number of norms.
  Agreement agreement(int norms) const { return Agreement(norms * n_controlled(), n_controlled()); }
  /// The same in place, so that an agreement can be used again.
  void prepare(int norms, Agreement& agreement) const {
    agreement.sums.assign(static_cast<std::size_t>(norms * n_controlled()), ReproducibleSum());
    agreement.maxima.assign(static_cast<std::size_t>(n_controlled()), 0.0);
  }
  /// Adds this rank's part of |a - b| in the given slot. @cost one pass over both.
  void add_difference(const Field& a, const Field& b, int slot, Agreement& agreement) const;
  /// Adds this rank's part of |sum of the terms|. @cost one pass over all of them.
  void add_combination(std::span<const Term> terms, int slot, Agreement& agreement) const;
  /// Adds this rank's part of the scales.
  void add_scale(const Field& u, Agreement& agreement) const;
  /// The norm after the agreement. NaN if a difference was not finite.
  double value(int slot, const Agreement& agreement) const;
  /// The same of the controlled species number k alone.
  double value(int slot, int k, const Agreement& agreement) const;

 private:
  template <class Value>
  void add_squares(int slot, Agreement& agreement, Value&& value) const;

  FreeBox free_;
  double points_;
  std::vector<int> species_;
  std::vector<double> floors_;
};

/// step_flags of a state: not_finite, negative. @cost one pass.
std::uint64_t inspect(const Field& u, const FreeBox& box);

}  // namespace stiffront
