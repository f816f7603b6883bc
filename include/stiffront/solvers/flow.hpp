// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "stiffront/mesh/field.hpp"
#include "stiffront/solvers/work.hpp"

namespace stiffront {

/// A cell that could not be integrated, with all that is needed to look at it alone.
struct CellFailure {
  std::int64_t i = 0, j = 0;  ///< global indices
  double x = 0.0, y = 0.0;
  double begin = 0.0;         ///< where the sub-step began
  double t = 0.0;             ///< time reached
  double dt = 0.0;            ///< inner step at which it failed; 0: there is none
  double interval = 0.0;      ///< length of the whole sub-step asked for
  std::vector<double> state;  ///< at the beginning of the sub-step
  int species = -1;           ///< the one whose value gave offence, if it was one
  std::string reason;
};

/// One state to be advanced. `from` and `to` may be the same field; otherwise the interior of `from` is not changed. Halos of
/// either are working space.
struct Transition {
  Field* from;
  Field* to;
};

/// Advances one or several states by dt under one physical process, choosing its own inner steps.
class Flow {
 public:
  virtual ~Flow() = default;

  /// @return a failure seen on this rank only; the other ranks learn of it in the caller's next agreement. After a failure the
  ///         states are finite but meaningless, so that the caller can go on to that agreement.
  /// @mpi collective: every rank passes the same t, dt and number of states.
  virtual std::optional<CellFailure> advance(double t, double dt, std::span<const Transition> states, Work& work) = 0;

  std::optional<CellFailure> advance(double t, double dt, Field& from, Field& to, Work& work) {
    const Transition one{&from, &to};
    return advance(t, dt, std::span<const Transition>(&one, 1), work);
  }

  /// Numbers that must survive a restart for the run to continue bitwise (inner step sizes and the like); the same on all ranks.
  virtual std::vector<double> state() const { return {}; }
  virtual void set_state(std::span<const double>) {}
  /// The flow goes on from these numbers, its state() of another time, and leaves its own in their place. Takes no memory.
  virtual void exchange_state(std::span<double> numbers) { static_cast<void>(numbers); }
};

}  // namespace stiffront
