// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <functional>
#include <string>

#include "stiffront/core/mpi.hpp"

namespace stiffront::app {

/// Whether this process is the first one its launcher started, or the only one. Needs no MPI.
bool speaks_without_mpi();

/// One line on standard error.
void complain(const std::string& message);

/// Runs `work` on every rank between MPI_Init and MPI_Finalize, with denormals flushed, and returns the exit status.
///
/// An Error is printed once, by root, when every rank has failed; what only one rank sees is printed by that rank and
/// aborts the job, as do exceptions that are no Error and failures of MPI itself. So a failure ends every rank, soon.
int run_on_all_ranks(int& argc, char**& argv, const std::function<void(const Communicator&)>& work);

}  // namespace stiffront::app
