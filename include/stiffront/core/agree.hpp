// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <functional>

#include "stiffront/core/mpi.hpp"

namespace stiffront {

/// Runs f on every rank and makes one rank's failure every rank's: if any call throws, the lowest failing rank's error is
/// thrown on all ranks, with its kind and text.
///
/// f must not communicate on comm after a failure of its own. Exceptions that are no Error become ErrorKind::bug.
/// @mpi collective on comm.
void collectively(const Communicator& comm, const std::function<void()>& f);

}  // namespace stiffront
