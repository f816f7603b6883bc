// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/mesh/field_algebra.hpp"

#include "stiffront/core/simd.hpp"

namespace stiffront {

void combine(std::span<const Term> terms, Field& result) {
  for (int s = 0; s < result.n_species(); ++s) {
    for (int j = 0; j < result.n_y(); ++j) {
      double* out = result.row(s, j);
      for (int i = 0; i < result.n_x(); i += pack_size) {
        const int n = result.n_x() - i < pack_size ? result.n_x() - i : pack_size;
        Pack sum = Pack(terms[0].factor) * Pack::load(terms[0].field->row(s, j) + i);
        for (std::size_t k = 1; k < terms.size(); ++k) {
          sum = mul_add(Pack(terms[k].factor), Pack::load(terms[k].field->row(s, j) + i), sum);
        }
        sum.store_partial(out + i, n);
      }
    }
  }
}

}  // namespace stiffront
