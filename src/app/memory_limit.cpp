// SPDX-License-Identifier: BSD-3-Clause
#include "memory_limit.hpp"

#include <fmt/format.h>

#include "guidance.hpp"
#include "stiffront/core/agree.hpp"
#include "stiffront/core/error.hpp"
#include "stiffront/io/memory.hpp"

namespace stiffront::app {
namespace {

int ranks_on_this_host(const Communicator& comm) {
  MPI_Comm host = MPI_COMM_NULL;
  check_mpi(MPI_Comm_split_type(comm.get(), MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &host), "MPI_Comm_split_type");
  int ranks = 1;
  MPI_Comm_size(host, &ranks);
  MPI_Comm_free(&host);
  return ranks;
}

}  // namespace

void require_memory(const Case& c, const Communicator& comm) {
  const int here = ranks_on_this_host(comm);
  const double needed = estimated_memory_mib(c) * here / comm.size();
  collectively(comm, [&] {
    const double available = available_memory_mib();
    if (available <= 0.0 || needed <= available) return;
    std::string points = fmt::format("{}", c.grid.points[0]);
    for (std::size_t d = 1; d < c.grid.points.size(); ++d) points += fmt::format(" x {}", c.grid.points[d]);
    throw Error(
        ErrorKind::input,
        fmt::format(
            "{}: grid.points: {} points need about {:.3g} GiB of memory on this host with its {} of {} processes, and {:.3g} GiB are "
            "free; take a coarser grid or processes on more hosts",
            c.file, points, needed / 1024.0, here, comm.size(), available / 1024.0));
  });
}

}  // namespace stiffront::app
