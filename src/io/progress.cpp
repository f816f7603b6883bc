// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/io/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "stiffront/core/timer.hpp"

namespace stiffront {
namespace {

std::string duration(double seconds) {
  if (seconds < 60.0) return fmt::format("{:.0f} s", seconds);
  const auto s = static_cast<long long>(seconds);
  if (s < 3600) return fmt::format("{} min {:02} s", s / 60, s % 60);
  if (s < 48 * 3600) return fmt::format("{} h {:02} min", s / 3600, s / 60 % 60);
  return fmt::format("{} days", s / 86400);
}

}  // namespace

bool reaches_terminal(std::FILE* stream) {
  const int fd = ::fileno(stream);
  if (fd < 0 || ::isatty(fd) == 0) return false;
  if (std::getenv("OMPI_COMM_WORLD_RANK") == nullptr) return true;
  std::error_code failed;
  const auto target = std::filesystem::read_symlink(fmt::format("/proc/{}/fd/{}", ::getppid(), fd), failed);
  return !failed && target.string().starts_with("/dev/") && target != "/dev/null";
}

ProgressLine::ProgressLine(bool speaks, ProgressMode mode, std::FILE* stream, double start, double end)
    : speaks_(speaks && mode != ProgressMode::never),
      in_place_(mode == ProgressMode::always || (mode == ProgressMode::automatic && reaches_terminal(stream))),
      stream_(stream),
      start_(start),
      end_(end),
      t_began_(start),
      began_(wall_seconds()),
      last_shown_(began_) {}

void ProgressLine::begin(double t) {
  t_began_ = t;
  began_ = last_shown_ = wall_seconds();
}

void ProgressLine::attempted(const StepRecord& record) { rejected_ += record.attempt.accepted ? 0 : 1; }

void ProgressLine::stepped(const StepRecord& record, double t_new, bool wrote_state) {
  if (!speaks_) return;
  const double now = wall_seconds();
  const bool done = t_new >= end_;
  if (in_place_) {
    if (now - last_shown_ < 0.1 && !done) return;
    const std::string line = text(record, t_new, now);
    fmt::print(stream_, "\r{:<{}}", line, std::max(shown_length_, line.size()));
    shown_length_ = line.size();
  } else {
    if (now - last_shown_ < 10.0 && !wrote_state && !done) return;
    fmt::print(stream_, "{}\n", text(record, t_new, now));
  }
  std::fflush(stream_);
  last_shown_ = now;
}

void ProgressLine::interrupt() {
  if (shown_length_ == 0) return;
  fmt::print(stream_, "\n");
  std::fflush(stream_);
  shown_length_ = 0;
}

std::string ProgressLine::text(const StepRecord& record, double t_new, double now) const {
  const double percent = 100.0 * (t_new - start_) / (end_ - start_);
  std::string line = fmt::format("step {} t={:.6g} dt={:.3g}", record.step + 1, t_new, record.dt);
  if (record.attempt.error > 0.0) line += fmt::format(" err={:.2e}", record.attempt.error);
  line += fmt::format(" rej={} {:3.0f} %", rejected_, percent);
  const double elapsed = now - began_;
  if (t_new < end_ && t_new > t_began_ && elapsed > 1.0) {
    line += fmt::format(", {} to go", duration(elapsed * (end_ - t_new) / (t_new - t_began_)));
  }
  return line;
}

}  // namespace stiffront
