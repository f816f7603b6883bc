// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/solvers/halo_depth.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "stiffront/core/timer.hpp"
#include "stiffront/mesh/wavefront.hpp"

namespace stiffront {
namespace {

// Of one variable in one stage, in cache (docs/performance.md), and of a byte through memory or a network of today.
constexpr double seconds_per_value = 0.3e-9;
constexpr double seconds_per_byte = 0.2e-9;
// What a pass over memory adds for a variable that does not stay in cache.
constexpr double seconds_in_memory = 0.3e-9;

constexpr int trials = 12;

bool has_neighbours(const Decomposition& d, int direction) {
  const auto k = static_cast<std::size_t>(direction);
  return d.processes()[k] > 1 || (direction < d.grid().dimension && d.grid().periodic[k]);
}

/// Through memory, where all ranks share it; else there is none.
std::optional<double> measure_shared_exchange(const Decomposition& d) {
  const Communicator& comm = d.comm();
  for (int rank = 0; rank < comm.size(); ++rank) {
    if (comm.node_rank(rank) < 0) return std::nullopt;
  }
  const NodeMemory memory = comm.share(sizeof(Turn));
  if (!memory) return std::nullopt;
  const auto turn_of = [&](int rank) -> Turn& { return *reinterpret_cast<Turn*>(memory.of(comm.node_rank(rank))); };
  double least = std::numeric_limits<double>::infinity();
  for (std::uint64_t turn = 1; turn <= trials; ++turn) {
    const double began = wall_seconds();
    turn_of(comm.rank()).announce(turn);
    for (const auto& [dx, dy] : {std::array{-1, 0}, std::array{1, 0}, std::array{0, -1}, std::array{0, 1}}) {
      const int rank = d.neighbour(dx, dy);
      if (rank != MPI_PROC_NULL) memory.wait_for(turn_of(rank), turn, comm.get());
    }
    least = std::min(least, wall_seconds() - began);
  }
  return comm.max(least);
}

}  // namespace

int largest_halo_depth(const Decomposition& d, const Boundary& boundary, int stencil) {
  if (d.comm().size() == 1) return 1;
  std::int64_t most = std::numeric_limits<int>::max();
  for (int direction = 0; direction < d.grid().dimension; ++direction) {
    if (!has_neighbours(d, direction)) continue;
    const auto k = static_cast<std::size_t>(direction);
    const std::int64_t smallest = d.grid().points[k] / d.processes()[k];
    most = std::min(most, (smallest - (boundary.depends_on_time() ? 1 : 0)) / stencil);
  }
  return static_cast<int>(std::max<std::int64_t>(1, most));
}

double measure_exchange(const Decomposition& d) {
  if (const auto shared = measure_shared_exchange(d)) return *shared;
  const MPI_Comm comm = d.comm().get();
  double least = std::numeric_limits<double>::infinity();
  for (int n = 0; n < trials; ++n) {
    std::vector<MPI_Request> requests;
    double out[8] = {};
    double in[4][8];
    const double began = wall_seconds();
    int side = 0;
    for (const auto& [dx, dy] : {std::array{-1, 0}, std::array{1, 0}, std::array{0, -1}, std::array{0, 1}}) {
      const int rank = d.neighbour(dx, dy);
      const int opposite = d.neighbour(-dx, -dy);
      requests.emplace_back();
      check_mpi(MPI_Irecv(in[side], 8, MPI_DOUBLE, opposite, side, comm, &requests.back()), "MPI_Irecv");
      requests.emplace_back();
      check_mpi(MPI_Isend(out, 8, MPI_DOUBLE, rank, side, comm, &requests.back()), "MPI_Isend");
      ++side;
    }
    check_mpi(MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE), "MPI_Waitall");
    least = std::min(least, wall_seconds() - began);
  }
  return d.comm().max(least);
}

HaloCost::HaloCost(const Decomposition& d, int stencil, double exchange) : stencil_(stencil), exchange_(exchange) {
  for (std::size_t k = 0; k < 2; ++k) {
    const int processes = d.processes()[k];
    points_[k] = std::ceil(static_cast<double>(d.grid().points[k]) / processes);
    if (has_neighbours(d, static_cast<int>(k))) neighbours_[k] = processes == 2 && !d.grid().periodic[k] ? 1.0 : 2.0;
  }
}

double HaloCost::seconds(int depth, int stages, int variables) const {
  // A box and the halo around it where there are neighbours.
  const auto size = [this](double width) { return (points_[0] + neighbours_[0] * width) * (points_[1] + neighbours_[1] * width); };
  const double sides = neighbours_[0] + neighbours_[1];
  const double corners = neighbours_[0] * neighbours_[1];
  const double interior = seconds_per_value * variables * std::max(0.0, size(-8.0 - stencil_));
  // A species with the state before it.
  const bool is_large = 2.0 * 8.0 * size(0.0) > static_cast<double>(own_cache);
  double total = 0.0;
  for (int done = 0; done < stages; done += depth) {
    const int together = std::min(depth, stages - done);
    // The state goes along as wide as all stages reach, the one before it one stage less.
    const double values = size(together * stencil_) + size((together - 1) * stencil_) - 2.0 * size(0.0);
    const double messages = 1.0 + (together > 1 ? corners / sides : 0.0);
    const double bytes = 8.0 * variables * values;
    // Half of an exchange is the processor's own work, which nothing hides; so is the copying of what is sent and
    // received.
    const double in_flight = 0.5 * exchange_ + bytes * seconds_per_byte;
    const double hidden = together == 1 || !is_large ? interior : 0.0;
    total += 0.5 * exchange_ * messages + bytes * seconds_per_byte + std::max(0.0, in_flight - hidden);
    if (is_large) total += seconds_in_memory * variables * size(0.0);
    for (int k = 0; k < together; ++k) total += seconds_per_value * variables * size(k * stencil_);
  }
  return total;
}

int HaloCost::best_depth(int largest, int stages, int variables) const {
  int best = 1;
  for (int depth = 2; depth <= std::min(largest, stages); ++depth) {
    if (seconds(depth, stages, variables) < seconds(best, stages, variables)) best = depth;
  }
  return best;
}

}  // namespace stiffront
