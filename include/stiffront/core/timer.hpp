// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <chrono>

namespace stiffront {

/// Wall-clock seconds since some fixed moment. Never read to decide anything that changes results.
inline double wall_seconds() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

/// Adds the time until the end of its scope to a total.
class ScopedTimer {
 public:
  explicit ScopedTimer(double& total) : total_(&total), start_(wall_seconds()) {}
  ScopedTimer(const ScopedTimer&) = delete;
  ScopedTimer& operator=(const ScopedTimer&) = delete;
  ~ScopedTimer() { *total_ += wall_seconds() - start_; }

 private:
  double* total_;
  double start_;
};

/// Where the time of this rank went, in seconds. Communication is contained in the others.
struct PhaseSeconds {
  double diffusion = 0.0;
  double reaction = 0.0;
  double quadrature = 0.0;
  double communication = 0.0;
  double output = 0.0;
  double total = 0.0;
};

}  // namespace stiffront
