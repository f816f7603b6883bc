// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstring>

#include "stiffront/core/mpi.hpp"
#include "stiffront/core/node_memory.hpp"

namespace stiffront {
namespace {

constexpr int nobody = 1;

TEST(NodeMemoryMpiTest, EachRankSeesWhatTheOthersWroteInTheirPieces) {
  const Communicator world(MPI_COMM_WORLD);
  // Sizes differ and are no whole lines.
  const NodeMemory memory = world.share(100 + 10 * static_cast<std::size_t>(world.rank()));
  ASSERT_EQ(static_cast<bool>(memory), world.size() > 1);
  if (!memory) return;
  std::byte* const mine = memory.of(world.node_rank(world.rank()));
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(mine) % alignof(Turn), 0U);
  auto* const turn = reinterpret_cast<Turn*>(mine);
  for (std::uint64_t round = 1; round < 200; ++round) {
    const double sent = 1000.0 * static_cast<double>(round) + world.rank();
    std::memcpy(mine + sizeof(Turn) + (round % 2) * sizeof(double), &sent, sizeof sent);
    turn->announce(round);
    for (int rank = 0; rank < world.size(); ++rank) {
      const std::byte* const theirs = memory.of(world.node_rank(rank));
      memory.wait_for(*reinterpret_cast<const Turn*>(theirs), round, world.get());
      double seen = 0.0;
      std::memcpy(&seen, theirs + sizeof(Turn) + (round % 2) * sizeof(double), sizeof seen);
      ASSERT_EQ(seen, 1000.0 * static_cast<double>(round) + rank);
    }
  }
}

TEST(NodeMemoryMpiTest, WithMoreRanksThanMayShareNobodyGetsAny) {
  const Communicator apart(MPI_COMM_WORLD, nobody);
  EXPECT_FALSE(static_cast<bool>(apart.share(64)));
  EXPECT_EQ(apart.node_rank(apart.rank()), -1);
}

Agreement example(int rank, int n_sums, int n_maxima) {
  Agreement a(n_sums, n_maxima);
  for (int k = 0; k < n_sums; ++k) {
    for (int n = 0; n < 5; ++n)
      a.sums[static_cast<std::size_t>(k)].add(std::ldexp(1.0 + 0.1 * rank + 0.01 * n, 60 * ((rank + k) % 3) - 70));
  }
  for (int k = 0; k < n_maxima; ++k) a.maxima[static_cast<std::size_t>(k)] = (7 * rank + 3 * k) % 11;
  a.flags = std::uint64_t{1} << rank;
  return a;
}

TEST(NodeMemoryMpiTest, AnAgreementThroughMemoryIsThatOfAReduction) {
  const Communicator world(MPI_COMM_WORLD);
  const Communicator apart(MPI_COMM_WORLD, nobody);
  for (int n_sums : {0, 1, 3}) {
    for (int n_maxima : {0, 5, 20}) {
      Agreement direct = example(world.rank(), n_sums, n_maxima);
      Agreement reduced = direct;
      Agreement many = example(world.rank(), n_sums + 20, n_maxima);  // more than memory is for
      world.agree(direct);
      apart.agree(reduced);
      world.agree(many);
      EXPECT_EQ(direct.maxima, reduced.maxima);
      EXPECT_EQ(direct.flags, reduced.flags);
      EXPECT_EQ(direct.maxima, many.maxima);
      for (std::size_t k = 0; k < direct.sums.size(); ++k) {
        EXPECT_EQ(direct.sums[k].value(), reduced.sums[k].value());
        EXPECT_EQ(direct.sums[k].value(), many.sums[k].value());
      }
    }
  }
}

/// The sums of an agreement on ranks that have none, few or all terms.
TEST(NodeMemoryMpiTest, SumsThatTravelMergeLikeSumsThatDoNot) {
  for (int first = 0; first < 3; ++first) {
    for (int second = 0; second < 3; ++second) {
      ReproducibleSum a;
      ReproducibleSum b;
      for (int n = 0; n < first; ++n) a.add(std::ldexp(1.1, 90 * n - 60));
      for (int n = 0; n < second; ++n) b.add(std::ldexp(-1.3, 50 * n - 20));
      ReproducibleSum::Wire wire = a.wire();
      ReproducibleSum::merge(wire, b.wire());
      a.merge(b);
      EXPECT_EQ(ReproducibleSum::from_wire(wire).value(), a.value()) << first << " and " << second;
      const ReproducibleSum::Wire expected = a.wire();
      EXPECT_EQ(std::memcmp(&wire, &expected, sizeof wire), 0) << first << " and " << second;
    }
  }
}

}  // namespace
}  // namespace stiffront
