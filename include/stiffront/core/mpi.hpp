// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <mpi.h>

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "stiffront/core/node_memory.hpp"
#include "stiffront/core/reproducible_sum.hpp"

namespace stiffront {

/// Throws Error(mpi) with the library's own text if an MPI call failed.
void check_mpi(int status, const char* call);

/// What every rank contributes to, and learns from, one agreement: reproducible sums, maxima and or-ed flags in a single reduction.
/// Every rank passes the same numbers of sums and maxima; only what is there travels.
struct Agreement {
  explicit Agreement(int n_sums = 1, int n_maxima = 1)
      : sums(static_cast<std::size_t>(n_sums)), maxima(static_cast<std::size_t>(n_maxima), 0.0) {}

  std::vector<ReproducibleSum> sums;
  std::vector<double> maxima;  ///< non-negative quantities; a NaN is passed on as infinity
  std::uint64_t flags = 0;     ///< failures, signals, limits: or-ed
};

/// What a communicator has carried, on this rank.
struct Traffic {
  std::int64_t reductions = 0;
  std::int64_t halo_exchanges = 0;
  std::int64_t halo_messages = 0;  ///< sent
  std::int64_t halo_bytes = 0;     ///< sent
  double seconds_waiting = 0.0;    ///< for reductions and messages
};

/// Through which agreements of ranks of one node go.
class SharedAgreement;

/// A duplicate of a communicator that returns its errors, freed at the end. Movable, never copied, never global.
class Communicator {
 public:
  /// Duplicates comm. Ranks of a node share memory unless there are too many of them.
  /// @param most_sharing ranks of a node that may; negative: as many as it has processors, or a few more
  /// @mpi collective on comm.
  explicit Communicator(MPI_Comm comm, int most_sharing = -1);
  /// The part of this communicator whose ranks passed the same colour, in the same order. @mpi collective.
  Communicator split(int colour) const;
  Communicator(Communicator&& other) noexcept;
  Communicator& operator=(Communicator&& other) noexcept;
  Communicator(const Communicator&) = delete;
  Communicator& operator=(const Communicator&) = delete;
  ~Communicator();

  MPI_Comm get() const { return comm_; }
  int rank() const { return rank_; }
  int size() const { return size_; }
  bool is_root() const { return rank_ == 0; }

  /// One reduction; the result is the same on every rank and independent of their number. @mpi collective.
  void agree(Agreement& a) const;
  double max(double x) const;
  std::int64_t max(std::int64_t x) const;
  std::int64_t sum(std::int64_t x) const;
  void barrier() const;
  /// Memory that this rank and those of node_rank() >= 0 see of each other; none where they may not share any. @mpi collective.
  NodeMemory share(std::size_t bytes) const;
  /// A rank's number among those that share memory; -1: it is not one of them.
  int node_rank(int rank) const { return node_ranks_[static_cast<std::size_t>(rank)]; }
  /// Root's text on every rank. @mpi collective.
  std::string broadcast(const std::string& text, int root = 0) const;

  /// How many reductions this communicator has done; counted for the run's summary.
  std::int64_t reductions() const { return traffic_.reductions; }
  /// All that was counted so far.
  const Traffic& traffic() const { return traffic_; }
  /// Notes an exchange of halos, whoever makes it: what this rank sent in it.
  void count_halo(int messages, std::int64_t bytes) const {
    ++traffic_.halo_exchanges;
    traffic_.halo_messages += messages;
    traffic_.halo_bytes += bytes;
  }
  void count_waiting(double seconds) const { traffic_.seconds_waiting += seconds; }

 private:
  explicit Communicator(int most_sharing);
  void measure();
  void find_neighbours_in_node();

  MPI_Comm comm_ = MPI_COMM_NULL;
  MPI_Comm node_ = MPI_COMM_NULL;  ///< those that share memory
  int rank_ = 0;
  int size_ = 1;
  int most_sharing_;
  bool all_share_ = false;  ///< every rank's memory is seen here
  std::vector<int> node_ranks_;
  mutable std::unique_ptr<SharedAgreement> shared_agreement_;  ///< made for the first agreement
  mutable Traffic traffic_;
};

}  // namespace stiffront
