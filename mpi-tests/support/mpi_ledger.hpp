// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace stiffront::testing {

/// What this process did with MPI so far, seen through its profiling interface, that it should not have done.
struct MpiFindings {
  int unfreed_requests = 0;       ///< persistent requests
  int open_requests = 0;          ///< messages and gathers under way that nobody waited for
  int unfreed_communicators = 0;  ///< duplicates and parts
  int unfreed_types = 0;          ///< committed datatypes
  int unfreed_operations = 0;
  int stray_messages = 0;       ///< messages nobody received on a communicator that was freed
  int unequal_collectives = 0;  ///< communicators freed whose ranks had not made the same collective calls with the same counts

  bool any() const {
    return unfreed_requests + open_requests + unfreed_communicators + unfreed_types + unfreed_operations + stray_messages +
               unequal_collectives !=
           0;
  }
};

MpiFindings mpi_findings();

}  // namespace stiffront::testing
