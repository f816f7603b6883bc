// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <vector>

#include "stiffront/mesh/boundary.hpp"
#include "stiffront/mesh/decomposition.hpp"
#include "stiffront/solvers/plane.hpp"

namespace stiffront {

/// One direction of a grid whose points need not be equidistant, with the three-point second difference on it,
///
///     -u''(i) = (lower_i + upper_i) u_i - lower_i u_{i-1} - upper_i u_{i+1},
///
/// mirrored at Neumann ends (where one of the two is zero), and the ways to and from the next coarser line, which has every second
/// point. Known to every rank in full.
///
/// A last point without a partner would leave a short interval, on every next line a shorter part of the others, coupled so strongly
/// that cell-Jacobi steps damp nothing along it. So an odd last point next to a Neumann side stays only if the side would else be far
/// off, an even one of a period only if the interval to the first is no shorter than the others; points that go belong to their nearest
/// neighbour. Lengths are shared out accordingly, and what flows from one point to the next is lost nowhere.
struct GridLine {
  /// n equidistant points at distance 1.
  GridLine(int n, bool periodic, bool fixed_lower, bool fixed_upper);
  /// The points of a direction of a grid, with its sub-cells.
  GridLine(const Grid& grid, int direction, bool fixed_lower, bool fixed_upper);

  /// Whether a coarser line would have fewer unknowns.
  bool can_coarsen() const { return n_free() > 1; }
  int n() const { return static_cast<int>(position.size()); }
  int n_free() const { return n() - (fixed_lower ? 1 : 0) - (fixed_upper ? 1 : 0); }
  /// The mean of 1 / distance^2: what couples neighbours.
  double coupling() const;
  /// The next coarser line; sets the ways to and from it.
  GridLine coarsen();
  /// The same line again, with ways that change nothing.
  GridLine keep();

  bool periodic;
  bool fixed_lower, fixed_upper;  ///< Dirichlet ends, which stay on all levels
  double period;
  double beyond = 0.0;  ///< from the last point to an upper Neumann side
  std::vector<double> position;
  std::vector<double> lower, upper;
  std::vector<double> share;  ///< of every point in the length
  // A value here from those of the coarser line: by_left u[left] + by_right u[left + 1].
  std::vector<int> left;
  std::vector<double> by_left, by_right;
  // A mean there, around the point with index `centre` here: before u[centre - 1] + at u[centre] + after u[centre + 1].
  std::vector<int> centre;
  std::vector<double> before, at, after;

 private:
  GridLine() = default;
  /// From point i - 1 to point i, around a period; zero beyond other ends.
  double interval_before(std::size_t i) const;
  void share_length();
  /// The coefficients, from positions and lengths.
  void differentiate();
};

/// A grid of a hierarchy, and this rank's part of it.
struct CoarseGrid {
  std::array<GridLine, 2> lines;
  bool whole = false;          ///< every rank has all points
  std::array<int, 2> begin{};  ///< global index of this rank's first point
  std::array<int, 2> n{};      ///< its number of points
  FreeBox free{};              ///< local indices of the unknowns
  /// Of every rank, when the grid is the first whole one: begin and n of what it contributes.
  std::vector<std::array<int, 4>> contributions;

  const GridLine& x() const { return lines[0]; }
  const GridLine& y() const { return lines[1]; }
};

/// The grids below a decomposed one in two dimensions, down to a single unknown. A direction is coarsened if its neighbours are coupled
/// about as strongly as those of the other one (semi-coarsening). Which points a grid has does not depend on the ranks; grids of few
/// points are `whole`: computed by every rank.
/// @param k_x, k_y strength of the coupling in each direction on the finest grid
/// @param whole_at_most largest number of points of a whole grid
std::vector<CoarseGrid> coarse_grids(const Decomposition& decomposition, const Boundary& boundary, double k_x, double k_y,
                                     int whole_at_most = 1024);

/// Brings the halo of planes on one of the grids up to date: that of periodic and shared sides, corners included; beyond a physical
/// boundary it stays as it is.
class PlaneExchange {
 public:
  PlaneExchange(const Decomposition& decomposition, const CoarseGrid& grid, int most_components);
  /// @mpi collective on the neighbours, unless the grid is whole
  void exchange(const PlaneView& u, int n_components);

 private:
  void exchange_direction(std::size_t d, const PlaneView& u, int n_components);

  const Communicator* comm_;
  std::array<int, 2> n_;
  std::array<std::array<int, 2>, 2> neighbours_;  // rank at [direction][lower | upper]; -1: a physical boundary
  std::array<std::vector<double>, 2> out_;
  std::array<std::vector<double>, 2> in_;
};

/// Puts every rank's part of a plane on the first whole grid in its place in the whole, on every rank.
class PlaneGather {
 public:
  PlaneGather(const Communicator& comm, const CoarseGrid& grid, int most_components);
  /// @pre this rank's part is in its place already. @mpi collective
  void gather(const PlaneView& u, int n_components);

 private:
  const Communicator* comm_;
  std::vector<std::array<int, 4>> parts_;
  std::vector<double> mine_, all_;
  std::vector<int> counts_, displacements_;
};

}  // namespace stiffront
