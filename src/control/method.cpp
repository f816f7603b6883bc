// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/method.hpp"

#include <fmt/format.h>

#include <cmath>

namespace stiffront {

const char* refusal(std::uint64_t flags) {
  if ((flags & step_flags::cell_failed) != 0) return "a cell could not be integrated";
  if ((flags & step_flags::not_finite) != 0) return "the new state is not finite";
  if ((flags & step_flags::negative) != 0 && (flags & step_flags::refuse_negative) != 0) return "the new state is negative somewhere";
  return nullptr;
}

std::optional<CellFailure> find_refused_value(std::uint64_t flags, const Field& before, const Field& after, const FreeBox& box, double t,
                                              double dt) {
  const bool not_finite = (flags & step_flags::not_finite) != 0;
  const bool negative = (flags & step_flags::negative) != 0 && (flags & step_flags::refuse_negative) != 0;
  if (!not_finite && !negative) return std::nullopt;
  const Decomposition& d = after.decomposition();
  for (int j = box.j_begin; j < box.j_end; ++j) {
    for (int i = box.i_begin; i < box.i_end; ++i) {
      for (int s = 0; s < after.n_species(); ++s) {
        const double value = after.at(s, i, j);
        if (!(not_finite && !std::isfinite(value)) && !(negative && value < 0.0)) continue;
        CellFailure f;
        f.i = d.offset_x() + i;
        f.j = d.offset_y() + j;
        f.x = d.grid().position(0, f.i);
        f.y = d.grid().dimension == 2 ? d.grid().position(1, f.j) : 0.0;
        f.begin = t;
        f.t = t + dt;
        f.interval = dt;
        for (int k = 0; k < before.n_species(); ++k) f.state.push_back(before.at(k, i, j));
        f.species = s;
        f.reason = fmt::format("it becomes {:.6g}", value);
        return f;
      }
    }
  }
  return std::nullopt;
}

bool refuses(Attempt& a, std::uint64_t flags, const Field& before, const Field& after, const FreeBox& box, double t, double dt) {
  const char* why = refusal(flags);
  if (why == nullptr) return false;
  a.reason = why;
  if (!a.failure) a.failure = find_refused_value(flags, before, after, box, t, dt);
  return true;
}

}  // namespace stiffront
