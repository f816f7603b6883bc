// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <functional>
#include <vector>

#include "stiffront/core/mpi.hpp"
#include "stiffront/mesh/field.hpp"

namespace stiffront {

/// The parareal iteration over n intervals of time, each group of processes holding some of them:
///
///     u_i^0     = G u_{i-1}^0                                        (50)
///     u_i^{k+1} = F u_{i-1}^k + G u_{i-1}^{k+1} - G u_{i-1}^k        (51)
///
/// The processes form a grid, space by time: a group shares a communicator in space, over which its fields are distributed, and the
/// processes with the same part of space share one in time, whose rank numbers the groups. All fine propagations run at once; the
/// coarse ones go from group to group, each starting as soon as the state at its left end has come.
///
/// After k iterations the first k intervals hold the fine solution. With the nodes of a Radau IIA step as ends of the intervals, a splitting
/// as G and the quadrature between the nodes in place of F it is DC-S.
/// @see Lions, Maday & Turinici, C. R. Acad. Sci. Paris I 332, 2001; Duarte & Emmett 2016, appendix A
class Parareal {
 public:
  /// G over interval i from one state to another.
  using Coarse = std::function<void(int interval, Field& from, Field& to)>;
  /// F over all intervals of this group: states[j] holds the state at the left end of its j-th interval, states.back() that at the right
  /// end of the last; results[j] gets what F makes of states[j], or another better value at the right end of the interval.
  using Fine = std::function<void(std::vector<Field>& states, std::vector<Field>& results)>;

  /// @param shape any field of the group's decomposition
  /// @param intervals n, at least one for each group
  /// @throws Error(input) for fewer
  Parareal(const Field& shape, int intervals, const Communicator& time, Coarse coarse);

  /// This group's intervals are first() .. last() - 1.
  int first() const { return first_; }
  int last() const { return last_; }
  /// (50), from the initial state. @mpi collective over space and time.
  void predict(const Field& initial);
  /// (51) once. @return largest change of this process's values, in their units. @mpi collective over space and time.
  double iterate(const Fine& fine);
  /// The state at the left end of this group's interval j, counted from first(); j = last() - first() is the right end of the last.
  Field& state(int j) { return states_[static_cast<std::size_t>(j)]; }

 private:
  void receive_left_end();
  void send_right_end();

  const Communicator* time_;
  Coarse coarse_;
  int first_;
  int last_;
  std::vector<Field> states_;  // at the ends of the intervals
  std::vector<Field> coarse_results_;
  std::vector<Field> fine_results_;
  std::vector<double> message_;
};

/// How many times faster than the fine propagation alone: the coarse prediction, and in every iteration each group's share of fine and
/// coarse propagations, groups overlapping.
/// @param coarse_over_fine cost of G over that of F on one interval
double parareal_speed_up(int groups, int iterations, double coarse_over_fine);

}  // namespace stiffront
