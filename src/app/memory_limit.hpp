// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "stiffront/app/options.hpp"
#include "stiffront/core/mpi.hpp"

namespace stiffront::app {

/// Refuses a case that needs more memory than its hosts have, before anything is allocated: the system would kill the ranks one by one,
/// long into the run.
/// @throws Error(input) on every rank, with both numbers. @mpi collective.
void require_memory(const Case& c, const Communicator& comm);

}  // namespace stiffront::app
