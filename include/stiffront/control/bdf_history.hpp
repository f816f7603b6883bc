// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <span>

#include "stiffront/core/reproducible_sum.hpp"
#include "stiffront/mesh/boundary.hpp"
#include "stiffront/mesh/rows.hpp"

namespace stiffront {

/// At most this many earlier states take part in a step of a multistep method: predictor of order 5 or error of order 5
/// from order 4.
inline constexpr std::size_t bdf_max_points = 6;

/// A combination sum_i weight_i v_i of earlier states, newest first.
using BdfWeights = std::array<double, bdf_max_points>;

/// predictor = sum e_i v_i and right_side = sum w_i v_i at the points of the box, in one pass. Row j of the results comes
/// from row j + shift of the states.
/// @pre the outputs are none of the states; 1 <= states.size() <= bdf_max_points
void bdf_combine(std::span<const Field* const> states, const BdfWeights& e, const BdfWeights& w, const Rows& predictor,
                 const Rows& right_side, const FreeBox& box, int shift = 0);

/// Scales of the error of a species: |error| <= absolute + relative |v|.
struct BdfTolerances {
  double relative = 0.0;
  std::span<const double> absolute;  ///< one per species, > 0
};

/// Adds, over the cells of the box, the square of the sum over species of ((v - reference)/(absolute + relative
/// |v|))^2.
///
/// The error norm is the fourth root of the mean: a spot of 1 % of the cells enters with a third of its size, where it
/// would enter the root mean square with a tenth.
/// @return whether v is negative anywhere
bool bdf_add_difference(const Field& v, const ConstRows& reference, const BdfTolerances& tolerances, const FreeBox& box,
                        ReproducibleSum& sum);

/// What a test of other orders needs: sums as above of the differences of v to the predictor in use and to those of a
/// lower and a higher order.
struct BdfOrderSums {
  ReproducibleSum& lower;
  ReproducibleSum& same;
  ReproducibleSum& upper;
};

/// Predictors at the points of some box.
struct BdfPredictors {
  ConstRows same;
  ConstRows lower;  ///< of the neighbouring orders, in a test of them
  ConstRows upper;
};

/// Gathers them in one pass.
/// @param with_upper whether the upper sum is wanted
/// @param extremes largest v_s and then largest -v_s so far, one pack per species each, raised lane by lane where v is
/// larger
void bdf_add_order_differences(const Field& v, const BdfPredictors& predictors, bool with_upper, const BdfTolerances& tolerances,
                               const FreeBox& box, const BdfOrderSums& sums, std::span<Pack> extremes);

}  // namespace stiffront
