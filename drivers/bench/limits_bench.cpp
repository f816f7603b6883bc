// SPDX-License-Identifier: BSD-3-Clause
// What this machine gives at best on one core: the roofs of docs/performance.md.
#include <benchmark/benchmark.h>

#include <vector>

#include "stiffront/core/simd.hpp"
#include "stiffront/core/simd_math.hpp"

namespace {

using stiffront::Pack;

constexpr int chains = 16;  // independent, so that latency does not count

void multiply_adds(benchmark::State& state) {
  Pack x[chains];
  for (int k = 0; k < chains; ++k) x[k] = Pack(1.0 + k);
  const Pack a(0.999999), b(1e-6);
  for (auto _ : state) {
    for (int repeat = 0; repeat < 64; ++repeat) {
      for (Pack& v : x) v = mul_add(v, a, b);
    }
    benchmark::DoNotOptimize(x);
  }
  state.counters["flops"] =
      benchmark::Counter(2.0 * 64 * chains * stiffront::pack_size * static_cast<double>(state.iterations()), benchmark::Counter::kIsRate);
}
BENCHMARK(multiply_adds);

void divisions(benchmark::State& state) {
  Pack x[chains];
  for (int k = 0; k < chains; ++k) x[k] = Pack(1.0 + k);
  const Pack a(1.000001);
  for (auto _ : state) {
    for (int repeat = 0; repeat < 64; ++repeat) {
      for (Pack& v : x) v = v / a;
    }
    benchmark::DoNotOptimize(x);
  }
  state.counters["divisions"] =
      benchmark::Counter(64.0 * chains * stiffront::pack_size * static_cast<double>(state.iterations()), benchmark::Counter::kIsRate);
}
BENCHMARK(divisions);

/// a = b + s c over three arrays of KiB in all, 24 bytes an element; what a store reads first is not counted.
void triad(benchmark::State& state) {
  const auto n = static_cast<std::size_t>(state.range(0)) * 1024 / 24;
  std::vector<double> a(n, 1.0), b(n, 2.0), c(n, 3.0);
  for (auto _ : state) {
    for (std::size_t i = 0; i < n; ++i) a[i] = b[i] + 0.5 * c[i];
    benchmark::ClobberMemory();
  }
  state.SetBytesProcessed(static_cast<std::int64_t>(24 * n) * state.iterations());
}
BENCHMARK(triad)->ArgName("KiB")->Arg(24)->Arg(512)->Arg(12 * 1024)->Arg(512 * 1024);

/// The sum of six arrays, 48 bytes an element: the history of a step.
void six_streams(benchmark::State& state) {
  const auto n = static_cast<std::size_t>(state.range(0)) * 1024 / 48;
  std::vector<std::vector<double>> arrays(6, std::vector<double>(n, 1.0));
  const double* p[6];
  for (int k = 0; k < 6; ++k) p[k] = arrays[static_cast<std::size_t>(k)].data();
  for (auto _ : state) {
    Pack sum(0.0);
    for (std::size_t i = 0; i + stiffront::pack_size <= n; i += stiffront::pack_size) {
      for (const double* q : p) sum += Pack::load(q + i);
    }
    benchmark::DoNotOptimize(sum);
  }
  state.SetBytesProcessed(static_cast<std::int64_t>(48 * n) * state.iterations());
}
BENCHMARK(six_streams)->ArgName("KiB")->Arg(512)->Arg(9 * 1024)->Arg(512 * 1024);

}  // namespace
