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

/// Packs that go through shared memory at a time, at most: with more, messages cost little in comparison.
constexpr int packs_per_box = 64;

constexpr std::size_t whole_lines(std::size_t bytes) { return (bytes + alignof(Turn) - 1) / alignof(Turn) * alignof(Turn); }
constexpr std::size_t bytes_of_box(int n_species) {
  return whole_lines(sizeof(double) * packs_per_box * static_cast<std::size_t>(length_of_pack(n_species)));
}

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

void ReactionBalance::share_memory(int n_species) {
  if (n_species_ == n_species) return;
  n_species_ = n_species;
  for (int rank = 0; rank < group_.size(); ++rank) {
    if (group_.node_rank(rank) < 0) return;
  }
  const auto ranks = static_cast<std::size_t>(group_.size());
  memory_ = group_.share(most_patterns * sizeof(Page) + ranks * (sizeof(Box) + bytes_of_box(n_species)));
  if (memory_) rule_.least_gain = std::min(rule_.least_gain, rule_.least_gain_in_memory);
  turns_to_.assign(ranks, 0);
  turns_from_.assign(ranks, 0);
}

ReactionBalance::Page& ReactionBalance::page(int rank, const Pattern& pattern) const {
  return reinterpret_cast<Page*>(memory_.of(group_.node_rank(rank)))[pattern.place];
}

ReactionBalance::Box& ReactionBalance::box(int sender, int receiver) const {
  std::byte* const boxes = memory_.of(group_.node_rank(sender)) + most_patterns * sizeof(Page);
  return *reinterpret_cast<Box*>(boxes + static_cast<std::size_t>(receiver) * (sizeof(Box) + bytes_of_box(n_species_)));
}

ReactionBalance::Cells ReactionBalance::cells_of(std::int32_t pack) const {
  const int i = box_.i_begin + pack % packs_per_row() * lanes;
  return {i, box_.j_begin + pack / packs_per_row(), std::min(lanes, box_.i_end - i)};
}

/// The first call of its kind goes by the last one of another: fronts are where they were.
ReactionBalance::Pattern* ReactionBalance::nearest(const Kind& kind) {
  Pattern* best = nullptr;
  for (Pattern& p : patterns_) {
    if (p.kind.same_place(kind) && (best == nullptr || p.kind.ratio(kind) < best->kind.ratio(kind))) best = &p;
  }
  if (best != nullptr || patterns_.empty()) return best;
  return &*std::max_element(patterns_.begin(), patterns_.end(), [](const Pattern& a, const Pattern& b) { return a.used < b.used; });
}

/// Waits for what the ranks of the group told each other after the call that wrote the pattern.
void ReactionBalance::learn(Pattern& pattern) {
  if (pattern.is_known) return;
  pattern.is_known = true;
  if (memory_) {
    for (int rank = 0; rank < group_.size(); ++rank) {
      const Page& told = page(rank, pattern);
      memory_.wait_for(told.turn, pattern.told, group_.get());
      std::copy_n(told.work[pattern.told % 2], 2, pattern.of_ranks.data() + 2 * static_cast<std::ptrdiff_t>(rank));
    }
  } else {
    check_mpi(MPI_Wait(&pattern.gather, MPI_STATUS_IGNORE), "MPI_Wait");
  }
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
    if (transfer.to == group_.rank()) {
      Guest& guest = guests_.emplace_back(Guest{.rank = transfer.from, .cells = {}});
      if (memory_) {
        guest.box = &box(guest.rank, group_.rank());
        guest.turn = ++turns_from_[static_cast<std::size_t>(guest.rank)];
      }
    }
    if (transfer.from != group_.rank()) continue;
    amounts.push_back(transfer.work);
    receivers.push_back(transfer.to);
  }
  if (amounts.empty()) return;

  std::vector<std::vector<std::int32_t>> chosen = choose_packs(pattern.packs, amounts);
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    Parcel& parcel = parcels_.emplace_back(Parcel{.rank = receivers[k], .packs = std::move(chosen[k]), .there = {}, .back = {}});
    const std::size_t length = static_cast<std::size_t>(length_of_pack(n_species_)) * parcel.packs.size();
    ++counts_.messages_sent;
    counts_.bytes_sent += static_cast<std::int64_t>(length * sizeof(double));
    if (memory_) {
      Box& there = box(group_.rank(), parcel.rank);
      parcel.turn = ++turns_to_[static_cast<std::size_t>(parcel.rank)];
      const bool fits = parcel.packs.size() <= packs_per_box;
      there.packs = fits ? static_cast<std::int64_t>(parcel.packs.size()) : -1;
      if (fits) {
        parcel.box = &there;
        fill(cells_in(there), parcel, from, hint);
      }
      there.there.announce(parcel.turn);
      if (fits) continue;
    }
    parcel.there.assign(length, 0.0);
    parcel.back.resize(length);
    fill(parcel.there.data(), parcel, from, hint);
    requests_.emplace_back();
    check_mpi(MPI_Irecv(parcel.back.data(), static_cast<int>(length), MPI_DOUBLE, parcel.rank, cells_back, group_.get(), &requests_.back()),
              "MPI_Irecv");
    requests_.emplace_back();
    check_mpi(
        MPI_Isend(parcel.there.data(), static_cast<int>(length), MPI_DOUBLE, parcel.rank, cells_there, group_.get(), &requests_.back()),
        "MPI_Isend");
  }
}

