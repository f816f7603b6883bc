// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <mpi.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace stiffront {

/// A number in shared memory that its owner counts up when something is ready; all zeros at first.
struct alignas(64) Turn {
  std::atomic<std::uint64_t> now;
  static_assert(std::atomic<std::uint64_t>::is_always_lock_free);

  /// What was written before is seen by whoever sees this.
  void announce(std::uint64_t turn) { now.store(turn, std::memory_order_release); }
  bool has_come(std::uint64_t turn) const { return now.load(std::memory_order_acquire) >= turn; }
};

/// Memory of the ranks of a node that all of them see: each has a piece of it.
///
/// Two processes of a node tell each other something in a tenth of the time a message of MPI takes, which is what a step of a small
/// problem is short of. Where memory cannot be shared (another node, no room, too many ranks) there are no pieces, and what would use
/// them sends messages.
class NodeMemory {
 public:
  NodeMemory() = default;
  /// Every rank of `node` gets `bytes` of zeros, in whole cache lines of its own. If one cannot have them, nobody gets any.
  /// @param node ranks that may share memory @mpi collective on node
  NodeMemory(MPI_Comm node, std::size_t bytes);
  NodeMemory(NodeMemory&& other) noexcept;
  NodeMemory& operator=(NodeMemory&& other) noexcept;
  NodeMemory(const NodeMemory&) = delete;
  NodeMemory& operator=(const NodeMemory&) = delete;
  /// Local: nobody has to wait for others to go.
  ~NodeMemory();

  explicit operator bool() const { return base_ != nullptr; }
  /// The piece of a rank of `node`.
  std::byte* of(int rank) const { return base_ + offsets_[static_cast<std::size_t>(rank)]; }

  /// Waits for a turn. Messages of MPI make progress meanwhile; where processes outnumber processors, others get theirs.
  /// @return seconds waited @param comm any of this rank
  double wait_for(const Turn& turn, std::uint64_t value, MPI_Comm comm) const;

 private:
  std::byte* base_ = nullptr;
  std::size_t length_ = 0;
  bool crowded_ = false;  ///< more ranks than processors
  std::vector<std::size_t> offsets_;
};

}  // namespace stiffront
