// SPDX-License-Identifier: BSD-3-Clause
#include "job.hpp"

#include <fmt/format.h>
#include <mpi.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <new>

#include "stiffront/core/error.hpp"
#include "stiffront/core/floating_point.hpp"
#include "stiffront/io/result_file.hpp"

namespace stiffront::app {
namespace {

constexpr double seconds_to_follow = 5.0;  // of the other ranks when one has failed

int world_rank() {
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  return rank;
}

/// Whether all ranks come here in time.
bool everyone_follows() {
  MPI_Request request = MPI_REQUEST_NULL;
  if (MPI_Ibarrier(MPI_COMM_WORLD, &request) != MPI_SUCCESS) return false;
  const double deadline = MPI_Wtime() + seconds_to_follow;
  int done = 0;
  while (done == 0 && MPI_Wtime() < deadline) {
    if (MPI_Test(&request, &done, MPI_STATUS_IGNORE) != MPI_SUCCESS) return false;
    const std::timespec a_moment{0, 1000000};
    nanosleep(&a_moment, nullptr);
  }
  return done != 0;
}

[[noreturn]] void abort_job(const std::string& message, ErrorKind kind) {
  complain(fmt::format("[rank {}] {}", world_rank(), message));
  MPI_Abort(MPI_COMM_WORLD, static_cast<int>(kind));
  std::abort();  // MPI_Abort does not return
}

int end_by_error(const Error& error) {
  if (error.kind() == ErrorKind::mpi) abort_job(error.what(), ErrorKind::mpi);
  if (!everyone_follows()) abort_job(error.what(), error.kind());
  if (world_rank() == 0) complain(error.what());
  return error.exit_status();
}

}  // namespace

bool speaks_without_mpi() {
  for (const char* name : {"OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK", "SLURM_PROCID"}) {
    if (const char* rank = std::getenv(name)) return std::string(rank) == "0";
  }
  return true;
}

void complain(const std::string& message) {
  std::fprintf(stderr, "stiffront: %s\n", message.c_str());
  std::fflush(stderr);
}

int run_on_all_ranks(int& argc, char**& argv, const std::function<void(const Communicator&)>& work) {
  // A file that reaches its size limit is to be an error of write(), not the end of the process.
  std::signal(SIGXFSZ, SIG_IGN);
  MPI_Init(&argc, &argv);
  MPI_Comm_set_errhandler(MPI_COMM_WORLD, MPI_ERRORS_RETURN);
  flush_denormals_to_zero();
  int status = 0;
  try {
    const Communicator world(MPI_COMM_WORLD);
    work(world);
  } catch (const Error& error) {
    status = end_by_error(error);
  } catch (const std::bad_alloc&) {
    abort_job("out of memory", ErrorKind::bug);
  } catch (const std::exception& error) {
    abort_job(fmt::format("a bug of the program: {}", error.what()), ErrorKind::bug);
  } catch (...) {
    abort_job("a bug of the program: an exception of unknown type", ErrorKind::bug);
  }
  if (must_end_by_abort()) MPI_Abort(MPI_COMM_WORLD, status != 0 ? status : static_cast<int>(ErrorKind::io));
  MPI_Finalize();
  return status;
}

}  // namespace stiffront::app
