// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/app/signals.hpp"

#include <unistd.h>

#include <array>
#include <csignal>

#include "stiffront/core/timer.hpp"

namespace stiffront::app {
namespace {

constexpr std::array<int, 4> watched{SIGUSR1, SIGUSR2, SIGTERM, SIGINT};

volatile std::sig_atomic_t checkpoint_asked = 0;
volatile std::sig_atomic_t stop_asked = 0;
std::array<struct sigaction, watched.size()> before;

void on_signal(int number) {
  if (number == SIGUSR1) {
    checkpoint_asked = 1;
    return;
  }
  if (stop_asked != 0 && (number == SIGTERM || number == SIGINT)) _exit(128 + number);
  stop_asked = 1;
}

}  // namespace

SignalRequests::SignalRequests() {
  checkpoint_asked = 0;
  stop_asked = 0;
  struct sigaction action {};
  action.sa_handler = on_signal;
  sigemptyset(&action.sa_mask);
  action.sa_flags = SA_RESTART;
  for (std::size_t i = 0; i < watched.size(); ++i) sigaction(watched[i], &action, &before[i]);
}

SignalRequests::~SignalRequests() {
  for (std::size_t i = 0; i < watched.size(); ++i) sigaction(watched[i], &before[i], nullptr);
}

std::uint64_t SignalRequests::take() {
  std::uint64_t flags = 0;
  if (checkpoint_asked != 0) {
    checkpoint_asked = 0;
    flags |= requests::checkpoint;
  }
  if (stop_asked != 0) flags |= requests::stop;  // stays: the end is not taken back
  return flags;
}

std::uint64_t FileRequests::take() {
  const double now = wall_seconds();
  if (now - looked_ < 1.0) return 0;
  looked_ = now;
  std::uint64_t flags = 0;
  if (unlink((directory_ + "/CHECKPOINT").c_str()) == 0) flags |= requests::checkpoint;
  if (unlink((directory_ + "/STOP").c_str()) == 0) flags |= requests::stop;
  return flags;
}

}  // namespace stiffront::app
