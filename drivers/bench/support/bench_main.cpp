// SPDX-License-Identifier: BSD-3-Clause
// Fields and flows need MPI. Under mpirun every rank runs the same iterations (fix their number with Iterations()), and
// rank 0 reports its own times.
#include <benchmark/benchmark.h>
#include <mpi.h>

#include "stiffront/core/floating_point.hpp"

namespace {

class NoReport : public benchmark::BenchmarkReporter {
  bool ReportContext(const Context&) override { return true; }
  void ReportRuns(const std::vector<Run>&) override {}
};

}  // namespace

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  stiffront::flush_denormals_to_zero();  // as the program does
  benchmark::Initialize(&argc, argv);
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  NoReport silent;
  if (rank == 0) {
    benchmark::RunSpecifiedBenchmarks();
  } else {
    benchmark::RunSpecifiedBenchmarks(&silent);
  }
  MPI_Finalize();
  return 0;
}
