// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/solvers/coarse_grids.hpp"

#include <algorithm>
#include <utility>

namespace stiffront {

GridLine::GridLine(int n, bool is_periodic, bool has_fixed_lower, bool has_fixed_upper)
    : periodic(is_periodic), fixed_lower(has_fixed_lower), fixed_upper(has_fixed_upper), period(n) {
  for (int i = 0; i < n; ++i) position.push_back(i);
  share_length();
  differentiate();
}

GridLine::GridLine(const Grid& grid, int direction, bool has_fixed_lower, bool has_fixed_upper)
    : periodic(grid.periodic[static_cast<std::size_t>(direction)]),
      fixed_lower(has_fixed_lower),
      fixed_upper(has_fixed_upper),
      period(static_cast<double>(grid.points[static_cast<std::size_t>(direction)])) {
  for (std::int64_t i = 0; i < grid.points[static_cast<std::size_t>(direction)]; ++i) position.push_back(grid.place(direction, i));
  share_length();
  differentiate();
}

void GridLine::share_length() {
  const std::size_t n_points = position.size();
  share.assign(n_points, 1.0);
  if (n_points == 1) return;
  for (std::size_t i = 0; i < n_points; ++i) share[i] = 0.5 * (interval_before(i) + interval_before(i + 1));
}

double GridLine::interval_before(std::size_t i) const {
  const bool outside = i == 0 || i == position.size();
  if (!outside) return position[i] - position[i - 1];
  return periodic ? position[0] + period - position.back() : 0.0;
}

void GridLine::differentiate() {
  const std::size_t n_points = position.size();
  lower.assign(n_points, 0.0);
  upper.assign(n_points, 0.0);
  if (n_points == 1) return;
  for (std::size_t i = 0; i < n_points; ++i) {
    const double to_left = interval_before(i);
    const double to_right = interval_before(i + 1);
    if (to_left > 0.0) lower[i] = 1.0 / (to_left * share[i]);
    if (to_right > 0.0) upper[i] = 1.0 / (to_right * share[i]);
  }
}

double GridLine::coupling() const {
  const double intervals = periodic ? n() : n() - 1;
  const double length = periodic ? period : position.back() - position.front();
  return intervals > 0.0 ? (intervals / length) * (intervals / length) : 0.0;
}

GridLine GridLine::keep() {
  const int n_points = n();
  left.clear(), centre.clear();
  for (int i = 0; i < n_points; ++i) left.push_back(i), centre.push_back(i);
  by_left.assign(position.size(), 1.0);
  by_right.assign(position.size(), 0.0);
  before = after = by_right;
  at = by_left;
  return *this;
}

GridLine GridLine::coarsen() {
  const int n_points = n();
  const bool to_one = n_points == 2;
  const double spacing = position[1] - position[0];
  // Which of the last points stay is said in the header.
  const bool odd_end = !periodic && !to_one && n_points % 2 == 0;
  const bool keeps_odd_end = odd_end && (fixed_upper || beyond >= 0.5 * spacing);
  const bool drops_last = periodic && n_points % 2 == 1 && interval_before(0) < spacing;

  GridLine c;
  c.periodic = periodic, c.fixed_lower = fixed_lower, c.fixed_upper = fixed_upper, c.period = period, c.beyond = beyond;
  if (odd_end && !keeps_odd_end) c.beyond += position.back() - position[position.size() - 2];
  centre.clear();
  for (int i = 0; i < n_points; i += 2) centre.push_back(i);
  if (keeps_odd_end) centre.push_back(n_points - 1);
  if (drops_last) centre.pop_back();
  for (int i : centre) c.position.push_back(position[static_cast<std::size_t>(i)]);

  left.clear(), by_left.clear(), by_right.clear();
  for (int i = 0; i < n_points; ++i) {
    const auto here = static_cast<std::size_t>(i);
    left.push_back(i / 2);
    by_right.push_back(0.0);
    if (i == n_points - 1 && keeps_odd_end) left.back() += 1;
    if (i == n_points - 1 && drops_last) left.back() -= 1, by_right.back() = 1.0;
    const bool is_nearest = i % 2 == 0 || (i == n_points - 1 && odd_end) || (to_one && !periodic) || (i == n_points - 2 && drops_last);
    if (!is_nearest) {
      const double to = i + 1 < n_points ? position[here + 1] : position[0] + period;
      by_right.back() = (position[here] - position[here - 1]) / (to - position[here - 1]);
    }
    by_left.push_back(1.0 - by_right.back());
  }

  // The mean over the hat function of each coarse point.
  before.clear(), at.clear(), after.clear();
  for (std::size_t k = 0; k < centre.size(); ++k) {
    const int i = centre[k];
    const auto here = static_cast<std::size_t>(i);
    const auto weight_of = [&](int fine) {
      if (!periodic && (fine < 0 || fine >= n_points)) return 0.0;
      const auto f = static_cast<std::size_t>((fine + n_points) % n_points);
      if (std::binary_search(centre.begin(), centre.end(), static_cast<int>(f))) return 0.0;
      return share[f] * (fine < i ? by_right[f] : by_left[f]);
    };
    const double w_before = weight_of(i - 1);
    const double w_after = weight_of(i + 1);
    const double w_at = share[here];
    const double sum = (w_before + w_after) + w_at;
    c.share.push_back(sum);
    before.push_back(w_before / sum), at.push_back(w_at / sum), after.push_back(w_after / sum);
  }
  c.differentiate();
  return c;
}

namespace {

/// The part of a coarser line whose points lie in a part of this one: begin and number.
std::array<int, 2> part_of(const GridLine& fine, int begin, int n) {
  const auto first = std::lower_bound(fine.centre.begin(), fine.centre.end(), begin);
  const auto last = std::lower_bound(fine.centre.begin(), fine.centre.end(), begin + n);
  return {static_cast<int>(first - fine.centre.begin()), static_cast<int>(last - first)};
}

void find_unknowns(CoarseGrid& g) {
  const auto free = [&](std::size_t d) {
    const GridLine& line = g.lines[d];
    const int lo = line.fixed_lower ? 1 : 0;
    const int hi = line.n() - (line.fixed_upper ? 1 : 0);
    return std::array{std::max(lo - g.begin[d], 0), std::min(hi - g.begin[d], g.n[d])};
  };
  const auto [i_begin, i_end] = free(0);
  const auto [j_begin, j_end] = free(1);
  g.free = {i_begin, i_end, j_begin, j_end};
}

}  // namespace

std::vector<CoarseGrid> coarse_grids(const Decomposition& d, const Boundary& boundary, double k_x, double k_y, int whole_at_most) {
  const Grid& grid = d.grid();
  const auto line = [&](int direction) {
    const auto i = static_cast<std::size_t>(direction);
    const bool periodic = grid.periodic[i];
    const auto fixed = [&](int side) { return !periodic && boundary.side(direction, side).kind == BoundaryKind::dirichlet; };
    return GridLine(grid, direction, fixed(0), fixed(1));
  };
  std::vector<CoarseGrid> grids;
  grids.push_back(
      {{line(0), line(1)}, false, {static_cast<int>(d.offset_x()), static_cast<int>(d.offset_y())}, {d.n_x(), d.n_y()}, {}, {}});
  find_unknowns(grids[0]);
  std::vector<std::array<int, 4>> parts;
  for (int r = 0; r < d.comm().size(); ++r) {
    const auto box = d.box_of(r);
    parts.push_back({static_cast<int>(box[0]), static_cast<int>(box[1]), static_cast<int>(box[2]), static_cast<int>(box[3])});
  }
  const bool alone = d.comm().size() == 1;
  for (;;) {
    CoarseGrid& fine = grids.back();
    const std::array<double, 2> k{fine.lines[0].can_coarsen() ? k_x * fine.lines[0].coupling() : 0.0,
                                  fine.lines[1].can_coarsen() ? k_y * fine.lines[1].coupling() : 0.0};
    const double strongest = std::max(k[0], k[1]);
    if (!(strongest > 0.0)) break;
    std::array<GridLine, 2> coarse{k[0] > 0.3 * strongest ? fine.lines[0].coarsen() : fine.lines[0].keep(),
                                   k[1] > 0.3 * strongest ? fine.lines[1].coarsen() : fine.lines[1].keep()};
    int fewest = 1;
    for (auto& p : parts) {
      const auto [bx, nx] = part_of(fine.lines[0], p[0], p[2]);
      const auto [by, ny] = part_of(fine.lines[1], p[1], p[3]);
      p = {bx, by, nx, ny};
      fewest = std::min({fewest, nx, ny});
    }
    CoarseGrid next{std::move(coarse), fine.whole, {}, {}, {}, {}};
    const bool becomes_whole =
        !alone && !fine.whole && (fewest < 1 || static_cast<long>(next.lines[0].n()) * next.lines[1].n() <= whole_at_most);
    if (becomes_whole) next.contributions = parts;
    next.whole = fine.whole || becomes_whole;
    if (next.whole) {
      next.n = {next.lines[0].n(), next.lines[1].n()};
    } else {
      const auto& mine = parts[static_cast<std::size_t>(d.comm().rank())];
      next.begin = {mine[0], mine[1]};
      next.n = {mine[2], mine[3]};
    }
    find_unknowns(next);
    grids.push_back(std::move(next));
  }
  return grids;
}

PlaneExchange::PlaneExchange(const Decomposition& d, const CoarseGrid& grid, int most_components) : comm_(&d.comm()), n_(grid.n) {
  for (std::size_t direction = 0; direction < 2; ++direction) {
    const bool periodic = grid.lines[direction].periodic;
    for (int side = 0; side < 2; ++side) {
      const int step = side == 0 ? -1 : 1;
      const bool shared = !grid.whole && d.processes()[direction] > 1;
      int rank = periodic ? comm_->rank() : -1;
      if (shared) {
        const int other = direction == 0 ? d.neighbour(step, 0) : d.neighbour(0, step);
        rank = other == MPI_PROC_NULL ? -1 : other;
      }
      neighbours_[direction][static_cast<std::size_t>(side)] = rank;
    }
  }
  const auto longest = static_cast<std::size_t>(std::max(n_[0] + 2, n_[1])) * static_cast<std::size_t>(most_components);
  for (auto* buffers : {&out_, &in_}) {
    for (auto& b : *buffers) b.resize(longest);
  }
}

void PlaneExchange::exchange(const PlaneView& u, int n_components) {
  exchange_direction(0, u, n_components);
  exchange_direction(1, u, n_components);
}

/// Columns first, then rows with the halo's columns: that brings the corners.
void PlaneExchange::exchange_direction(std::size_t d, const PlaneView& u, int n_components) {
  const auto strip = [&](int at, auto f) {
    for (int c = 0; c < n_components; ++c) {
      if (d == 0) {
        for (int j = 0; j < n_[1]; ++j) f(u.row(c, j)[at]);
      } else {
        for (int i = -1; i <= n_[0]; ++i) f(u.row(c, at)[i]);
      }
    }
  };
  const int width = n_components * (d == 0 ? n_[1] : n_[0] + 2);
  std::array<MPI_Request, 4> requests;
  int n_requests = 0;
  for (std::size_t side = 0; side < 2; ++side) {
    const int rank = neighbours_[d][side];
    if (rank < 0) continue;
    double* to = out_[side].data();
    strip(side == 0 ? 0 : n_[d] - 1, [&to](double x) { *to++ = x; });
    if (rank == comm_->rank()) {
      std::copy_n(out_[side].begin(), width, in_[1 - side].begin());
      continue;
    }
    // Two ranks may be neighbours on both sides: a message is tagged by the direction it travels in.
    const int tag = static_cast<int>(2 * d + side);
    check_mpi(MPI_Isend(out_[side].data(), width, MPI_DOUBLE, rank, tag, comm_->get(), &requests[static_cast<std::size_t>(n_requests++)]),
              "MPI_Isend");
    const int other_tag = static_cast<int>(2 * d + (1 - side));
    check_mpi(
        MPI_Irecv(in_[side].data(), width, MPI_DOUBLE, rank, other_tag, comm_->get(), &requests[static_cast<std::size_t>(n_requests++)]),
        "MPI_Irecv");
  }
  if (n_requests > 0) check_mpi(MPI_Waitall(n_requests, requests.data(), MPI_STATUSES_IGNORE), "MPI_Waitall");
  for (std::size_t side = 0; side < 2; ++side) {
    if (neighbours_[d][side] < 0) continue;
    const double* from = in_[side].data();
    strip(side == 0 ? -1 : n_[d], [&from](double& x) { x = *from++; });
  }
}

PlaneGather::PlaneGather(const Communicator& comm, const CoarseGrid& grid, int most_components) : comm_(&comm), parts_(grid.contributions) {
  const auto points = [](const std::array<int, 4>& p) { return static_cast<std::size_t>(p[2]) * static_cast<std::size_t>(p[3]); };
  std::size_t total = 0;
  for (const auto& p : parts_) total += points(p);
  if (parts_.empty()) return;
  mine_.resize(points(parts_[static_cast<std::size_t>(comm.rank())]) * static_cast<std::size_t>(most_components));
  all_.resize(total * static_cast<std::size_t>(most_components));
  counts_.resize(parts_.size());
  displacements_.resize(parts_.size());
}

void PlaneGather::gather(const PlaneView& u, int n_components) {
  const auto each = [&](const std::array<int, 4>& p, auto f) {
    for (int c = 0; c < n_components; ++c) {
      for (int j = p[1]; j < p[1] + p[3]; ++j) f(u.row(c, j) + p[0], p[2]);
    }
  };
  double* to = mine_.data();
  each(parts_[static_cast<std::size_t>(comm_->rank())], [&to](const double* row, int n) { to = std::copy_n(row, n, to); });
  int total = 0;
  for (std::size_t r = 0; r < parts_.size(); ++r) {
    counts_[r] = n_components * parts_[r][2] * parts_[r][3];
    displacements_[r] = total;
    total += counts_[r];
  }
  check_mpi(MPI_Allgatherv(mine_.data(), counts_[static_cast<std::size_t>(comm_->rank())], MPI_DOUBLE, all_.data(), counts_.data(),
                           displacements_.data(), MPI_DOUBLE, comm_->get()),
            "MPI_Allgatherv");
  const double* from = all_.data();
  for (const auto& p : parts_) each(p, [&from](double* row, int n) { std::copy_n(from, n, row), from += n; });
}

}  // namespace stiffront
