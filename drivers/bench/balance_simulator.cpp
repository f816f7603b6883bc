// SPDX-License-Identifier: BSD-3-Clause
// usage: balance_simulator RANKS[,RANKS ...] CASE.toml [KEY=VALUE ...]
//
// How well the reaction of a run would be balanced on many ranks. The case is run on one, with a method that splits; after each step the
// counted work of all cells in its last reaction is cut as that many ranks would hold it. What they would send is planned, by the program's
// own functions, from one step's work and judged by the next one's. A line per step and number of ranks as CSV on standard output.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <span>
#include <string>
#include <vector>

#include "stiffront/app/case_source.hpp"
#include "stiffront/app/method_stack.hpp"
#include "stiffront/app/problem.hpp"
#include "stiffront/control/evolve.hpp"
#include "stiffront/core/error.hpp"
#include "stiffront/splitting/balance_plan.hpp"
#include "stiffront/splitting/reaction_balance.hpp"

namespace {

using namespace stiffront;

/// The boxes of an imagined number of ranks, and the packs in them.
class VirtualRanks {
 public:
  VirtualRanks(const Grid& grid, int ranks) : n_x_(grid.points[0]), processes_{ranks, 1} {
    if (grid.dimension == 2) {
      // The divisor next below the square root.
      int p = static_cast<int>(std::sqrt(static_cast<double>(ranks)) + 0.5);
      while (ranks % p != 0) --p;
      processes_ = {p, ranks / p};
    }
    for (int r = 0; r < ranks; ++r) {
      const auto part = [&](std::size_t d, int index) { return index * grid.points[d] / processes_[d]; };
      const int x = r % processes_[0];
      const int y = r / processes_[0];
      boxes_.push_back({part(0, x), part(0, x + 1), part(1, y), part(1, y + 1)});
    }
  }

  int size() const { return static_cast<int>(boxes_.size()); }
  std::array<int, 2> processes() const { return processes_; }

  /// Work of the packs of a rank.
  std::vector<float> packs(int rank, std::span<const float> cells) const {
    const Box& b = boxes_[static_cast<std::size_t>(rank)];
    std::vector<float> work;
    for (std::int64_t j = b.j_begin; j < b.j_end; ++j) {
      for (std::int64_t i = b.i_begin; i < b.i_end; i += ReactionBalance::cells_per_pack) {
        const auto n = static_cast<std::size_t>(std::min<std::int64_t>(ReactionBalance::cells_per_pack, b.i_end - i));
        const auto pack = cells.subspan(static_cast<std::size_t>(j * n_x_ + i), n);
        work.push_back(std::accumulate(pack.begin(), pack.end(), 0.0F));
      }
    }
    return work;
  }

