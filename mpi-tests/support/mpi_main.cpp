// SPDX-License-Identifier: BSD-3-Clause
// Gathers the verdict of every rank: the stock printer says PASSED on rank 0 while another rank failed.
#include <gtest/gtest.h>
#include <mpi.h>

#include <string>

#include "support/mpi_ledger.hpp"

namespace {

class QuietUnlessFailed : public ::testing::EmptyTestEventListener {
  void OnTestPartResult(const ::testing::TestPartResult& result) override {
    if (!result.failed()) return;
    int rank = 0;
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    std::fprintf(stderr, "[rank %d] %s:%d: %s\n", rank, result.file_name() ? result.file_name() : "?", result.line_number(),
                 result.message());
  }
};

}  // namespace

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  ::testing::InitGoogleTest(&argc, argv);
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  if (rank != 0) {
    auto& listeners = ::testing::UnitTest::GetInstance()->listeners();
    delete listeners.Release(listeners.default_result_printer());
    listeners.Append(new QuietUnlessFailed);
  }
  int failed = RUN_ALL_TESTS();
  int failed_anywhere = 0;
  MPI_Allreduce(&failed, &failed_anywhere, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  if (rank == 0 && failed_anywhere != 0 && failed == 0) std::fprintf(stderr, "[  FAILED  ] on a rank other than 0\n");
  MPI_Finalize();
  // Only now: what belongs to the whole process is freed by MPI_Finalize itself.
  const stiffront::testing::MpiFindings findings = stiffront::testing::mpi_findings();
  if (findings.any()) {
    std::fprintf(
        stderr,
        "[  FAILED  ] rank %d: not freed: %d persistent requests, %d requests under way, %d communicators, %d datatypes, %d operations; "
        "%d stray messages; "
        "unequal collective calls on %d communicators\n",
        rank, findings.unfreed_requests, findings.open_requests, findings.unfreed_communicators, findings.unfreed_types,
        findings.unfreed_operations, findings.stray_messages, findings.unequal_collectives);
    return 1;
  }
  return failed_anywhere;
}
