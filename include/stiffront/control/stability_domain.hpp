// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <complex>
#include <optional>
#include <span>
#include <vector>

#include "stiffront/control/spectral_deferred_correction.hpp"

namespace stiffront {

/// The test equation u' = (alpha + i beta) u, of which d_r alpha + i d_i beta is treated implicitly. (1, 0) is the IMEX splitting of the
/// paper's section 5.1; section 5.2, equation (5-8), has both at 3/4 or 5/4.
struct TestSplitting {
  double real = 1.0;
  double imaginary = 0.0;
};

/// The spectral radius of the amplification matrix of a step of SDC for every z = dT (alpha + i beta): the map of the state and the
/// stages kept as history onto those one step later. It is found column by column by steps of the method itself.
/// @param o with a fixed step, whose size plays no part, and without acceleration, which is not linear
std::vector<double> amplification(const SpectralDeferredCorrectionOptions& o, TestSplitting splitting,
                                  std::span<const std::complex<double>> z);

/// Where steps are stable: the spectral radius is at most 1 + 1e-8.
bool is_stable(double spectral_radius);

/// Measures of a domain of stability in the left half-plane, after figures 6 to 12 of the paper.
struct StabilityDomain {
  static constexpr int cells = 241;  ///< per direction of the raster
  static constexpr double raster_left = -60.0;
  static constexpr double raster_top = 40.0;
  static constexpr double axis_end = 1e4;
  static constexpr double strip_end = 80.0;

  /// Radii at the centres of the cells of [-60, 0] x [0, 40], row by row from beta = 0 upwards, from alpha = -60 on.
  std::vector<double> raster;
  double area = 0.0;                        ///< of the stable cells
  std::optional<double> real_axis;          ///< first exit along the negative real axis; nothing up to 1e4
  std::vector<double> at;                   ///< values of alpha
  std::vector<std::optional<double>> beta;  ///< the first exit upwards from each; nothing up to 80
  double at_infinity = 0.0;                 ///< radius at z = -1e8
};

StabilityDomain stability_domain(const SpectralDeferredCorrectionOptions& o, TestSplitting splitting, std::vector<double> at);

}  // namespace stiffront
