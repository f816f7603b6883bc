// SPDX-License-Identifier: BSD-3-Clause
// A job that fails as its first argument says; job_failures.sh watches how it ends.
#include <mpi.h>

#include <stdexcept>
#include <string>

#include "../../src/app/job.hpp"
#include "stiffront/core/error.hpp"

int main(int argc, char** argv) {
  using stiffront::Error;
  using stiffront::ErrorKind;
  const std::string how = argc > 1 ? argv[1] : "";
  return stiffront::app::run_on_all_ranks(argc, argv, [&how](const stiffront::Communicator& comm) {
    const bool last = comm.rank() == comm.size() - 1;
    if (how == "error-on-all") throw Error(ErrorKind::numerics, "the step size fell below its limit");
    if (how == "stopped-on-all") throw Error(ErrorKind::stopped, "stopped on request");
    if (how == "error-on-one" && last) throw Error(ErrorKind::input, "seen by one rank alone");
    if (how == "exception-on-one" && last) throw std::runtime_error("nobody expected this");
    if (how == "memory-on-one" && last) throw std::bad_alloc();
    if (how == "unknown-on-one" && last) throw 42;
    if (how == "mpi-on-one" && last) throw Error(ErrorKind::mpi, "MPI_Bcast failed");
    comm.barrier();
  });
}
