// SPDX-License-Identifier: BSD-3-Clause
#include <mpi.h>

#include <cstdio>

#include "stiffront/core/error.hpp"
#include "stiffront/core/version.hpp"

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  std::printf("consumer of stiffront %s\n", stiffront::version::number);
  const stiffront::Error stopped(stiffront::ErrorKind::stopped, "stopped on request");
  MPI_Finalize();
  return stopped.exit_status() == 75 ? 0 : 1;
}
