// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/io/memory.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <fstream>
#include <string>

namespace stiffront {
namespace {

/// One number in a file of the kernel; negative if there is none ("max", no such file).
double number_in(const char* path) {
  std::ifstream in(path);
  double x = -1.0;
  return in >> x ? x : -1.0;
}

/// Bytes of a control group's use that the kernel gives back when they are wanted: files it keeps in memory.
double reclaimable_bytes() {
  std::ifstream in("/sys/fs/cgroup/memory.stat");
  double sum = 0.0;
  std::string name;
  for (double x = 0.0; in >> name >> x;) {
    if (name == "inactive_file" || name == "active_file") sum += x;
  }
  return sum;
}

}  // namespace

double peak_memory_mib() {
  rusage usage{};
  if (getrusage(RUSAGE_SELF, &usage) != 0) return 0.0;
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

double available_memory_mib() {
  double available = 0.0;
  std::ifstream in("/proc/meminfo");
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("MemAvailable:")) available = std::stod(line.substr(13)) / 1024.0;
  }
  const double limit = number_in("/sys/fs/cgroup/memory.max");
  const double used = number_in("/sys/fs/cgroup/memory.current");
  if (limit > 0.0 && used >= 0.0) available = std::min(available, std::max(0.0, limit - used + reclaimable_bytes()) / 1048576.0);
  return available;
}

}  // namespace stiffront
