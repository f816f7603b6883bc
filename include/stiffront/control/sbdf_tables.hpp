// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <span>

namespace stiffront {

/// Highest order and largest number of sweeps the tables hold.
inline constexpr int sbdf_max_order = 5;
inline constexpr int sbdf_max_sweeps = 10;

namespace sbdf_tables {

/// z_limit[order - 1][sweeps - 1]: largest dt * rho (rho: spectral radius of one species' diffusion) at which
/// SBDF(order) with that many sweeps is stable. Order 1 carries the row of order 2. Preliminary values.
inline constexpr std::array<std::array<double, sbdf_max_sweeps>, sbdf_max_order> z_limit = {{
    {{0.53835, 3.491, 8.438, 14.675, 22.238, 33.135, 36.846, 57.073, 66.539, 77.054}},
    {{0.53835, 3.491, 8.438, 14.675, 22.238, 33.135, 36.846, 57.073, 66.539, 77.054}},
    {{0.4171, 2.8887, 6.92, 12.215, 18.81, 26.368, 33.609, 39.301, 53.46, 66.76}},
    {{0.32204, 2.3804, 5.7308, 9.9823, 15.019, 21.378, 30.69, 32.837, 43.893, 58.872}},
    {{0.25317, 1.9875, 4.7889, 8.6272, 13.479, 18.629, 23.101, 27.392, 38.075, 45.346}},
}};

/// shifts[order - 1][sweeps - 1][j]: shift of sweep j in units of half the spectral radius of the species
/// (which is the diagonal of -D lap for the three-point stencil); entries past the last sweep are zero.
inline constexpr std::array<std::array<std::array<double, sbdf_max_sweeps>, sbdf_max_sweeps>, sbdf_max_order> shifts = {{
    {{
        {{0.000}},
        {{0.000, 1.501}},
        {{0.000, 0.816, 1.936}},
        {{0.000, 0.518, 1.813, 1.640}},
        {{0.000, 1.094, 1.978, 0.374, 1.462}},
        {{0.000, 0.245, 1.855, 0.897, 1.909, 1.221}},
        {{0.000, 0.272, 2.000, 1.101, 1.386, 0.567, 1.662}},
        {{0.000, 0.618, 1.700, 1.644, 0.790, 0.146, 1.959, 1.475}},
        {{0.000, 1.835, 0.693, 0.814, 0.133, 0.887, 2.000, 1.918, 1.173}},
        {{0.000, 2.000, 1.823, 1.708, 1.760, 0.812, 0.866, 0.880, 0.374, 0.125}},
    }},
    {{
        {{0.000}},
        {{0.000, 1.501}},
        {{0.000, 0.816, 1.936}},
        {{0.000, 0.518, 1.813, 1.640}},
        {{0.000, 1.094, 1.978, 0.374, 1.462}},
        {{0.000, 0.245, 1.855, 0.897, 1.909, 1.221}},
        {{0.000, 0.272, 2.000, 1.101, 1.386, 0.567, 1.662}},
        {{0.000, 0.618, 1.700, 1.644, 0.790, 0.146, 1.959, 1.475}},
        {{0.000, 1.835, 0.693, 0.814, 0.133, 0.887, 2.000, 1.918, 1.173}},
        {{0.000, 2.000, 1.823, 1.708, 1.760, 0.812, 0.866, 0.880, 0.374, 0.125}},
    }},
    {{
        {{0.000}},
        {{0.000, 1.595}},
        {{0.000, 0.924, 1.938}},
        {{0.000, 0.587, 1.576, 1.864}},
        {{0.000, 1.563, 0.403, 1.208, 1.997}},
        {{0.000, 0.296, 1.971, 1.254, 1.944, 0.939}},
        {{0.000, 0.257, 2.000, 1.228, 1.287, 0.656, 1.670}},
        {{0.000, 0.542, 1.952, 1.282, 0.512, 0.288, 1.779, 1.672}},
        {{0.000, 1.979, 1.857, 0.534, 0.939, 1.313, 1.529, 1.444, 0.152}},
        {{0.000, 0.857, 1.775, 0.130, 1.158, 0.555, 1.795, 0.625, 1.801, 1.936}},
    }},
    {{
        {{0.000}},
        {{0.000, 1.696}},
        {{0.000, 1.022, 1.895}},
        {{0.000, 0.686, 1.843, 1.614}},
        {{0.000, 1.307, 1.975, 0.505, 1.385}},
        {{0.000, 0.354, 1.905, 1.272, 1.962, 0.974}},
        {{0.000, 0.248, 1.996, 1.090, 1.461, 0.706, 1.794}},
        {{0.000, 0.579, 1.778, 1.291, 0.480, 0.373, 1.961, 1.670}},
        {{0.000, 1.037, 1.985, 0.554, 1.627, 0.179, 1.969, 1.717, 0.874}},
        {{0.000, 0.891, 1.701, 0.419, 1.154, 0.134, 1.961, 0.650, 1.786, 1.874}},
    }},
    {{
        {{0.000}},
        {{0.000, 1.805}},
        {{0.000, 1.160, 1.872}},
        {{0.000, 0.790, 1.943, 1.385}},
        {{0.000, 0.548, 1.052, 1.610, 1.958}},
        {{0.000, 0.391, 1.946, 1.324, 1.776, 0.876}},
        {{0.000, 0.347, 2.000, 1.130, 1.364, 0.921, 1.681}},
        {{0.000, 1.039, 1.852, 1.859, 0.290, 1.583, 0.955, 1.148}},
        {{0.000, 1.027, 1.980, 0.552, 1.564, 0.208, 1.874, 1.810, 0.822}},
        {{0.000, 1.259, 1.874, 0.396, 1.399, 0.719, 2.000, 0.187, 1.370, 1.512}},
    }},
}};

}  // namespace sbdf_tables

/// Largest dt * rho for which SBDF(order) with this many sweeps is stable; rho is the largest of the species'
/// spectral radii of diffusion. order in 1..sbdf_max_order, sweeps in 1..sbdf_max_sweeps.
/// @throws std::out_of_range outside of the table
constexpr double sbdf_z_limit(int order, int sweeps) {
    return sbdf_tables::z_limit.at(static_cast<std::size_t>(order - 1)).at(static_cast<std::size_t>(sweeps - 1));
}

/// The shifts g_1 = 0, g_2, ..., g_sweeps in the order of the sweeps, each in units of half the spectral radius
/// of the species' own diffusion. Valid for every dt * rho <= sbdf_z_limit(order, sweeps).
/// @throws std::out_of_range outside of the table
constexpr std::span<const double> sbdf_shifts(int order, int sweeps) {
    const auto& row =
        sbdf_tables::shifts.at(static_cast<std::size_t>(order - 1)).at(static_cast<std::size_t>(sweeps - 1));
    return std::span<const double>(row).first(static_cast<std::size_t>(sweeps));
}

}  // namespace stiffront
