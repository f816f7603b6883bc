// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <stdexcept>
#include <string>

namespace stiffront {

/// Why a run ends. The value is the exit status of the program.
enum class ErrorKind : int {
  usage = 2,     ///< wrong command line
  input = 3,     ///< bad case file or input data
  numerics = 4,  ///< step-size underflow, non-finite solution, a cell that cannot be integrated
  io = 5,        ///< a file could not be read or written
  mpi = 6,       ///< the message-passing layer failed
  bug = 70,      ///< an invariant of ours is broken
  stopped = 75,  ///< stopped early on request, with a valid checkpoint
};

/// An error with a cause the caller can act on and one full sentence for the user.
///
/// Thrown only where every rank throws the same one (see core/agree.hpp).
class Error : public std::runtime_error {
 public:
  Error(ErrorKind kind, const std::string& message) : std::runtime_error(message), kind_(kind) {}

  ErrorKind kind() const noexcept { return kind_; }
  int exit_status() const noexcept { return static_cast<int>(kind_); }

 private:
  ErrorKind kind_;
};

}  // namespace stiffront