 private:
  struct Box {
    std::int64_t i_begin, i_end, j_begin, j_end;
  };
  std::int64_t n_x_;
  std::array<int, 2> processes_;
  std::vector<Box> boxes_;
};

std::int64_t sum(std::span<const float> work) { return static_cast<std::int64_t>(std::accumulate(work.begin(), work.end(), 0.0)); }

double imbalance(const std::vector<std::int64_t>& work) {
  const double mean = static_cast<double>(std::accumulate(work.begin(), work.end(), std::int64_t{0})) / static_cast<double>(work.size());
  return static_cast<double>(*std::max_element(work.begin(), work.end())) / mean;
}

/// Plans from `before` and judges by `now`.
void replay(std::int64_t step, const VirtualRanks& ranks, int largest_group, std::span<const float> before, std::span<const float> now) {
  const auto n = static_cast<std::size_t>(ranks.size());
  std::vector<std::int64_t> planned(n), owned(n);
  for (std::size_t r = 0; r < n; ++r) {
    planned[r] = sum(ranks.packs(static_cast<int>(r), before));
    owned[r] = sum(ranks.packs(static_cast<int>(r), now));
  }
  const std::array<int, 2> groups = balance_groups(ranks.processes(), largest_group);
  std::vector<std::int64_t> done = owned;
  std::size_t packs_moved = 0;
  std::size_t transfers = 0;
  std::size_t most_of_one = 0;
  for (int g = 0; g < groups[0] * groups[1]; ++g) {
    std::vector<std::size_t> members;
    std::vector<std::int64_t> work;
    for (std::size_t r = 0; r < n; ++r) {
      const int x = static_cast<int>(r) % ranks.processes()[0];
      const int y = static_cast<int>(r) / ranks.processes()[0];
      if (x % groups[0] + groups[0] * (y % groups[1]) != g) continue;
      members.push_back(r);
      work.push_back(planned[r]);
    }
    const std::vector<WorkTransfer> plan = plan_transfers(work);
    for (std::size_t first = 0; first < plan.size();) {
      std::vector<std::int64_t> amounts;
      std::size_t last = first;
      for (; last < plan.size() && plan[last].from == plan[first].from; ++last) amounts.push_back(plan[last].work);
      const std::size_t sender = members[static_cast<std::size_t>(plan[first].from)];
      const std::vector<float> packs_now = ranks.packs(static_cast<int>(sender), now);
      const auto chosen = choose_packs(ranks.packs(static_cast<int>(sender), before), amounts);
      for (std::size_t k = 0; k < chosen.size(); ++k) {
        std::int64_t moved = 0;
        for (std::int32_t pack : chosen[k]) moved += static_cast<std::int64_t>(packs_now[static_cast<std::size_t>(pack)]);
        done[sender] -= moved;
        done[members[static_cast<std::size_t>(plan[first + k].to)]] += moved;
        packs_moved += chosen[k].size();
      }
      transfers += chosen.size();
      most_of_one = std::max(most_of_one, chosen.size());
      first = last;
    }
  }
  fmt::print("{},{},{},{:.4f},{:.4f},{:.4f},{},{},{}\n", step, n, groups[0] * groups[1], imbalance(owned), imbalance(done),
             8.0 * static_cast<double>(packs_moved) / static_cast<double>(now.size()), packs_moved, transfers, most_of_one);
}

class Replay final : public Observer {
 public:
  Replay(const ReactionFlow& reaction, const Grid& grid, const std::vector<int>& ranks, int largest_group)
      : reaction_(&reaction), largest_group_(largest_group) {
    for (int n : ranks) ranks_.emplace_back(grid, n);
  }
  bool carry_on(std::uint64_t, std::int64_t step, double, double, Field&) override {
    if (!before_.empty()) {
      for (const VirtualRanks& r : ranks_) replay(step, r, largest_group_, before_, reaction_->costs());
    }
    before_ = reaction_->costs();
    return true;
  }

 private:
  const ReactionFlow* reaction_;
  int largest_group_;
  std::vector<VirtualRanks> ranks_;
  std::vector<float> before_;
};

void run(int argc, char** argv) {
  std::vector<int> ranks;
  for (const char* p = argv[1]; *p != '\0';) {
    char* end = nullptr;
    ranks.push_back(static_cast<int>(std::strtol(p, &end, 10)));
    p = *end == ',' ? end + 1 : end;
  }
  const Communicator comm(MPI_COMM_WORLD);
  ModelRegistry models;
  register_builtin_models(models);
  const app::Case c = app::parse_case(app::read_case_source(argv[2], {argv + 3, argv + argc}), models.descriptions());
  app::Problem problem(c, models, comm);
  app::MethodStack stack(c, problem);
  if (stack.reaction_flow() == nullptr) throw Error(ErrorKind::usage, "the method does not split: try method.name=strang method.step=1e-3");
  const char* group = std::getenv("STIFFRONT_LARGEST_GROUP");
  Replay replay(*stack.reaction_flow(), problem.grid, ranks, group != nullptr ? std::atoi(group) : 1024);
  fmt::print("step,ranks,groups,before,after,cells_moved,packs,transfers,most_transfers_of_one\n");
  Schedule schedule;
  schedule.start = c.time.start;
  schedule.end = c.time.end;
  schedule.max_steps = c.limits.max_steps;
  Progress progress;
  progress.t = c.time.start;
  evolve(stack.method(), schedule, problem.state, progress, replay);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    fmt::print(stderr, "usage: balance_simulator RANKS[,RANKS ...] CASE.toml [KEY=VALUE ...]\n");
    return 2;
  }
  MPI_Init(&argc, &argv);
  int status = 0;
  try {
    run(argc, argv);
  } catch (const stiffront::Error& e) {
    fmt::print(stderr, "{}\n", e.what());
    status = e.exit_status();
  }
  MPI_Finalize();
  return status;
}
