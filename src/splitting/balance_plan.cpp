// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/splitting/balance_plan.hpp"

#include <algorithm>
#include <cstddef>
#include <numeric>

namespace stiffront {

std::vector<WorkTransfer> plan_transfers(std::span<const std::int64_t> work, const BalanceRule& rule) {
  std::vector<WorkTransfer> plan;
  const auto ranks = static_cast<std::int64_t>(work.size());
  if (ranks < 2) return plan;
  const std::int64_t total = std::accumulate(work.begin(), work.end(), std::int64_t{0});
  const std::int64_t largest = *std::max_element(work.begin(), work.end());
  // Rounded up, so that what is sent never exceeds what can be received.
  const std::int64_t mean = (total + ranks - 1) / ranks;
  if (static_cast<double>(largest) <= rule.threshold * static_cast<double>(mean) || largest - mean < rule.least_gain) return plan;
  const auto least = std::max<std::int64_t>(1, static_cast<std::int64_t>(rule.least_transfer * static_cast<double>(mean)));
  std::size_t receiver = 0;
  std::int64_t room = 0;  // what the receiver still lacks
  for (std::size_t sender = 0; sender < work.size(); ++sender) {
    std::int64_t surplus = work[sender] - mean;
    while (surplus > 0) {
      while (room == 0 && receiver < work.size()) {
        room = std::max<std::int64_t>(0, mean - work[receiver]);
        if (room == 0) ++receiver;
      }
      if (room == 0) return plan;
      const std::int64_t part = std::min(surplus, room);
      if (part >= least) plan.push_back({static_cast<int>(sender), static_cast<int>(receiver), part});
      surplus -= part;
      room -= part;
      if (room == 0) ++receiver;
    }
  }
  return plan;
}

std::vector<std::vector<std::int32_t>> choose_packs(std::span<const float> pack_work, std::span<const std::int64_t> amounts) {
  // Sorted by counting: the numbers are whole and small. All beyond the last bucket are taken for equally expensive.
  constexpr std::size_t most_buckets = 1024;
  const float largest = pack_work.empty() ? 0.0F : *std::max_element(pack_work.begin(), pack_work.end());
  const std::size_t buckets = std::min(most_buckets, static_cast<std::size_t>(largest) + 1);
  const auto bucket_of = [&](std::size_t pack) { return std::min(buckets - 1, static_cast<std::size_t>(pack_work[pack])); };
  std::vector<std::int32_t> starts(buckets + 1, 0);
  for (std::size_t p = 0; p < pack_work.size(); ++p) ++starts[buckets - 1 - bucket_of(p)];
  std::exclusive_scan(starts.begin(), starts.end(), starts.begin(), 0);
  std::vector<std::int32_t> order(pack_work.size());
  for (std::size_t p = 0; p < pack_work.size(); ++p) {
    std::int32_t& place = starts[buckets - 1 - bucket_of(p)];
    order[static_cast<std::size_t>(place++)] = static_cast<std::int32_t>(p);
  }

  std::vector<std::vector<std::int32_t>> chosen(amounts.size());
  std::vector<bool> taken(order.size(), false);
  // Half a pack too much is as good as half a pack too little; the cheapest packs meet the amount, not the expensive ones.
  double slack = 0.0;
  for (std::size_t n = order.size(); n-- > 0 && slack == 0.0;)
    slack = 0.5 * static_cast<double>(pack_work[static_cast<std::size_t>(order[n])]);
  std::size_t first = 0;  // everything before it is taken
  for (std::size_t k = 0; k < amounts.size(); ++k) {
    auto rest = static_cast<double>(amounts[k]);
    for (std::size_t n = first; n < order.size() && rest > 0.0; ++n) {
      const auto pack = static_cast<std::size_t>(order[n]);
      const double work = static_cast<double>(pack_work[pack]);
      if (work <= 0.0) break;
      if (taken[n] || work > rest + slack) continue;
      taken[n] = true;
      chosen[k].push_back(order[n]);
      rest -= work;
    }
    while (first < order.size() && taken[first]) ++first;
    std::sort(chosen[k].begin(), chosen[k].end());
  }
  return chosen;
}

std::array<int, 2> balance_groups(std::array<int, 2> processes, int largest) {
  std::array<int, 2> groups{1, 1};
  const auto size = [&](std::size_t d) { return (processes[d] + groups[d] - 1) / groups[d]; };
  while (size(0) * size(1) > largest) ++groups[size(0) >= size(1) ? 0 : 1];
  return groups;
}

}  // namespace stiffront
