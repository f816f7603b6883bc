// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/space/line_derivatives.hpp"

#include "stiffront/space/centred_difference.hpp"
#include "stiffront/space/laplacian.hpp"
#include "stiffront/space/sub_cell_closure.hpp"

namespace stiffront {
namespace {

/// result = factor times centred(u + i), and factor times the closure's difference at its points.
template <class Centred>
void differentiate(const Field& u, Field& result, const FreeBox& box, double factor, bool odd, const SubCellClosure::Weights& weights,
                   Centred&& centred) {
  const ClosedEnds ends(u.decomposition(), 0);
  for (int s = 0; s < u.n_species(); ++s) {
    const double* const in = u.row(s, 0);
    double* const out = result.row(s, 0);
    for_each_pack(box.i_begin, box.i_end, [&](int i, int n) { (Pack(factor) * centred(in + i)).store_partial(out + i, n); });
    ends.for_each(box.i_begin, box.i_end, u.n_x(), [&](int i, int row, int first, int inwards) {
      const double signed_factor = odd && inwards < 0 ? -factor : factor;
      out[i] = signed_factor * closed_difference<double>(weights, row, [&](int k) { return in[first + k * inwards]; });
    });
  }
}

}  // namespace

void LineDerivatives::first(const Field& u, Field& u_x, const FreeBox& box) const {
  const SubCellClosure::Weights& weights = SubCellClosure::get().first;
  const double factor = 1.0 / spacing_;
  const auto apply = [&](auto centred) { differentiate(u, u_x, box, factor, true, weights, centred); };
  switch (order_) {
    case 2:
      apply([](const double* p) { return first_difference<2>(p); });
      break;
    case 4:
      apply([](const double* p) { return first_difference<4>(p); });
      break;
    default:
      apply([](const double* p) { return first_difference<8>(p); });
  }
}

void LineDerivatives::second(const Field& u, Field& u_xx, const FreeBox& box) const {
  const SubCellClosure::Weights& weights = SubCellClosure::get().second;
  const double factor = 1.0 / (spacing_ * spacing_);
  const auto apply = [&](auto centred) { differentiate(u, u_xx, box, factor, false, weights, centred); };
  switch (order_) {
    case 2:
      apply([](const double* p) { return second_difference<2>(p, 1, Pack::load(p)); });
      break;
    case 4:
      apply([](const double* p) { return second_difference<4>(p, 1, Pack::load(p)); });
      break;
    default:
      apply([](const double* p) { return second_difference_of_order_8(p, 1, Pack::load(p)); });
  }
}

}  // namespace stiffront
