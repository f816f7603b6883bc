// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/core/agree.hpp"

#include <new>
#include <optional>
#include <string>

#include "stiffront/core/error.hpp"

namespace stiffront {

void collectively(const Communicator& comm, const std::function<void()>& f) {
  std::optional<Error> mine;
  try {
    f();
  } catch (const Error& e) {
    mine = e;
  } catch (const std::bad_alloc&) {
    mine = Error(ErrorKind::bug, "out of memory");
  } catch (const std::exception& e) {
    mine = Error(ErrorKind::bug, e.what());
  } catch (...) {
    mine = Error(ErrorKind::bug, "an exception of unknown type");
  }
  // The lowest failing rank is the largest of the negated ranks.
  const auto candidate = static_cast<std::int64_t>(mine ? -comm.rank() : -comm.size());
  const int lowest = static_cast<int>(-comm.max(candidate));
  if (lowest == comm.size()) return;
  int kind = mine ? mine->exit_status() : 0;
  check_mpi(MPI_Bcast(&kind, 1, MPI_INT, lowest, comm.get()), "MPI_Bcast");
  const std::string message = comm.broadcast(mine ? mine->what() : "", lowest);
  throw Error(static_cast<ErrorKind>(kind), message);
}

}  // namespace stiffront
