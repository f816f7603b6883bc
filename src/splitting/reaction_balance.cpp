// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/splitting/reaction_balance.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <utility>

namespace stiffront {
namespace {

enum Tag { cells_there = 1, cells_back };

/// Lengths of intervals within this factor are taken for the same.
constexpr double same_length = 1.5;
/// So many kinds of calls are told apart.
constexpr std::size_t most_patterns = 12;
/// After so many own cells a rank looks for those of others.
constexpr int cells_between_looks = 512;

/// Before and behind a pack in a message: which cells it holds, their hints, states, and, on the way back, costs.
constexpr int header = 1;
constexpr int lanes = ReactionBalance::cells_per_pack;
constexpr int there_and_back(int n_species) { return header + lanes * (1 + n_species); }
constexpr int cost_length = lanes / 2;  // as floats
constexpr int length_of_pack(int n_species) { return there_and_back(n_species) + cost_length; }

double packed_place(std::int64_t cell, int n) { return std::bit_cast<double>(cell * 16 + n); }

int group_of(const Decomposition& d, int largest) {
  const std::array<int, 2> groups = balance_groups(d.processes(), largest);
  return d.coordinates()[0] % groups[0] + groups[0] * (d.coordinates()[1] % groups[1]);
}

void keep_first(std::optional<CellFailure>& first, std::optional<CellFailure>&& other) {
  if (!other) return;
  if (!first || std::pair(other->j, other->i) < std::pair(first->j, first->i)) first = std::move(other);
}

}  // namespace

ReactionBalance::ReactionBalance(const Decomposition& decomposition, const FreeBox& box, int largest_group, BalanceRule rule)
    : decomposition_(&decomposition), box_(box), rule_(rule), group_(decomposition.comm().split(group_of(decomposition, largest_group))) {
  const int rows = std::max(0, box.j_end - box.j_begin);
  is_away_.assign(static_cast<std::size_t>(rows) * static_cast<std::size_t>(std::max(0, packs_per_row())), false);
}

ReactionBalance::~ReactionBalance() {
  int finalized = 0;
  MPI_Finalized(&finalized);
  if (finalized) return;
  for (Pattern& p : patterns_) MPI_Wait(&p.gather, MPI_STATUS_IGNORE);
}

ReactionBalance::Cells ReactionBalance::cells_of(std::int32_t pack) const {
  const int i = box_.i_begin + pack % packs_per_row() * lanes;
  return {i, box_.j_begin + pack / packs_per_row(), std::min(lanes, box_.i_end - i)};
}

ReactionBalance::Pattern* ReactionBalance::nearest(const Kind& kind) {
  Pattern* best = nullptr;
  for (Pattern& p : patterns_) {
    if (p.kind.same_place(kind) && (best == nullptr || p.kind.ratio(kind) < best->kind.ratio(kind))) best = &p;
  }
  return best;
}

/// Waits for what the ranks of the group told each other after the call that wrote the pattern.
void ReactionBalance::learn(Pattern& pattern) {
  if (pattern.gather == MPI_REQUEST_NULL) return;
  check_mpi(MPI_Wait(&pattern.gather, MPI_STATUS_IGNORE), "MPI_Wait");
  std::int64_t largest[2] = {0, 0};
  std::int64_t total = 0;
  for (std::size_t r = 0; r < pattern.of_ranks.size(); r += 2) {
    total += pattern.of_ranks[r];
    for (std::size_t k = 0; k < 2; ++k) largest[k] = std::max(largest[k], pattern.of_ranks[r + k]);
  }
  counts_.largest_owned += static_cast<double>(largest[0]);
  counts_.largest_done += static_cast<double>(largest[1]);
  counts_.mean += static_cast<double>(total) / group_.size();
}

void ReactionBalance::send(const Pattern& pattern, const Field& from, const std::vector<double>& hint) {
  std::vector<std::int64_t> owned;
  for (std::size_t r = 0; r < pattern.of_ranks.size(); r += 2) owned.push_back(pattern.of_ranks[r]);
  std::vector<std::int64_t> amounts;
  std::vector<int> receivers;
  for (const WorkTransfer& transfer : plan_transfers(owned, rule_)) {
    if (transfer.to == group_.rank()) guests_.push_back({transfer.from, false, {}});
    if (transfer.from != group_.rank()) continue;
    amounts.push_back(transfer.work);
    receivers.push_back(transfer.to);
  }
  if (amounts.empty()) return;

  std::vector<std::vector<std::int32_t>> chosen = choose_packs(pattern.packs, amounts);
  for (std::size_t k = 0; k < chosen.size(); ++k) parcels_.push_back({receivers[k], std::move(chosen[k]), {}, {}});
  const std::int64_t points_x = decomposition_->grid().points[0];
  const auto length = static_cast<std::size_t>(length_of_pack(n_species_));
  for (Parcel& parcel : parcels_) {
    parcel.there.assign(length * parcel.packs.size(), 0.0);
    parcel.back.resize(parcel.there.size());
    double* out = parcel.there.data();
    for (std::int32_t pack : parcel.packs) {
      is_away_[static_cast<std::size_t>(pack)] = true;
      const Cells c = cells_of(pack);
      *out = packed_place((decomposition_->offset_y() + c.j) * points_x + decomposition_->offset_x() + c.i, c.n);
      std::copy_n(hint.data() + static_cast<std::ptrdiff_t>(c.j) * from.n_x() + c.i, c.n, out + header);
      for (int s = 0; s < n_species_; ++s) std::copy_n(from.row(s, c.j) + c.i, c.n, out + header + lanes * (1 + s));
      out += length;
      counts_.cells_sent += c.n;
    }
    const auto size = static_cast<int>(parcel.there.size());
    requests_.emplace_back();
    check_mpi(MPI_Irecv(parcel.back.data(), size, MPI_DOUBLE, parcel.rank, cells_back, group_.get(), &requests_.back()), "MPI_Irecv");
    requests_.emplace_back();
    check_mpi(MPI_Isend(parcel.there.data(), size, MPI_DOUBLE, parcel.rank, cells_there, group_.get(), &requests_.back()), "MPI_Isend");
    ++counts_.messages_sent;
    counts_.bytes_sent += static_cast<std::int64_t>(parcel.there.size() * sizeof(double));
  }
}

/// @return whether the guest's cells are here now
bool ReactionBalance::receive(Guest& guest, bool wait) {
  MPI_Message message;
  MPI_Status status;
  int there = 1;
  if (wait) {
    check_mpi(MPI_Mprobe(guest.rank, cells_there, group_.get(), &message, &status), "MPI_Mprobe");
  } else {
    check_mpi(MPI_Improbe(guest.rank, cells_there, group_.get(), &there, &message, &status), "MPI_Improbe");
  }
  if (there == 0) return false;
  int size = 0;
  MPI_Get_count(&status, MPI_DOUBLE, &size);
  guest.cells.resize(static_cast<std::size_t>(size));
  check_mpi(MPI_Mrecv(guest.cells.data(), size, MPI_DOUBLE, &message, MPI_STATUS_IGNORE), "MPI_Mrecv");
  guest.is_here = true;
  return true;
}

/// Advances the cells of a guest and sends them home.
void ReactionBalance::serve(Guest& guest, ReactionSolver& solver, Work& work, std::optional<CellFailure>& failure) {
  const std::int64_t points_x = decomposition_->grid().points[0];
  const int length = length_of_pack(n_species_);
  const std::ptrdiff_t packs = static_cast<std::ptrdiff_t>(guest.cells.size()) / length;
  std::vector<float> costs(static_cast<std::size_t>(packs * lanes), 0.0F);
  for (std::ptrdiff_t p = 0; p < packs; ++p) {
    double* at = guest.cells.data() + p * length;
    const auto place = std::bit_cast<std::int64_t>(*at);
    double* state = at + header + lanes;
    const std::int64_t cell = place / 16;
    solver.run({static_cast<int>(place % 16), state, lanes, state, lanes, at + header, costs.data() + p * lanes, cell % points_x,
                cell / points_x});
  }
  keep_first(failure, solver.finish(work));
  for (std::ptrdiff_t p = 0; p < packs; ++p) {
    std::memcpy(guest.cells.data() + p * length + there_and_back(n_species_), costs.data() + p * lanes, lanes * sizeof(float));
  }
  for (float c : costs) guest_work_ += static_cast<double>(c);
  requests_.emplace_back();
  check_mpi(MPI_Isend(guest.cells.data(), static_cast<int>(guest.cells.size()), MPI_DOUBLE, guest.rank, cells_back, group_.get(),
                      &requests_.back()),
            "MPI_Isend");
  ++counts_.messages_sent;
  counts_.bytes_sent += static_cast<std::int64_t>(guest.cells.size() * sizeof(double));
}

void ReactionBalance::take_back(Field& to, std::vector<double>& hint, std::vector<float>& cost) {
  check_mpi(MPI_Waitall(static_cast<int>(requests_.size()), requests_.data(), MPI_STATUSES_IGNORE), "MPI_Waitall");
  requests_.clear();
  const int length = length_of_pack(n_species_);
  for (const Parcel& parcel : parcels_) {
    const double* in = parcel.back.data();
    for (std::int32_t pack : parcel.packs) {
      is_away_[static_cast<std::size_t>(pack)] = false;
      const Cells c = cells_of(pack);
      const std::ptrdiff_t first = static_cast<std::ptrdiff_t>(c.j) * to.n_x() + c.i;
      std::copy_n(in + header, c.n, hint.data() + first);
      for (int s = 0; s < n_species_; ++s) std::copy_n(in + header + lanes * (1 + s), c.n, to.row(s, c.j) + c.i);
      float costs[lanes];
      std::memcpy(costs, in + there_and_back(n_species_), sizeof costs);
      std::copy_n(costs, c.n, cost.data() + first);
      for (int k = 0; k < c.n; ++k) sent_work_ += static_cast<double>(costs[k]);
      in += length;
    }
  }
  parcels_.clear();
  guests_.clear();
}

/// Writes down where the work was, over what is known of calls of this kind, and tells the group.
void ReactionBalance::remember(Pattern* pattern, const Kind& kind, const std::vector<float>& cost) {
  if (pattern == nullptr || pattern->kind.ratio(kind) > same_length) {
    if (patterns_.size() < most_patterns) {
      pattern = &patterns_.emplace_back();
    } else {
      pattern = &*std::min_element(patterns_.begin(), patterns_.end(), [](const Pattern& a, const Pattern& b) { return a.used < b.used; });
      learn(*pattern);
    }
  }
  pattern->kind = kind;
  pattern->used = ++calls_;
  pattern->packs.resize(is_away_.size());
  double owned = 0.0;
  std::size_t pack = 0;
  for (int j = box_.j_begin; j < box_.j_end; ++j) {
    const float* of_cells = cost.data() + static_cast<std::ptrdiff_t>(j) * decomposition_->n_x();
    for (int i = box_.i_begin; i < box_.i_end; i += lanes) {
      const int end = std::min(i + lanes, box_.i_end);
      float sum = 0.0F;
      for (int k = i; k < end; ++k) sum += of_cells[k];
      pattern->packs[pack++] = sum;
      owned += static_cast<double>(sum);
    }
  }
  const double done = owned - std::exchange(sent_work_, 0.0) + std::exchange(guest_work_, 0.0);
  counts_.work_owned += owned;
  counts_.work_done += done;
  pattern->mine[0] = static_cast<std::int64_t>(owned);
  pattern->mine[1] = static_cast<std::int64_t>(done);
  pattern->of_ranks.resize(2 * static_cast<std::size_t>(group_.size()));
  check_mpi(MPI_Iallgather(pattern->mine, 2, MPI_INT64_T, pattern->of_ranks.data(), 2, MPI_INT64_T, group_.get(), &pattern->gather),
            "MPI_Iallgather");
}

std::optional<CellFailure> ReactionBalance::advance(ReactionSolver& solver, double t, double dt, const Field& from, Field& to,
                                                    std::vector<double>& hint, std::vector<float>& cost, Work& work) {
  if (!(dt > 0.0)) return solver.advance(t, dt, from, to, box_, hint, cost, work);
  n_species_ = from.n_species();
  const Kind kind{.dt = dt, .in_place = &from == &to, .diffused = work.diffusion_stages > 0};
  Pattern* const pattern = nearest(kind);
  if (pattern != nullptr) {
    learn(*pattern);
    send(*pattern, from, hint);
  }

  std::optional<CellFailure> failure;
  std::size_t to_come = guests_.size();
  int cells_since_look = 0;
  const auto look = [&](bool wait) {
    for (Guest& guest : guests_) {
      if (guest.is_here || !receive(guest, wait)) continue;
      serve(guest, solver, work, failure);
      --to_come;
    }
  };
  solver.begin(decomposition_->grid(), t, dt);
  if (parcels_.empty() && guests_.empty()) {
    for (int j = box_.j_begin; j < box_.j_end; ++j) solver.run(run_of(from, to, box_.i_begin, box_.i_end, j, hint, cost));
    failure = solver.finish(work);
    remember(pattern, kind, cost);
    return failure;
  }
  std::size_t pack = 0;
  for (int j = box_.j_begin; j < box_.j_end; ++j) {
    for (int i = box_.i_begin; i < box_.i_end;) {
      int end = i;
      while (end < box_.i_end && !is_away_[pack] && end - i < cells_between_looks) {
        end = std::min(end + lanes, box_.i_end);
        ++pack;
      }
      if (end == i) {  // it is away
        i += lanes;
        ++pack;
        continue;
      }
      solver.run(run_of(from, to, i, end, j, hint, cost));
      cells_since_look += end - i;
      i = end;
      if (to_come > 0 && cells_since_look >= cells_between_looks) {
        look(false);
        cells_since_look = 0;
      }
    }
  }
  if (to_come > 0) look(false);
  keep_first(failure, solver.finish(work));
  if (to_come > 0) look(true);
  take_back(to, hint, cost);
  remember(pattern, kind, cost);
  return failure;
}

const BalanceCounts& ReactionBalance::counts() {
  for (Pattern& p : patterns_) learn(p);
  return counts_;
}

}  // namespace stiffront
