// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/io/probes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "csv.hpp"
#include "file.hpp"
#include "stiffront/core/agree.hpp"
#include "stiffront/core/error.hpp"

namespace stiffront {
namespace {

/// The two grid points around x in one direction and how much the upper one counts.
struct Bracket {
  std::int64_t lower, upper;
  double fraction;
};

Bracket bracket(const Grid& grid, int direction, double x) {
  const auto d = static_cast<std::size_t>(direction);
  const std::int64_t n = grid.uniform_points(direction);
  const std::int64_t intervals = grid.intervals(direction);
  auto i = static_cast<std::int64_t>(std::floor((x - grid.lower[d]) / grid.spacing(direction)));
  i = std::clamp<std::int64_t>(i, 0, intervals - 1);
  const std::int64_t lower = grid.index_of_uniform(direction, i);
  double fraction = (x - grid.position(direction, lower)) / grid.spacing(direction);
  // A point that was meant to lie on the grid gets the grid point's value itself.
  constexpr double tiny = 1e-9;
  if (fraction < tiny) fraction = 0.0;
  if (fraction > 1.0 - tiny) fraction = 1.0;
  return {lower, grid.index_of_uniform(direction, (i + 1) % n), fraction};
}

}  // namespace

Probes::Probes(const Decomposition& decomposition, std::string path, std::vector<std::array<double, 2>> points,
               const std::vector<std::string>& species)
    : decomposition_(&decomposition), path_(std::move(path)), points_(std::move(points)), n_species_(species.size()), header_("step,time") {
  const Grid& grid = decomposition.grid();
  const bool plane = grid.dimension == 2;
  for (std::size_t p = 0; p < points_.size(); ++p) {
    const auto [x, y] = points_[p];
    const auto inside = [&](double z, std::size_t d) { return z >= grid.lower[d] && z <= grid.upper[d]; };
    if (!inside(x, 0) || (plane && !inside(y, 1))) {
      throw Error(ErrorKind::input,
                  plane ? fmt::format("output.probes: the point ({}, {}) is outside of [{}, {}] x [{}, {}]", x, y, grid.lower[0],
                                      grid.upper[0], grid.lower[1], grid.upper[1])
                        : fmt::format("output.probes: the point {} is outside of [{}, {}]", x, grid.lower[0], grid.upper[0]));
    }
    for (const std::string& s : species) header_ += plane ? fmt::format(",{}@{}:{}", s, x, y) : fmt::format(",{}@{}", s, x);
    const Bracket bx = bracket(grid, 0, x);
    const Bracket by = plane ? bracket(grid, 1, y) : Bracket{0, 0, 0.0};
    for (int l = 0; l < 2; ++l) {
      for (int k = 0; k < 2; ++k) {
        const double weight = (k == 0 ? 1.0 - bx.fraction : bx.fraction) * (l == 0 ? 1.0 - by.fraction : by.fraction);
        if (weight > 0.0) corners_.push_back({p, weight, k == 0 ? bx.lower : bx.upper, l == 0 ? by.lower : by.upper});
      }
    }
  }
}

void Probes::begin() {
  if (empty()) return;
  collectively(decomposition_->comm(), [&] {
    if (decomposition_->comm().is_root()) file::replace(path_, header_ + "\n");
  });
}

void Probes::resume(std::int64_t accepted) {
  if (empty()) return;
  collectively(decomposition_->comm(), [&] {
    if (decomposition_->comm().is_root()) csv::keep_up_to(path_, header_, accepted);
  });
}

void Probes::add(std::int64_t step, double t, const Field& u) {
  if (empty()) return;
  steps_.push_back(step);
  times_.push_back(t);
  for (const Corner& c : corners_) {
    const std::int64_t i = c.i - decomposition_->offset_x();
    const std::int64_t j = c.j - decomposition_->offset_y();
    const bool mine = i >= 0 && i < u.n_x() && j >= 0 && j < u.n_y();
    for (int s = 0; s < u.n_species(); ++s) {
      bits_.push_back(mine ? std::bit_cast<std::uint64_t>(u.at(s, static_cast<int>(i), static_cast<int>(j))) : 0);
    }
  }
  if (steps_.size() >= batch) flush();
}

void Probes::flush() {
  if (steps_.empty()) return;
  const Communicator& comm = decomposition_->comm();
  // Each number is held by one rank and zero on the others: or-ing the bits collects them unchanged.
  std::vector<std::uint64_t> all(bits_.size());
  check_mpi(MPI_Reduce(bits_.data(), all.data(), static_cast<int>(bits_.size()), MPI_UINT64_T, MPI_BOR, 0, comm.get()), "MPI_Reduce");
  collectively(comm, [&] {
    if (!comm.is_root()) return;
    std::string lines;
    std::vector<double> values(points_.size() * n_species_);
    for (std::size_t n = 0; n < steps_.size(); ++n) {
      std::fill(values.begin(), values.end(), 0.0);
      for (std::size_t c = 0; c < corners_.size(); ++c) {
        const std::uint64_t* bits = all.data() + (n * corners_.size() + c) * n_species_;
        double* value = values.data() + corners_[c].point * n_species_;
        for (std::size_t s = 0; s < n_species_; ++s) value[s] += corners_[c].weight * std::bit_cast<double>(bits[s]);
      }
      lines += fmt::format("{},{}", steps_[n], times_[n]);
      for (double v : values) lines += fmt::format(",{}", v);
      lines += "\n";
    }
    file::append(path_, lines);
  });
  steps_.clear();
  times_.clear();
  bits_.clear();
}

}  // namespace stiffront
