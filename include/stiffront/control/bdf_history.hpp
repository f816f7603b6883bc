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

/// Predictors at the points of some box.
struct BdfPredictors {
  ConstRows same;
  ConstRows lower;  ///< of the neighbouring orders, in a test of them
  ConstRows upper;
};

/// Adds, for one to three references, over the cells of the box, the square of the sum over species of
/// ((v - reference)/(absolute + relative |v|))^2, in one pass.
///
/// The error norm is the fourth root of the mean: a spot of 1 % of the cells enters with a third of its size, where it
/// would enter the root mean square with a tenth.
/// @param sums one per reference
/// @param extremes largest v_s and then largest -v_s so far, one pack per species each, raised lane by lane where v is
/// larger
void bdf_add_differences(const Field& v, std::span<const ConstRows> references, const BdfTolerances& tolerances, const FreeBox& box,
                         std::span<ReproducibleSum> sums, std::span<Pack> extremes);

}  // namespace stiffront
