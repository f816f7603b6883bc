// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>

#include "stiffront/core/aligned_array.hpp"
#include "stiffront/core/simd.hpp"
#include "stiffront/mesh/field.hpp"

namespace stiffront {

/// Where the numbers of a box of points are: component c of point i of row j at row(c, j)[i]. Halo points and, beyond a row's end, one
/// pack may be read.
struct PlaneView {
  double* first;  ///< point 0 of row 0 of component 0
  std::ptrdiff_t component_stride;
  std::ptrdiff_t row_stride;

  double* row(int c, int j) const { return first + c * component_stride + j * row_stride; }
};

/// @pre u has a halo of one point at least
inline PlaneView view(Field& u) { return {u.row(0, 0), u.species_stride(), u.row_stride()}; }

/// Zeros on a box of points with a halo of one point all around; padding stays zero.
class Plane {
 public:
  Plane(int n_components, int n_x, int n_y)
      : row_stride_((n_x + pack_size - 1) / pack_size * pack_size + 3 * pack_size), component_stride_(row_stride_ * (n_y + 2)) {
    data_ = aligned_zeros(static_cast<std::size_t>(component_stride_) * static_cast<std::size_t>(n_components));
  }
  operator PlaneView() const { return {data_.get() + row_stride_ + pack_size, component_stride_, row_stride_}; }
  double* row(int c, int j) const { return static_cast<PlaneView>(*this).row(c, j); }

 private:
  std::ptrdiff_t row_stride_;
  std::ptrdiff_t component_stride_;
  AlignedArray data_;
};

}  // namespace stiffront
