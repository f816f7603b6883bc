// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace stiffront {

/// So much counted work goes from one rank to another.
struct WorkTransfer {
  int from;
  int to;
  std::int64_t work;

  bool operator==(const WorkTransfer&) const = default;
};

/// When it is worth while to move anything. Work is counted in Newton iterations of one cell, some 30 ns.
struct BalanceRule {
  double threshold = 1.02;                  ///< largest over mean work up to which everything stays where it is
  std::int64_t least_gain = 400;            ///< so much less must the busiest rank have to do: what the messages take
  std::int64_t least_gain_in_memory = 120;  ///< the same where ranks share memory
  double least_transfer = 0.005;            ///< of the mean work; smaller transfers are left out
};

/// Who sends how much to whom so that all have the mean.
///
/// What exceeds the mean, in the order of the ranks, is laid end to end on a line; so is what others lack. Where a piece of one meets a
/// piece of the other is a transfer: at most one less than ranks take part, and every rank finds the same plan from the same numbers.
/// A rank either sends or receives.
std::vector<WorkTransfer> plan_transfers(std::span<const std::int64_t> work, const BalanceRule& rule = {});

/// Chooses packs whose work adds up to each of the amounts, nearly, the most expensive first: they take the fewest bytes.
/// @return for each amount the packs that go, in ascending order
std::vector<std::vector<std::int32_t>> choose_packs(std::span<const float> pack_work, std::span<const std::int64_t> amounts);

/// Into how many groups per direction a layout of ranks is divided so that no group has more than `largest` ranks. The ranks of a group are
/// those with equal coordinates modulo these numbers: each group samples the whole domain, so that what is to be balanced is the same in all.
std::array<int, 2> balance_groups(std::array<int, 2> processes, int largest);

}  // namespace stiffront
