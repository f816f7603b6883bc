// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/stability_domain.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "stiffront/core/error.hpp"

namespace stiffront {
namespace {

using Options = SpectralDeferredCorrectionOptions;

Options method(NodeFamily nodes, int m, int k, int corrections, Options::FinalUpdate final_update, bool consistent = true) {
  Options o;
  o.nodes = nodes;
  o.node_count = m;
  o.starting_order = k;
  o.corrections = corrections;
  o.final_update = final_update;
  o.consistent = consistent;
  o.fixed_step = 1.0;
  return o;
}

constexpr double none = 0.0;

struct Row {
  const char* name;
  Options options;
  double area;
  double real_axis;  ///< none: beyond 1e4
  std::vector<double> beta;
};

constexpr auto legendre = NodeFamily::gauss_legendre;
constexpr auto radau = NodeFamily::gauss_radau;
constexpr auto lobatto = NodeFamily::gauss_lobatto;
constexpr auto quadrature = Options::FinalUpdate::quadrature;
constexpr auto node = Options::FinalUpdate::last_node;
constexpr auto extrapolation = Options::FinalUpdate::extrapolation;

TEST(StabilityDomainTest, IsThatOfAnIndependentImplementation) {
  const std::vector<double> at{-0.1, -1.0, -5.0, -10.0, -20.0, -40.0};
  const std::vector<Row> rows = {
      {"Legendre 3", method(legendre, 3, 2, 4, quadrature), 253.3, 59.75, {2.755, 3.291, 4.129, 4.797, 5.419, 4.483}},
      {"Legendre 4", method(legendre, 4, 2, 6, quadrature), 447.6, 118.47, {3.636, 4.431, 5.038, 5.829, 7.042, 8.467}},
      {"Legendre 6 inconsistent", method(legendre, 6, 2, 10, quadrature, false), 690.0, none, {4.962, 5.471, 6.749, 8.157, 10.415, 13.354}},
      {"Legendre 6, k = 1", method(legendre, 6, 1, 11, quadrature), 839.8, 2609.0, {5.808, 6.250, 8.137, 9.334, 11.615, 16.297}},
      {"Legendre 6, k = 5", method(legendre, 6, 5, 7, quadrature), 74.8, 37.28, {3.958, 4.384, 3.571, 2.849, 1.646, 0.0}},
      {"Radau 4", method(radau, 4, 2, 5, node), 689.1, none, {3.858, 4.079, 5.122, 6.436, 8.999, 14.022}},
      {"Radau 6 inconsistent", method(radau, 6, 2, 9, node, false), 894.7, none, {5.283, 5.696, 7.436, 9.270, 12.441, 17.855}},
      {"Figure 8, Legendre", method(legendre, 5, 2, 6, quadrature), 465.9, 175.74, {4.561, 5.302, 5.703, 6.358, 7.424, 8.626}},
      {"Figure 8, Radau", method(radau, 5, 2, 6, quadrature), 492.8, none, {3.776, 4.809, 5.615, 6.266, 7.455, 9.277}},
      {"Figure 8, Lobatto", method(lobatto, 5, 2, 6, quadrature), 247.4, 49.44, {3.679, 4.318, 4.999, 5.585, 6.013, 4.426}},
  };
  for (const Row& row : rows) {
    const StabilityDomain d = stability_domain(row.options, {}, at);
    EXPECT_NEAR(d.area / row.area, 1.0, 0.01) << row.name;
    EXPECT_NEAR(d.real_axis.value_or(none), row.real_axis, 0.01 * row.real_axis) << row.name;
    for (std::size_t i = 0; i < at.size(); ++i) {
      ASSERT_TRUE(d.beta[i]) << row.name << " at " << at[i];
      EXPECT_NEAR(*d.beta[i], row.beta[i], 0.01 * row.beta[i] + 1e-6) << row.name << " at " << at[i];
    }
  }
}

TEST(StabilityDomainTest, PreconditionedSplittingsHaveTheLimitsOfAnIndependentImplementation) {
  const auto axis = [](Options o, double part) { return stability_domain(o, {part, part}, {}).real_axis.value_or(none); };
  EXPECT_NEAR(axis(method(legendre, 4, 1, 7, quadrature), 0.75), 814.3, 8.1);
  EXPECT_NEAR(axis(method(legendre, 4, 1, 7, quadrature), 1.25), 140.9, 1.4);
  EXPECT_NEAR(axis(method(radau, 4, 1, 6, quadrature), 1.25), 2382.6, 23.8);
  EXPECT_EQ(axis(method(radau, 4, 1, 6, node), 1.25), none);
}

TEST(StabilityDomainTest, DampsWhatIsInfinitelyStiffWithTheLastNodeOfRadau) {
  const auto damping = [](int m, int k, bool consistent) {
    return stability_domain(method(radau, m, k, 2 * m - 1 - k, node, consistent), {1.25, 1.25}, {}).at_infinity;
  };
  EXPECT_NEAR(damping(4, 1, true), 0.0275, 3e-4);
  EXPECT_NEAR(damping(4, 2, true), 0.2008, 2e-3);
  EXPECT_NEAR(damping(4, 3, false), 0.3676, 4e-3);
  EXPECT_NEAR(damping(6, 2, false), 0.0163, 2e-4);
}

TEST(StabilityDomainTest, ContainsTheStepsOfTheMethodAndRefusesWhatIsNotLinear) {
  // One step without history or corrections is implicit Euler on three nodes' worth of substeps: exactly known.
  Options o = method(radau, 2, 1, 0, node);
  const std::complex<double> z(-3.0, 0.0);
  EXPECT_NEAR(amplification(o, {}, std::span(&z, 1)).front(), 1.0 / ((1.0 + 1.0) * (1.0 + 2.0)), 1e-14);
  o.accelerate = true;
  EXPECT_THROW(amplification(o, {}, std::span(&z, 1)), Error);
}

}  // namespace
}  // namespace stiffront
