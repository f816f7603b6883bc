// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <sundials/sundials_nvector.h>

#include <cstdint>

#include "stiffront/core/mpi.hpp"

namespace stiffront {

/// A distributed vector for SUNDIALS whose sums over all ranks are order-free, so that CVODE takes the same steps on any number of
/// ranks. On one rank it may be used with SUNDIALS' direct solvers.
///
/// @param length of this rank's part. @param global_length over all ranks.
N_Vector make_sundials_vector(const Communicator& comm, std::int64_t length, std::int64_t global_length, SUNContext context);

}  // namespace stiffront
