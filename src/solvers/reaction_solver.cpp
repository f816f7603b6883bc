// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/solvers/reaction_solver.hpp"

namespace stiffront {

CellRun run_of(const Field& from, Field& to, int i_begin, int i_end, int j, std::vector<double>& hint, std::vector<float>& cost) {
  const Decomposition& d = from.decomposition();
  const std::ptrdiff_t first = static_cast<std::ptrdiff_t>(j) * from.n_x() + i_begin;
  return {i_end - i_begin,     from.row(0, j) + i_begin, from.species_stride(),  to.row(0, j) + i_begin, to.species_stride(),
          hint.data() + first, cost.data() + first,      d.offset_x() + i_begin, d.offset_y() + j};
}

std::optional<CellFailure> ReactionSolver::advance(double t, double dt, const Field& from, Field& to, const FreeBox& box,
                                                   std::vector<double>& hint, std::vector<float>& cost, Work& work) {
  begin(from.decomposition().grid(), t, dt);
  for (int j = box.j_begin; j < box.j_end; ++j) run(run_of(from, to, box.i_begin, box.i_end, j, hint, cost));
  return finish(work);
}

}  // namespace stiffront