void ReactionBalance::fill(double* out, const Parcel& parcel, const Field& from, const std::vector<double>& hint) {
  const std::int64_t points_x = decomposition_->grid().points[0];
  for (std::int32_t pack : parcel.packs) {
    is_away_[static_cast<std::size_t>(pack)] = true;
    const Cells c = cells_of(pack);
    *out = packed_place((decomposition_->offset_y() + c.j) * points_x + decomposition_->offset_x() + c.i, c.n);
    std::copy_n(hint.data() + static_cast<std::ptrdiff_t>(c.j) * from.n_x() + c.i, c.n, out + header);
    for (int s = 0; s < n_species_; ++s) std::copy_n(from.row(s, c.j) + c.i, c.n, out + header + lanes * (1 + s));
    out += length_of_pack(n_species_);
    counts_.cells_sent += c.n;
  }
}

/// @return whether the guest's cells are here now
bool ReactionBalance::receive(Guest& guest, bool wait) {
  if (guest.box != nullptr) {
    if (!wait && !guest.box->there.has_come(guest.turn)) return false;
    memory_.wait_for(guest.box->there, guest.turn, group_.get());
    if (guest.box->packs >= 0) return guest.is_here = true;
    guest.box = nullptr;
  }
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
  const std::ptrdiff_t packs = guest.box != nullptr ? guest.box->packs : static_cast<std::ptrdiff_t>(guest.cells.size()) / length;
  double* const cells = guest.box != nullptr ? cells_in(*guest.box) : guest.cells.data();
  std::vector<float>& costs = guest_costs_;
  costs.assign(static_cast<std::size_t>(packs * lanes), 0.0F);
  for (std::ptrdiff_t p = 0; p < packs; ++p) {
    double* at = cells + p * length;
    const auto place = std::bit_cast<std::int64_t>(*at);
    double* state = at + header + lanes;
    const std::int64_t cell = place / 16;
    solver.run({static_cast<int>(place % 16), state, lanes, state, lanes, at + header, costs.data() + p * lanes, cell % points_x,
                cell / points_x});
  }
  keep_first(failure, solver.finish(work));
  for (std::ptrdiff_t p = 0; p < packs; ++p) {
    std::memcpy(cells + p * length + there_and_back(n_species_), costs.data() + p * lanes, lanes * sizeof(float));
  }
  for (float c : costs) guest_work_ += static_cast<double>(c);
  ++counts_.messages_sent;
  counts_.bytes_sent += static_cast<std::int64_t>(sizeof(double)) * packs * length;
  if (guest.box != nullptr) {
    guest.box->back.announce(guest.turn);
    return;
  }
  requests_.emplace_back();
  check_mpi(MPI_Isend(guest.cells.data(), static_cast<int>(guest.cells.size()), MPI_DOUBLE, guest.rank, cells_back, group_.get(),
                      &requests_.back()),
            "MPI_Isend");
}

void ReactionBalance::take_back(Field& to, std::vector<double>& hint, std::vector<float>& cost) {
  if (!requests_.empty()) {
    check_mpi(MPI_Waitall(static_cast<int>(requests_.size()), requests_.data(), MPI_STATUSES_IGNORE), "MPI_Waitall");
    requests_.clear();
  }
  const int length = length_of_pack(n_species_);
  for (const Parcel& parcel : parcels_) {
    if (parcel.box != nullptr) memory_.wait_for(parcel.box->back, parcel.turn, group_.get());
    const double* in = parcel.box != nullptr ? cells_in(*parcel.box) : parcel.back.data();
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
  if (pattern == nullptr || !pattern->kind.same_place(kind) || pattern->kind.ratio(kind) > same_length) {
    if (patterns_.size() < most_patterns) {
      pattern = &patterns_.emplace_back();
      pattern->place = patterns_.size() - 1;
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
      float sum = 0.0F;
      if (i + lanes <= box_.i_end) {  // nearly all: a fixed number of terms
        for (int k = 0; k < lanes; ++k) sum += of_cells[i + k];
      } else {
        for (int k = i; k < box_.i_end; ++k) sum += of_cells[k];
      }
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
  pattern->is_known = false;
  if (memory_) {
    Page& mine = page(group_.rank(), *pattern);
    std::copy_n(pattern->mine, 2, mine.work[++pattern->told % 2]);
    mine.turn.announce(pattern->told);
    return;
  }
  check_mpi(MPI_Iallgather(pattern->mine, 2, MPI_INT64_T, pattern->of_ranks.data(), 2, MPI_INT64_T, group_.get(), &pattern->gather),
            "MPI_Iallgather");
}

std::optional<CellFailure> ReactionBalance::advance(ReactionSolver& solver, double t, double dt, const Field& from, Field& to,
                                                    std::vector<double>& hint, std::vector<float>& cost, Work& work) {
  if (!(dt > 0.0)) return solver.advance(t, dt, from, to, box_, hint, cost, work);
  share_memory(from.n_species());
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
