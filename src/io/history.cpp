// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/io/history.hpp"

#include <fmt/format.h>

#include "csv.hpp"
#include "file.hpp"
#include "stiffront/core/agree.hpp"

namespace stiffront {
namespace {

const std::string header = "step,time,dt,error,accepted,iterations,epsilon,critical_dt,diffusion_stages,reaction_steps,wall_seconds";

}  // namespace

void History::begin() {
  collectively(*comm_, [&] {
    if (comm_->is_root()) file::replace(path_, header + "\n");
  });
}

void History::resume(std::int64_t accepted) {
  collectively(*comm_, [&] {
    if (comm_->is_root()) csv::keep_up_to(path_, header, accepted - 1);
  });
}

void History::add(const StepRecord& record, double wall_seconds) {
  records_.push_back(record);
  records_.back().attempt.failure.reset();
  wall_seconds_.push_back(wall_seconds);
}

void History::flush() {
  if (records_.empty()) return;
  std::vector<std::int64_t> mine, total(records_.size());
  for (const StepRecord& r : records_) mine.push_back(r.attempt.work.reaction_steps);
  check_mpi(MPI_Reduce(mine.data(), total.data(), static_cast<int>(mine.size()), MPI_INT64_T, MPI_SUM, 0, comm_->get()), "MPI_Reduce");
  collectively(*comm_, [&] {
    if (!comm_->is_root()) return;
    std::string lines;
    for (std::size_t n = 0; n < records_.size(); ++n) {
      const StepRecord& r = records_[n];
      const Attempt& a = r.attempt;
      lines += fmt::format("{},{},{},{},{},{},{},{},{},{},{:.6g}\n", r.step, r.t, r.dt, a.error, a.accepted ? 1 : 0, a.iterations,
                           a.epsilon, a.critical_dt, a.work.diffusion_stages, total[n], wall_seconds_[n]);
    }
    file::append(path_, lines);
  });
  records_.clear();
  wall_seconds_.clear();
}

}  // namespace stiffront
