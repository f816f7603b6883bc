// SPDX-License-Identifier: BSD-3-Clause
// Serial tests may use fields and flows, which need MPI: it is initialised once, on one process.
#include <gtest/gtest.h>
#include <mpi.h>

#include <cstdlib>

#ifdef __SANITIZE_ADDRESS__
// Open MPI keeps memory until the process ends and unloads its plug-ins before, so no suppression can name it.
extern "C" const char* __asan_default_options();
extern "C" const char* __asan_default_options() { return "detect_leaks=0"; }
#endif

int main(int argc, char** argv) {
  // Every test is a process of its own: MPI_Init takes 0.1 s without a search for networks, else 0.3 s.
  setenv("OMPI_MCA_pml", "ob1", 0);
  setenv("OMPI_MCA_btl", "self", 0);
  MPI_Init(&argc, &argv);
  ::testing::InitGoogleTest(&argc, argv);
  const int status = RUN_ALL_TESTS();
  MPI_Finalize();
  return status;
}
