// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/mesh/decomposition.hpp"

#include <fmt/format.h>

#include <limits>
#include <string>

#include "stiffront/core/error.hpp"

namespace stiffront {
namespace {

std::int64_t part_size(std::int64_t points, int parts, int index) { return points / parts + (index < points % parts ? 1 : 0); }

std::int64_t part_offset(std::int64_t points, int parts, int index) {
  const std::int64_t larger = points % parts;
  return index * (points / parts) + (index < larger ? index : larger);
}

/// A layout as it stands in a case file.
std::string layout_text(const Grid& grid, std::array<int, 2> p) {
  return grid.dimension == 1 ? fmt::format("[{}]", p[0]) : fmt::format("[{}, {}]", p[0], p[1]);
}

/// Whether a number of ranks can be arranged as asked for.
bool is_possible(int ranks, const Grid& grid, std::array<int, 2> asked) {
  for (int px = 1; px <= ranks; ++px) {
    if (ranks % px != 0 || (grid.dimension == 1 && px != ranks)) continue;
    if ((asked[0] == 0 || asked[0] == px) && (asked[1] == 0 || asked[1] == ranks / px)) return true;
  }
  return false;
}

bool fits(const Grid& grid, std::array<int, 2> p, int min_points) {
  for (std::size_t d = 0; d < 2; ++d) {
    if (p[d] > 1 && grid.points[d] / p[d] < min_points) return false;
  }
  return true;
}

/// The factorisation of the number of ranks whose halos hold the fewest points; the longest rows win a tie.
std::array<int, 2> choose_layout(int ranks, const Grid& grid, std::array<int, 2> asked, int min_points) {
  std::array<int, 2> best{0, 0};
  std::int64_t best_surface = std::numeric_limits<std::int64_t>::max();
  for (int px = 1; px <= ranks; ++px) {
    if (ranks % px != 0) continue;
    const std::array<int, 2> p{px, ranks / px};
    if (grid.dimension == 1 && p[1] != 1) continue;
    if ((asked[0] != 0 && asked[0] != p[0]) || (asked[1] != 0 && asked[1] != p[1])) continue;
    if (!fits(grid, p, min_points)) continue;
    const std::int64_t cuts_x = p[0] - (grid.periodic[0] && p[0] > 1 ? 0 : 1);
    const std::int64_t cuts_y = p[1] - (grid.periodic[1] && p[1] > 1 ? 0 : 1);
    const std::int64_t surface = cuts_x * grid.points[1] + cuts_y * grid.points[0];
    if (surface < best_surface) {
      best_surface = surface;
      best = p;
    }
  }
  return best;
}

}  // namespace

Decomposition::Decomposition(const Communicator& comm, const Grid& grid, std::array<int, 2> processes, int min_points)
    : comm_(&comm), grid_(grid) {
  const int ranks = comm.size();
  if (grid.dimension == 1) processes[1] = 1;
  if (ranks > grid.total_points()) {
    throw Error(ErrorKind::input, fmt::format("grid.points: {} grid points cannot be divided among {} ranks; use at most {} ranks",
                                              grid.total_points(), ranks, grid.total_points()));
  }
  const std::string on_ranks = ranks == 1 ? "1 rank" : fmt::format("{} ranks", ranks);
  if (!is_possible(ranks, grid, processes)) {
    throw Error(ErrorKind::input,
                fmt::format("grid.processes: {} asked for, but the program runs on {}", layout_text(grid, processes), on_ranks));
  }
  processes_ = choose_layout(ranks, grid, processes, min_points);
  if (processes_[0] == 0) {
    const bool chosen_freely = processes[0] == 0 && processes[1] == 0;
    throw Error(
        ErrorKind::input,
        fmt::format("grid.processes: {} grid points cannot be divided among {}{} with at least {} points each in a divided "
                    "direction; use fewer ranks or more points",
                    grid.dimension == 1 ? fmt::format("{}", grid.points[0]) : fmt::format("{} x {}", grid.points[0], grid.points[1]),
                    on_ranks, chosen_freely ? "" : " as " + layout_text(grid, processes), min_points));
  }
  coordinates_ = {comm.rank() % processes_[0], comm.rank() / processes_[0]};
  for (std::size_t d = 0; d < 2; ++d) {
    // The first box is the largest: every rank comes to the same verdict.
    const std::int64_t largest = part_size(grid.points[d], processes_[d], 0);
    if (largest > std::numeric_limits<int>::max() / 2) {
      throw Error(ErrorKind::input,
                  fmt::format("grid.points: {} points in one direction on one rank are too many; use more ranks", largest));
    }
    size_[d] = static_cast<int>(part_size(grid.points[d], processes_[d], coordinates_[d]));
    offset_[d] = part_offset(grid.points[d], processes_[d], coordinates_[d]);
  }
}

bool Decomposition::at_boundary(int direction, int side) const {
  const auto d = static_cast<std::size_t>(direction);
  if (grid_.periodic[d]) return false;
  return side == 0 ? coordinates_[d] == 0 : coordinates_[d] == processes_[d] - 1;
}

int Decomposition::neighbour(int dx, int dy) const {
  std::array<int, 2> at{coordinates_[0] + dx, coordinates_[1] + dy};
  for (std::size_t d = 0; d < 2; ++d) {
    if (at[d] >= 0 && at[d] < processes_[d]) continue;
    if (!grid_.periodic[d]) return MPI_PROC_NULL;
    at[d] = (at[d] + processes_[d]) % processes_[d];
  }
  return at[1] * processes_[0] + at[0];
}

std::array<std::int64_t, 4> Decomposition::box_of(int rank) const {
  const int cx = rank % processes_[0];
  const int cy = rank / processes_[0];
  return {part_offset(grid_.points[0], processes_[0], cx), part_offset(grid_.points[1], processes_[1], cy),
          part_size(grid_.points[0], processes_[0], cx), part_size(grid_.points[1], processes_[1], cy)};
}

}  // namespace stiffront
