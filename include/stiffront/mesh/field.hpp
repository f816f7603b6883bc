// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <utility>

#include "stiffront/core/aligned_array.hpp"
#include "stiffront/mesh/decomposition.hpp"

namespace stiffront {

/// The values of all species on this rank's box, with a halo around it.
///
/// Each species is one contiguous block of rows; the first interior point of every row is aligned to 64 bytes and rows are
/// padded so that whole packs may be read up to the end of the halo. A fresh field is zero everywhere; padding stays zero, so
/// nothing that reads beyond a row ever meets a number that was not put there.
///
/// @shape n_species x (n_y + 2 halo_y) x (n_x + 2 halo); in one dimension n_y = 1 and halo_y = 0.
class Field {
 public:
  Field(const Decomposition& decomposition, int n_species, int halo);
  Field(Field&&) noexcept = default;
  Field& operator=(Field&&) noexcept = default;

  const Decomposition& decomposition() const { return *decomposition_; }
  const Communicator& comm() const { return decomposition_->comm(); }
  int n_species() const { return n_species_; }
  int halo() const { return halo_; }
  int halo_y() const { return halo_y_; }
  int n_x() const { return n_x_; }
  int n_y() const { return n_y_; }
  std::ptrdiff_t row_stride() const { return row_stride_; }
  std::ptrdiff_t species_stride() const { return species_stride_; }

  /// Address of interior point 0 of row j, -halo_y <= j < n_y + halo_y. Points -halo .. n_x + halo - 1 exist.
  double* row(int species, int j) { return data_.get() + origin_ + species * species_stride_ + j * row_stride_; }
  const double* row(int species, int j) const { return data_.get() + origin_ + species * species_stride_ + j * row_stride_; }
  double& at(int species, int i, int j = 0) { return row(species, j)[i]; }
  double at(int species, int i, int j = 0) const { return row(species, j)[i]; }

  /// Copies the interior of another field of the same shape.
  void copy_interior(const Field& other);
  void copy_interior(const Field& other, int species);
  /// An empty field of the same shape.
  Field similar() const { return Field(*decomposition_, n_species_, halo_); }
  std::size_t bytes() const { return size_ * sizeof(double); }

  friend void swap(Field& a, Field& b) noexcept {
    Field c(std::move(a));
    a = std::move(b);
    b = std::move(c);
  }

 private:
  const Decomposition* decomposition_;
  int n_species_;
  int halo_;
  int halo_y_;
  int n_x_;
  int n_y_;
  std::ptrdiff_t row_stride_;
  std::ptrdiff_t species_stride_;
  std::ptrdiff_t origin_;
  std::size_t size_;
  AlignedArray data_;
};

}  // namespace stiffront
