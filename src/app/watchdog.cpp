// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/app/watchdog.hpp"

#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>

#include "stiffront/core/timer.hpp"

namespace stiffront::app {

Watchdog::Watchdog(int rank, double limit_seconds) : rank_(rank), limit_(limit_seconds), last_(wall_seconds()) {
  if (limit_ > 0.0) thread_ = std::thread(&Watchdog::watch, this);
}

Watchdog::~Watchdog() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    done_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void Watchdog::reset() { last_.store(wall_seconds(), std::memory_order_relaxed); }

void Watchdog::watch() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (!wake_.wait_for(lock, std::chrono::milliseconds(500), [this] { return done_; })) {
    const double idle = wall_seconds() - last_.load(std::memory_order_relaxed);
    if (idle <= limit_) continue;
    char host[256] = "?";
    gethostname(host, sizeof host - 1);
    std::fprintf(stderr, "[rank %d on %s] no step was completed for %.0f s (limits.stall_limit_s = %.0f): the job is ended\n", rank_, host, idle,
                 limit_);
    std::fflush(stderr);
    std::abort();
  }
}

}  // namespace stiffront::app
