// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/control/parareal.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "stiffront/core/error.hpp"
#include "stiffront/mesh/field_algebra.hpp"

namespace stiffront {
namespace {

constexpr int tag = 51;

/// f(row) for every row of every species, a pointer to n_x numbers.
template <class F>
void for_each_row(Field& u, F&& f) {
  for (int s = 0; s < u.n_species(); ++s) {
    for (int j = 0; j < u.n_y(); ++j) f(u.row(s, j));
  }
}

}  // namespace

Parareal::Parareal(const Field& shape, int intervals, const Communicator& time, Coarse coarse) : time_(&time), coarse_(std::move(coarse)) {
  if (intervals < time.size()) {
    throw Error(ErrorKind::input, fmt::format("{} groups cannot share {} intervals: each needs one", time.size(), intervals));
  }
  first_ = intervals * time.rank() / time.size();
  last_ = intervals * (time.rank() + 1) / time.size();
  states_.push_back(shape.similar());
  for (int i = first_; i < last_; ++i) {
    states_.push_back(shape.similar());
    coarse_results_.push_back(shape.similar());
    fine_results_.push_back(shape.similar());
  }
  message_.resize(static_cast<std::size_t>(shape.n_species()) * static_cast<std::size_t>(shape.n_x()) *
                  static_cast<std::size_t>(shape.n_y()));
}

void Parareal::receive_left_end() {
  if (time_->rank() == 0) return;
  check_mpi(
      MPI_Recv(message_.data(), static_cast<int>(message_.size()), MPI_DOUBLE, time_->rank() - 1, tag, time_->get(), MPI_STATUS_IGNORE),
      "MPI_Recv");
  const double* from = message_.data();
  for_each_row(states_.front(), [&](double* row) {
    std::copy_n(from, states_.front().n_x(), row);
    from += states_.front().n_x();
  });
}

void Parareal::send_right_end() {
  if (time_->rank() + 1 == time_->size()) return;
  double* to = message_.data();
  for_each_row(states_.back(), [&](const double* row) { to = std::copy_n(row, states_.back().n_x(), to); });
  check_mpi(MPI_Send(message_.data(), static_cast<int>(message_.size()), MPI_DOUBLE, time_->rank() + 1, tag, time_->get()), "MPI_Send");
}

void Parareal::predict(const Field& initial) {
  if (time_->rank() == 0) states_.front().copy_interior(initial);
  receive_left_end();
  for (std::size_t j = 0; j < coarse_results_.size(); ++j) {
    coarse_(first_ + static_cast<int>(j), states_[j], coarse_results_[j]);
    states_[j + 1].copy_interior(coarse_results_[j]);
  }
  send_right_end();
}

double Parareal::iterate(const Fine& fine) {
  fine(states_, fine_results_);
  receive_left_end();
  double change = 0.0;
  for (std::size_t j = 0; j < coarse_results_.size(); ++j) {
    // F u^k - G u^k, then G u^{k+1} on top.
    const Term difference[] = {{1.0, &fine_results_[j]}, {-1.0, &coarse_results_[j]}};
    combine(difference, fine_results_[j]);
    coarse_(first_ + static_cast<int>(j), states_[j], coarse_results_[j]);
    const Term sum[] = {{1.0, &coarse_results_[j]}, {1.0, &fine_results_[j]}};
    combine(sum, fine_results_[j]);
    swap(states_[j + 1], fine_results_[j]);
    for (int s = 0; s < states_[j + 1].n_species(); ++s) {
      for (int y = 0; y < states_[j + 1].n_y(); ++y) {
        for (int x = 0; x < states_[j + 1].n_x(); ++x) {
          change = std::max(change, std::abs(states_[j + 1].at(s, x, y) - fine_results_[j].at(s, x, y)));
        }
      }
    }
  }
  send_right_end();
  return change;
}

double parareal_speed_up(int groups, int iterations, double coarse_over_fine) {
  return 1.0 / (coarse_over_fine + static_cast<double>(iterations) / groups * (1.0 + coarse_over_fine));
}

}  // namespace stiffront
