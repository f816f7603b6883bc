// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <thread>

namespace stiffront::app {

/// Ends the process when nothing has been achieved for too long: MPI has no time-out, so a rank that is stopped or waits for a dead
/// file system would hang the job for ever. A thread that makes no MPI calls says which rank and host it is, and at what, and aborts.
/// Time during which this process was stopped itself (a suspended job) does not count.
class Watchdog {
 public:
  /// @param limit_seconds 0: never.
  Watchdog(int rank, double limit_seconds);
  Watchdog(const Watchdog&) = delete;
  Watchdog& operator=(const Watchdog&) = delete;
  ~Watchdog();

  /// Something was achieved. @param next what comes now, for the message; a string that lives as long as the program
  void reset(const char* next);

 private:
  void watch();

  int rank_;
  double limit_;
  std::atomic<std::uint64_t> achieved_{0};  ///< counted, not timed: a step of a small problem is shorter than some clock readings
  std::atomic<const char*> phase_{"at the start"};
  bool done_ = false;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::thread thread_;
};

}  // namespace stiffront::app
