// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/io/output.hpp"

#include <utility>

#include "file.hpp"
#include "stiffront/core/agree.hpp"
#include "stiffront/core/timer.hpp"
#include "stiffront/io/result_file.hpp"
#include "stiffront/io/step_interpolation.hpp"

namespace stiffront {

Output::Output(const OutputDirectory& directory, const Decomposition& decomposition, const Boundary& boundary, CoupledRhs& rhs,
               Options options)
    : directory_(&directory),
      boundary_(&boundary),
      rhs_(&rhs),
      options_(std::move(options)),
      history_(directory.comm(), directory.file("history.csv")),
      probes_(decomposition, directory.file("probes.csv"), options_.probes, options_.species),
      series_(directory.file("fields.xdmf"), decomposition.grid(), options_.species) {}

std::vector<double> Output::landing_times() const { return options_.land ? options_.times.inner() : std::vector<double>(); }

void Output::begin(double t, const Field& u) {
  const ScopedTimer timer(seconds_);
  history_.begin();
  probes_.begin();
  write(0, 0, t, false, u);
}

void Output::resume(std::int64_t accepted) {
  const ScopedTimer timer(seconds_);
  history_.resume(accepted);
  probes_.resume(accepted);
  collectively(directory_->comm(), [&] {
    if (!directory_->comm().is_root()) return;
    directory_->remove_states_after(accepted);
    directory_->remove_failures();
    for (const std::string& name : directory_->state_names()) series_.add(read_header(directory_->file(name)).time, name);
    series_.write();
  });
}

void Output::attempted(const StepRecord& record, double seconds) {
  history_.add(record, seconds);
  if (!history_.is_full()) return;
  const ScopedTimer timer(seconds_);
  history_.flush();
}

int Output::stepped(const StepRecord& record, double t_new, Field& u, Field& u_new) {
  const std::int64_t step = record.step + 1;
  probes_.add(step, t_new, u_new);
  const bool at_end = options_.times.due_at(t_new, step);
  const std::vector<double> inside = options_.land ? std::vector<double>() : options_.times.between(record.t, t_new);
  if (inside.empty() && !at_end) return 0;
  const ScopedTimer timer(seconds_);
  if (!inside.empty()) {
    const StepInterpolation interpolation(*rhs_, record.begin, u, record.end, u_new);
    Field state = u.similar();
    for (std::size_t k = 0; k < inside.size(); ++k) {
      interpolation.at(inside[k], state);
      // The last state of a step has the plain name, so that names in alphabetical order are in order of time.
      const bool last = k + 1 == inside.size() && !at_end;
      write(step, last ? 0 : static_cast<int>(k) + 1, inside[k], true, state);
    }
  }
  if (at_end) write(step, 0, t_new, false, u_new);
  flush();
  return static_cast<int>(inside.size()) + (at_end ? 1 : 0);
}

void Output::flush() {
  history_.flush();
  probes_.flush();
}

void Output::record_failure(std::int64_t step, double t, const Field& u, const std::string& cell_case) const {
  write_state(directory_->file(OutputDirectory::failed_state_name(step)), {t, step, false, options_.species, options_.case_text},
              *boundary_, u);
  collectively(directory_->comm(), [&] {
    if (directory_->comm().is_root() && !cell_case.empty()) file::replace(directory_->file(OutputDirectory::failed_cell), cell_case);
  });
}

void Output::write(std::int64_t step, int index, double t, bool interpolated, const Field& u) {
  const std::string name = OutputDirectory::state_name(step, index);
  write_state(directory_->file(name), {t, step, interpolated, options_.species, options_.case_text}, *boundary_, u);
  series_.add(t, name);
  collectively(directory_->comm(), [&] {
    if (directory_->comm().is_root()) series_.write();
  });
  ++files_;
}

}  // namespace stiffront
