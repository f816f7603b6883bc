// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <mpi.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

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

/// A duplicate of a communicator that returns its errors, freed at the end. Movable, never copied, never global.
class Communicator {
 public:
  /// Duplicates comm. @mpi collective on comm.
  explicit Communicator(MPI_Comm comm);
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
  /// Root's text on every rank. @mpi collective.
  std::string broadcast(const std::string& text, int root = 0) const;

  /// How many reductions this communicator has done; counted for the run's summary.
  std::int64_t reductions() const { return reductions_; }
  /// Seconds spent in agreements.
  double seconds_reducing() const { return seconds_reducing_; }

 private:
  MPI_Comm comm_ = MPI_COMM_NULL;
  int rank_ = 0;
  int size_ = 1;
  mutable std::int64_t reductions_ = 0;
  mutable double seconds_reducing_ = 0.0;
};

}  // namespace stiffront
