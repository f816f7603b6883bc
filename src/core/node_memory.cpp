// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/core/node_memory.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sched.h>
#include <sys/mman.h>
#include <unistd.h>

#if defined(__SSE2__)
#include <immintrin.h>
#endif

#include <algorithm>
#include <array>
#include <utility>

#include "stiffront/core/mpi.hpp"
#include "stiffront/core/timer.hpp"

namespace stiffront {
namespace {

constexpr std::size_t line = 64;

/// Looks at a turn before the processor is left to others: some ten microseconds.
constexpr int patience = 1000;
/// Looks between two chances for MPI to move messages on.
constexpr int looks_per_progress = 64;

/// Tells the processor that nothing is to be done for a moment.
void pause() {
#if defined(__SSE2__)
  _mm_pause();
#endif
}

bool agreed(bool mine, MPI_Comm node) {
  int all = mine ? 1 : 0;
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &all, 1, MPI_INT, MPI_MIN, node), "MPI_Allreduce");
  return all != 0;
}

/// Memory under a name that is gone when all ranks have it: nothing stays behind, whatever ends a rank later. A rank that is killed
/// between leaves a file of its few kilobytes in /dev/shm.
class SharedObject {
 public:
  SharedObject(const char* name, bool creates, std::size_t length) : name_(name) {
    file_ = shm_open(name, creates ? O_RDWR | O_CREAT | O_EXCL : O_RDWR, 0600);
    created_ = creates && file_ >= 0;
    // Room is made now: without it the first write would end the process.
    has_room_ = file_ >= 0 && (!creates || posix_fallocate(file_, 0, static_cast<off_t>(length)) == 0);
  }
  SharedObject(const SharedObject&) = delete;
  SharedObject& operator=(const SharedObject&) = delete;
  ~SharedObject() {
    if (file_ >= 0) close(file_);
    if (created_) shm_unlink(name_);
  }
  bool is_there() const { return has_room_; }
  std::byte* map(std::size_t length) const {
    if (!has_room_) return nullptr;
    void* const at = mmap(nullptr, length, PROT_READ | PROT_WRITE, MAP_SHARED, file_, 0);
    return at == MAP_FAILED ? nullptr : static_cast<std::byte*>(at);
  }

 private:
  const char* name_;
  int file_ = -1;
  bool created_ = false;
  bool has_room_ = false;
};

}  // namespace

NodeMemory::NodeMemory(MPI_Comm node, std::size_t bytes) {
  int rank = 0;
  int size = 0;
  check_mpi(MPI_Comm_rank(node, &rank), "MPI_Comm_rank");
  check_mpi(MPI_Comm_size(node, &size), "MPI_Comm_size");
  crowded_ = size > sysconf(_SC_NPROCESSORS_ONLN);
  const std::uint64_t mine = (std::max<std::size_t>(bytes, 1) + line - 1) / line * line;
  std::vector<std::uint64_t> lengths(static_cast<std::size_t>(size));
  check_mpi(MPI_Allgather(&mine, 1, MPI_UINT64_T, lengths.data(), 1, MPI_UINT64_T, node), "MPI_Allgather");
  for (std::uint64_t length : lengths) {
    offsets_.push_back(length_);
    length_ += length;
  }

  static int made = 0;  // by this process: a name is used once
  std::array<char, 64> name{};
  if (rank == 0) fmt::format_to_n(name.data(), name.size() - 1, "/stiffront-{}-{}", getpid(), made++);
  check_mpi(MPI_Bcast(name.data(), static_cast<int>(name.size()), MPI_CHAR, 0, node), "MPI_Bcast");
  const auto attach = [&](bool creates) {
    const SharedObject object(name.data(), creates, length_);
    if (creates && !agreed(object.is_there(), node)) return;
    base_ = object.map(length_);
    const bool all = agreed(base_ != nullptr, node);  // the name may go now
    if (all || base_ == nullptr) return;
    munmap(base_, length_);
    base_ = nullptr;
  };
  if (rank == 0) {
    attach(true);
  } else if (agreed(true, node)) {
    attach(false);
  }
}

NodeMemory::NodeMemory(NodeMemory&& other) noexcept { *this = std::move(other); }

NodeMemory& NodeMemory::operator=(NodeMemory&& other) noexcept {
  std::swap(base_, other.base_);
  std::swap(length_, other.length_);
  std::swap(crowded_, other.crowded_);
  std::swap(offsets_, other.offsets_);
  return *this;
}

NodeMemory::~NodeMemory() {
  if (base_ != nullptr) munmap(base_, length_);
}

double NodeMemory::wait_for(const Turn& turn, std::uint64_t value, MPI_Comm comm) const {
  if (turn.has_come(value)) return 0.0;
  const double began = wall_seconds();
  for (int looks = 1; !turn.has_come(value); ++looks) {
    if (crowded_ || looks % looks_per_progress == 0) {
      int there = 0;
      check_mpi(MPI_Iprobe(MPI_ANY_SOURCE, MPI_ANY_TAG, comm, &there, MPI_STATUS_IGNORE), "MPI_Iprobe");
    }
    if (crowded_ || looks > patience) {
      sched_yield();
    } else {
      pause();
    }
  }
  return wall_seconds() - began;
}

}  // namespace stiffront
