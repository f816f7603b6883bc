// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "stiffront/core/mpi.hpp"
#include "stiffront/mesh/boundary.hpp"
#include "stiffront/mesh/field.hpp"
#include "stiffront/solvers/flow.hpp"
#include "stiffront/solvers/work.hpp"

namespace stiffront {

/// Flags or-ed over all ranks in the agreement of a step attempt. The lower half belongs to methods, the upper half to whoever
/// drives the loop (signals, limits) and is only passed through.
namespace step_flags {
inline constexpr std::uint64_t cell_failed = 1U << 0;       ///< a cell could not be integrated
inline constexpr std::uint64_t not_finite = 1U << 1;        ///< the new state holds a NaN or an infinity
inline constexpr std::uint64_t negative = 1U << 2;          ///< the new state holds a negative value
inline constexpr std::uint64_t refuse_negative = 1U << 3;   ///< asked of the method: then the attempt is rejected
inline constexpr std::uint64_t companion_failed = 1U << 4;  ///< the second solution that tells the error could not be advanced
inline constexpr std::uint64_t first_of_driver = 1ULL << 32;
}  // namespace step_flags

/// Why a state with these agreed flags is no result, whatever its error; null if it may be one.
const char* refusal(std::uint64_t flags);

/// The first point of this rank's box at which `after` is not finite, or negative if flags say that this is refused: with its state in
/// `before`, for the report. Nothing if the flags tell of no such value or another rank has it.
std::optional<CellFailure> find_refused_value(std::uint64_t flags, const Field& before, const Field& after, const FreeBox& box, double t,
                                              double dt);

/// What became of one attempt to make a step. The same on all ranks, but for work (see Work) and failure.
struct Attempt {
  bool accepted = false;
  double error = 0.0;        ///< estimate of the local error in the method's norm; 0 for fixed steps
  double dt_next = 0.0;      ///< size proposed for the next attempt, from here if accepted, from the same time if not
  double dt_taken = 0.0;     ///< if positive: an accepted attempt went this far instead of dt
  int iterations = 0;        ///< corrections, or the order of a multistep method
  double epsilon = 0.0;      ///< shift of the embedded splitting, where there is one
  double critical_dt = 0.0;  ///< critical splitting step, where there is one
  Work work;
  std::string reason;                  ///< why it was rejected, or a warning; empty if nothing is to be said
  std::optional<CellFailure> failure;  ///< on the ranks that saw one
};

/// Receives or supplies everything a run must remember to go on bitwise after a restart. One function serves both ways.
class StateVisitor {
 public:
  virtual ~StateVisitor() = default;
  /// Numbers that are the same on all ranks. On loading the vector gets the stored size.
  virtual void numbers(const std::string& name, std::vector<double>& values) = 0;
  /// A distributed field.
  virtual void field(const std::string& name, Field& values) = 0;
  /// One number per point of this rank's box, [n_y][n_x].
  virtual void cells(const std::string& name, std::vector<double>& values) = 0;

  void number(const std::string& name, double& x) {
    std::vector<double> v{x};
    numbers(name, v);
    x = v.at(0);
  }
  template <class Integer>
  void integer(const std::string& name, Integer& x) {
    double d = static_cast<double>(x);
    number(name, d);
    x = static_cast<Integer>(d);
  }
};

/// Whether a state with these agreed flags is no result, whatever its error. The attempt then says why, and where this rank has the value
/// and no cell is to blame yet, which point: see refusal and find_refused_value.
bool refuses(Attempt& a, std::uint64_t flags, const Field& before, const Field& after, const FreeBox& box, double t, double dt);

/// A way of advancing the whole state one step at a time, with its own step-size control.
class Method {
 public:
  virtual ~Method() = default;

  /// The first step to try from u at t; called before the first attempt, and again after restart(). @mpi collective.
  virtual double first_step(double t, double t_end, Field& u) = 0;

  /// Tries to go from t to t + dt. The interior of u is not changed; u_new holds the result of an accepted attempt.
  ///
  /// The method adds its norms to the agreement after the ones the caller passes in flags, and agrees exactly once, when all its
  /// work is done: the caller's flags and every rank's failures travel with it. (Inner solvers have reductions of their own.)
  /// @pre 0 < dt; u and u_new are distinct. @mpi collective: the same t and dt on every rank.
  virtual Attempt attempt(double t, double dt, Field& u, Field& u_new, std::uint64_t& flags) = 0;

  /// The attempt just made is taken: u becomes the new state. Storage may change hands, so that nothing is copied.
  virtual void accept(Field& u, Field& u_new) { swap(u, u_new); }

  /// The data jump at t: forget history and estimates.
  virtual void restart(double t) { static_cast<void>(t); }

  /// Whether after a step cut short (to hit an output time or the end) the size planned before may be taken up again at once.
  virtual bool resumes_after_short_step() const { return true; }

  /// Estimate of the error of u, the state at t at the end of a run, in the method's norm; nothing if the method has none.
  /// @param work what it takes to find out is added. @mpi collective.
  virtual std::optional<double> final_error(double t, Field& u, Work& work) {
    static_cast<void>(t);
    static_cast<void>(u);
    static_cast<void>(work);
    return std::nullopt;
  }

  /// What the user should know of the whole run, in one sentence; empty if nothing.
  virtual std::string closing_note() const { return {}; }

  virtual void visit_state(StateVisitor& visitor) { static_cast<void>(visitor); }
};

}  // namespace stiffront
