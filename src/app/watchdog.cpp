// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/app/watchdog.hpp"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>

#include "stiffront/core/timer.hpp"

namespace stiffront::app {

Watchdog::Watchdog(int rank, double limit_seconds) : rank_(rank), limit_(limit_seconds) {
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

void Watchdog::reset(const char* next) {
  phase_.store(next, std::memory_order_relaxed);
  achieved_.store(achieved_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
}

void Watchdog::watch() {
  constexpr double period = 0.5;  // seconds
  std::unique_lock<std::mutex> lock(mutex_);
  double stopped = 0.0;  // of this process, since the last achievement
  std::uint64_t achieved = 0;
  double looked = wall_seconds();
  double last = looked;
  while (!wake_.wait_for(lock, std::chrono::duration<double>(period), [this] { return done_; })) {
    const double now = wall_seconds();
    const std::uint64_t count = achieved_.load(std::memory_order_relaxed);
    if (count != achieved) {
      achieved = count;
      last = now;
      stopped = 0.0;
    }
    if (now - looked > 10.0 * period) stopped += now - std::max(looked, last);
    looked = now;
    const double idle = now - last - stopped;
    if (idle <= limit_) continue;
    char host[256] = "?";
    gethostname(host, sizeof host - 1);
    std::fprintf(stderr, "[rank %d on %s] nothing was completed for %.0f s (limits.stall_limit_s = %g), %s: the job is ended\n", rank_,
                 host, idle, limit_, phase_.load(std::memory_order_relaxed));
    std::fflush(stderr);
    std::abort();
  }
}

}  // namespace stiffront::app
