// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "stiffront/mesh/field.hpp"

namespace stiffront {

/// probes.csv: the values of all species at some points after each accepted step, by multilinear interpolation between the grid points
/// around them (exact at a grid point).
///
/// Columns: step (accepted steps so far), time, then SPECIES\@X or SPECIES\@X:Y for each point. Every rank keeps the corner values it owns;
/// they travel once per batch, and root interpolates, so the digits do not depend on the number of ranks.
class Probes {
 public:
  /// @param points (x, y); y is ignored in one dimension.
  /// @throws Error(input) for a point outside the grid.
  Probes(const Decomposition& decomposition, std::string path, std::vector<std::array<double, 2>> points,
         const std::vector<std::string>& species);

  bool empty() const { return points_.empty(); }
  /// A fresh file with its header. @throws Error(io) on every rank. @mpi collective.
  void begin();
  /// Goes on with an existing file: drops what was written after `accepted` steps. @mpi collective.
  void resume(std::int64_t accepted);
  /// @mpi collective: every rank adds the same steps; one in 64 flushes.
  void add(std::int64_t step, double t, const Field& u);
  /// @throws Error(io) on every rank. @mpi collective.
  void flush();

 private:
  static constexpr std::size_t batch = 64;
  struct Corner {
    std::size_t point;
    double weight;
    std::int64_t i, j;  ///< global indices
  };

  const Decomposition* decomposition_;
  std::string path_;
  std::vector<std::array<double, 2>> points_;
  std::size_t n_species_;
  std::string header_;
  std::vector<Corner> corners_;
  std::vector<std::int64_t> steps_;
  std::vector<double> times_;
  std::vector<std::uint64_t> bits_;  ///< [line][corner][species], zero where another rank owns the corner
};

}  // namespace stiffront
