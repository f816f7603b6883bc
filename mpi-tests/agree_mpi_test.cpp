// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <new>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "stiffront/core/agree.hpp"
#include "stiffront/core/error.hpp"

namespace stiffront {
namespace {

class AgreeMpiTest : public ::testing::Test {
 protected:
  /// Runs f collectively on c; the error it ends with must be the expected one on every rank.
  static void expect_error(const Communicator& c, const std::function<void()>& f, ErrorKind kind, const std::string& message) {
    try {
      collectively(c, f);
      ADD_FAILURE() << "did not throw \"" << message.substr(0, 40) << '"';
    } catch (const Error& e) {
      EXPECT_EQ(e.kind(), kind);
      EXPECT_EQ(std::string(e.what()) == message, true) << "length " << std::strlen(e.what()) << ", expected " << message.size();
    }
    // Whoever left early would meet the others here in another call.
    EXPECT_EQ(c.sum(std::int64_t{1}), c.size());
  }

  const Communicator world{MPI_COMM_WORLD};
};

TEST_F(AgreeMpiTest, NothingIsThrownWhenNobodyFails) {
  int runs = 0;
  collectively(world, [&] { ++runs; });
  EXPECT_EQ(runs, 1);
}

TEST_F(AgreeMpiTest, OneRanksErrorIsEveryRanksWhicheverItIs) {
  for (int culprit = 0; culprit < world.size(); ++culprit) {
    for (const ErrorKind kind : {ErrorKind::input, ErrorKind::io, ErrorKind::numerics}) {
      const std::string message = "rank " + std::to_string(culprit) + " cannot go on";
      expect_error(
          world,
          [&] {
            if (world.rank() == culprit) throw Error(kind, message);
          },
          kind, message);
    }
  }
}

TEST_F(AgreeMpiTest, OfTwoErrorsTheLowestRanksIsThrown) {
  for (int first = 0; first < world.size(); ++first) {
    for (int second = first; second < world.size(); ++second) {
      expect_error(
          world,
          [&] {
            if (world.rank() == first) throw Error(ErrorKind::io, "first");
            if (world.rank() == second) throw Error(ErrorKind::input, "second");
          },
          ErrorKind::io, "first");
    }
  }
}

TEST_F(AgreeMpiTest, EveryRankMayFailAtOnce) {
  expect_error(
      world, [&] { throw Error(ErrorKind::numerics, "from rank " + std::to_string(world.rank())); }, ErrorKind::numerics, "from rank 0");
}

TEST_F(AgreeMpiTest, LongMessagesArriveWhole) {
  std::string message(200000, 'x');
  for (std::size_t i = 0; i < message.size(); i += 97) message[i] = static_cast<char>('a' + i % 23);
  for (int culprit = 0; culprit < world.size(); ++culprit) {
    expect_error(
        world,
        [&] {
          if (world.rank() == culprit) throw Error(ErrorKind::input, message);
        },
        ErrorKind::input, message);
  }
  expect_error(
      world,
      [&] {
        if (world.rank() == world.size() - 1) throw Error(ErrorKind::input, "");
      },
      ErrorKind::input, "");
}

TEST_F(AgreeMpiTest, OtherExceptionsAreBugs) {
  const int last = world.size() - 1;
  expect_error(
      world,
      [&] {
        if (world.rank() == last) throw std::runtime_error("who wrote this?");
      },
      ErrorKind::bug, "who wrote this?");
  expect_error(
      world,
      [&] {
        if (world.rank() == last) throw std::bad_alloc();
      },
      ErrorKind::bug, "out of memory");
  expect_error(
      world,
      [&] {
        if (world.rank() == last) throw 42;
      },
      ErrorKind::bug, "an exception of unknown type");
}

/// Terms of mixed signs over 200 binary orders of magnitude, the same on every rank.
std::vector<double> terms(int n) {
  std::mt19937_64 engine(2024);
  std::uniform_real_distribution<double> mantissa(-1.0, 1.0);
  std::uniform_int_distribution<int> exponent(-100, 100);
  std::vector<double> all;
  for (int i = 0; i < n; ++i) all.push_back(std::ldexp(mantissa(engine), exponent(engine)));
  return all;
}

bool same_bits(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }

TEST_F(AgreeMpiTest, SumsHaveTheSerialBitsForAnyPartition) {
  const std::vector<double> all = terms(1000);
  ReproducibleSum serial;
  for (double x : all) serial.add(x);
  std::mt19937_64 engine(5);  // the same partitions on every rank
  for (int partition = 0; partition < 50; ++partition) {
    std::uniform_int_distribution<int> owner(0, world.size() - 1);
    const int whole = partition == 0 ? world.size() - 1 : -1;  // first everything on one rank, then anything anywhere
    Agreement a(1, 0);
    for (double x : all) {
      const int at = whole >= 0 ? whole : owner(engine);
      if (at == world.rank()) a.sums[0].add(x);
    }
    world.agree(a);
    ASSERT_TRUE(same_bits(a.sums[0].value(), serial.value())) << a.sums[0].value() << " and " << serial.value();
  }
}

TEST_F(AgreeMpiTest, ManySumsAndMaximaAndFlagsTravelTogether) {
  for (const int n_sums : {0, 1, 2, 7}) {
    for (const int n_maxima : {0, 1, 8, 9, 30}) {
      Agreement a(n_sums, n_maxima);
      const int me = world.rank();
      for (int s = 0; s < n_sums; ++s) a.sums[static_cast<std::size_t>(s)].add(1.0 + 10.0 * s + me);
      for (int m = 0; m < n_maxima; ++m) a.maxima[static_cast<std::size_t>(m)] = 1.0 + (m + me) % world.size();
      a.flags = std::uint64_t{1} << (60 - me);
      world.agree(a);
      const int p = world.size();
      for (int s = 0; s < n_sums; ++s) EXPECT_EQ(a.sums[static_cast<std::size_t>(s)].value(), p * (1.0 + 10.0 * s) + p * (p - 1) / 2);
      for (double m : a.maxima) EXPECT_EQ(m, p);
      std::uint64_t flags = 0;
      for (int r = 0; r < p; ++r) flags |= std::uint64_t{1} << (60 - r);
      EXPECT_EQ(a.flags, flags);
    }
  }
}

TEST_F(AgreeMpiTest, WhatIsNotFiniteReachesEveryRank) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  for (int culprit = 0; culprit < world.size(); ++culprit) {
    Agreement a(2, 2);
    for (auto& s : a.sums) s.add(1.0);
    a.maxima = {3.0, 4.0};
    if (world.rank() == culprit) {
      a.sums[0].add(nan);
      a.sums[1].add(infinity);
      a.maxima[1] = nan;
    }
    world.agree(a);
    EXPECT_TRUE(std::isnan(a.sums[0].value()));
    EXPECT_EQ(a.sums[1].value(), infinity);
    EXPECT_EQ(a.maxima[0], 3.0);
    EXPECT_EQ(a.maxima[1], infinity);
  }
}

TEST_F(AgreeMpiTest, SimpleReductionsAndBroadcasts) {
  const int me = world.rank();
  const int p = world.size();
  EXPECT_EQ(world.max(-1.5 * me), 0.0);
  EXPECT_EQ(world.max(std::int64_t{1} << (40 + me)), std::int64_t{1} << (39 + p));
  EXPECT_EQ(world.sum(std::int64_t{me}), p * (p - 1) / 2);
  for (int root = 0; root < p; ++root) {
    EXPECT_EQ(world.broadcast("from " + std::to_string(me), root), "from " + std::to_string(root));
    EXPECT_EQ(world.broadcast(me == root ? "" : "overwritten", root), "");
  }
  EXPECT_EQ(world.is_root(), me == 0);
}

TEST_F(AgreeMpiTest, ReductionsAreCounted) {
  const Communicator c(MPI_COMM_WORLD);
  Agreement a(3, 20);
  c.agree(a);
  c.max(1.0);
  c.sum(std::int64_t{1});
  EXPECT_EQ(c.reductions(), 3);
}

// Halves of the job agree on different things at the same time.
TEST_F(AgreeMpiTest, CommunicatorsSideBySideAgreeOnTheirOwn) {
  const int colour = world.rank() % 2;
  MPI_Comm half = MPI_COMM_NULL;
  MPI_Comm_split(MPI_COMM_WORLD, colour, world.rank(), &half);
  {
    const Communicator mine(half);
    Agreement a(1, 1);
    a.sums[0].add(colour == 0 ? 1.0 : 100.0);
    a.maxima[0] = colour + 1.0;
    if (colour == 1) {
      expect_error(
          mine, [&] { throw Error(ErrorKind::input, "odd ranks only"); }, ErrorKind::input, "odd ranks only");
    }
    mine.agree(a);
    EXPECT_EQ(a.sums[0].value(), (colour == 0 ? 1.0 : 100.0) * mine.size());
    EXPECT_EQ(a.maxima[0], colour + 1.0);
  }
  MPI_Comm_free(&half);
}

TEST_F(AgreeMpiTest, ACommunicatorMovesWithoutBeingFreedTwice) {
  Communicator a(MPI_COMM_WORLD);
  const MPI_Comm handle = a.get();
  Communicator b(std::move(a));
  EXPECT_EQ(b.get(), handle);
  EXPECT_EQ(b.size(), world.size());
  Communicator c(MPI_COMM_SELF);
  c = std::move(b);
  EXPECT_EQ(c.get(), handle);
  EXPECT_EQ(c.size(), world.size());
  EXPECT_EQ(c.sum(std::int64_t{1}), world.size());
}

TEST_F(AgreeMpiTest, FailedCallsAreErrorsWithTheLibrarysText) {
  try {
    check_mpi(MPI_Bcast(nullptr, -1, MPI_INT, 0, world.get()), "MPI_Bcast");
    ADD_FAILURE() << "a negative count was accepted";
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::mpi);
    EXPECT_EQ(std::string(e.what()).rfind("MPI_Bcast: ", 0), 0U) << e.what();
  }
}

}  // namespace
}  // namespace stiffront
