// SPDX-License-Identifier: BSD-3-Clause
// Every halo cell is compared with the exact value of the point it stands for, in any layout of the ranks.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "stiffront/core/error.hpp"
#include "stiffront/mesh/halo_exchange.hpp"
#include "support/grids.hpp"

namespace stiffront {
namespace {

using testing::Sides;

constexpr double untouched = -1.0;

/// An integer that names field, species and point, a cubic in each index: beyond a Dirichlet side, where the halo is extrapolated by
/// a cubic, it is the same formula that holds, and without rounding errors.
double mark(int field, int species, std::int64_t i, std::int64_t j) {
  return 1e13 * (8 * field + species + 1) + static_cast<double>(i * i * i) + 1e7 * static_cast<double>(j * j * j);
}

/// The point a point of the halo stands for.
std::int64_t image(std::int64_t i, std::int64_t n, const Sides& sides) {
  if (sides == testing::periodic) return (i + n) % n;
  if (i < 0 && sides[0] == BoundaryKind::neumann) return -i;
  if (i > n - 1 && sides[1] == BoundaryKind::neumann) return 2 * (n - 1) - i;
  return i;
}

struct Arrangement {
  Grid grid;
  Sides x, y;
  std::array<int, 2> processes;
  int width;
  int n_species;
  int n_fields;
  std::vector<int> species;
  bool corners;

  std::string text() const {
    std::string s = std::to_string(grid.points[0]) + "x" + std::to_string(grid.points[1]) + " " + testing::name_of(x) + "/" +
                    testing::name_of(y) + " on " + std::to_string(processes[0]) + "x" + std::to_string(processes[1]) + ", width " +
                    std::to_string(width) + ", species " + std::to_string(n_species) + ", fields " + std::to_string(n_fields);
    if (!species.empty()) s += ", a subset";
    return corners ? s + ", corners" : s;
  }
};

void fill(Field& u, int field) {
  const Decomposition& d = u.decomposition();
  for (int s = 0; s < u.n_species(); ++s) {
    for (int j = -u.halo_y(); j < u.n_y() + u.halo_y(); ++j) {
      for (int i = -u.halo(); i < u.n_x() + u.halo(); ++i) {
        const bool interior = i >= 0 && i < u.n_x() && j >= 0 && j < u.n_y();
        u.at(s, i, j) = interior ? mark(field, s, d.offset_x() + i, d.offset_y() + j) : untouched;
      }
    }
  }
}

/// Compares all cells of a field after an exchange; reports the first that is wrong.
void expect_filled(const Arrangement& a, const Field& u, int field) {
  const Decomposition& d = u.decomposition();
  const auto outside = [](int i, int n) { return i < 0 || i >= n; };
  for (int s = 0; s < u.n_species(); ++s) {
    const bool exchanged = a.species.empty() || std::find(a.species.begin(), a.species.end(), s) != a.species.end();
    for (int j = -u.halo_y(); j < u.n_y() + u.halo_y(); ++j) {
      for (int i = -u.halo(); i < u.n_x() + u.halo(); ++i) {
        const std::int64_t gi = d.offset_x() + i;
        const std::int64_t gj = d.offset_y() + j;
        const int out_x = i < 0 ? -i : i - (u.n_x() - 1);
        const int out_y = j < 0 ? -j : j - (u.n_y() - 1);
        const bool corner = outside(i, u.n_x()) && outside(j, u.n_y());
        const bool in_halo = outside(i, u.n_x()) || outside(j, u.n_y());
        const bool beyond_dirichlet =
            (gi < 0 && a.x[0] == BoundaryKind::dirichlet) || (gi >= a.grid.points[0] && a.x[1] == BoundaryKind::dirichlet) ||
            (gj < 0 && a.y[0] == BoundaryKind::dirichlet) || (gj >= a.grid.points[1] && a.y[1] == BoundaryKind::dirichlet);
        double expected = mark(field, s, image(gi, a.grid.points[0], a.x), image(gj, a.grid.points[1], a.y));
        if (in_halo) {
          if (!exchanged || out_x > a.width || out_y > a.width) {
            expected = untouched;
          } else if ((corner && !a.corners) || (beyond_dirichlet && a.width == 1)) {
            continue;  // nobody reads them, nobody promises anything
          }
        }
        if (u.at(s, i, j) != expected) {
          ADD_FAILURE() << a.text() << ": field " << field << ", species " << s << ", local point " << i << ", " << j << " is "
                        << u.at(s, i, j) << ", not " << expected;
          return;
        }
      }
    }
  }
}

void check(const Communicator& comm, const Arrangement& a) {
  const Decomposition d(comm, a.grid, a.processes, a.width);
  const Boundary boundary = testing::boundary_of(a.x, a.y, a.n_species, testing::zero);
  HaloExchange halo(d, boundary, a.n_species, a.n_fields, a.width, a.species, a.corners);
  std::vector<Field> fields;
  std::vector<Field*> pointers;
  for (int f = 0; f < a.n_fields; ++f) fields.emplace_back(d, a.n_species, a.width + 1);
  for (Field& f : fields) pointers.push_back(&f);
  // Again with other numbers: buffers are used again.
  for (const int first : {0, 3, 5}) {
    for (int f = 0; f < a.n_fields; ++f) fill(fields[static_cast<std::size_t>(f)], first + f);
    halo.exchange(pointers);
    for (int f = 0; f < a.n_fields; ++f) expect_filled(a, fields[static_cast<std::size_t>(f)], first + f);
  }
  EXPECT_EQ(halo.count(), 3);
}

std::vector<std::array<int, 2>> layouts(int ranks) {
  std::vector<std::array<int, 2>> all;
  for (int p = 1; p <= ranks; ++p) {
    if (ranks % p == 0) all.push_back({p, ranks / p});
  }
  return all;
}

/// Between ranks that share memory, and by messages: the parameter is how many may share.
class HaloMpiTest : public ::testing::TestWithParam<int> {
 protected:
  const Communicator world{MPI_COMM_WORLD, GetParam()};
};

INSTANTIATE_TEST_SUITE_P(ThroughMemory, HaloMpiTest, ::testing::Values(1000));
INSTANTIATE_TEST_SUITE_P(ByMessages, HaloMpiTest, ::testing::Values(0));

TEST_P(HaloMpiTest, EveryCellIsExactInOneDimension) {
  for (const Sides& x : testing::all_sides) {
    for (const int width : {1, 2, 4}) {
      for (const int n_species : {1, 2, 3, 5}) {
        for (const int n_fields : {1, 2, 3}) {
          check(world, {testing::unit_grid(67, 0, x), x, testing::neumann, {world.size(), 1}, width, n_species, n_fields, {}, false});
        }
      }
    }
  }
}

TEST_P(HaloMpiTest, EveryCellAndCornerIsExactInTwoDimensions) {
  for (const auto& layout : layouts(world.size())) {
    for (const Sides& x : testing::all_sides) {
      for (const Sides& y : testing::all_sides) {
        for (const int width : {1, 2, 4}) {
          for (const bool corners : {false, true}) {
            check(world, {testing::unit_grid(67, 61, x, y), x, y, layout, width, 1, 1, {}, corners});
          }
        }
      }
    }
  }
}

TEST_P(HaloMpiTest, SeveralFieldsOfSeveralSpeciesShareTheMessages) {
  for (const auto& layout : layouts(world.size())) {
    for (const Sides& x : testing::all_sides) {
      for (int n_species = 1; n_species <= 5; ++n_species) {
        for (const int n_fields : {1, 3}) {
          check(world, {testing::unit_grid(21, 19, x, testing::periodic), x, testing::periodic, layout, 2, n_species, n_fields, {}, true});
        }
      }
    }
  }
}

TEST_P(HaloMpiTest, OnlyTheChosenSpeciesAreTouched) {
  for (const auto& layout : layouts(world.size())) {
    for (const Sides& x : testing::all_sides) {
      for (const Sides& y : testing::all_sides) {
        check(world, {testing::unit_grid(21, 19, x, y), x, y, layout, 2, 4, 2, {1, 3}, true});
        check(world, {testing::unit_grid(21, 19, x, y), x, y, layout, 1, 3, 1, {2}, false});
      }
    }
  }
}

// The smallest boxes there may be: as many points as the halo is wide, or what mirroring and extrapolation need in a whole direction.
TEST_P(HaloMpiTest, BoxesMayBeAsNarrowAsTheHalo) {
  const auto least = [](const Sides& sides, int processes, int width) {
    if (processes > 1) return processes * width;
    if (sides == testing::periodic) return width;
    if (sides == testing::neumann) return width + 1;
    return width == 1 ? 2 : std::max(4, width + (sides == testing::mixed ? 1 : 0));
  };
  for (const auto& layout : layouts(world.size())) {
    for (const Sides& x : testing::all_sides) {
      for (const Sides& y : testing::all_sides) {
        for (const int width : {1, 2, 4}) {
          for (const int more : {0, 1, 2}) {
            const int n_x = least(x, layout[0], width) + more;
            const int n_y = least(y, layout[1], width) + more;
            check(world, {testing::unit_grid(n_x, n_y, x, y), x, y, layout, width, 2, 1, {}, true});
            if (layout[1] == 1) check(world, {testing::unit_grid(n_x, 0, x), x, testing::neumann, layout, width, 2, 1, {}, false});
          }
        }
      }
    }
  }
}

TEST_P(HaloMpiTest, TooNarrowBoxesAreAnInputErrorOnEveryRank) {
  const auto refused = [&](int n_x, const Sides& x, int width) {
    const Grid grid = testing::unit_grid(n_x, 0, x);
    const Decomposition d(world, grid, {0, 0}, 1);
    const Boundary boundary = testing::boundary_of(x, testing::neumann, 1, testing::zero);
    try {
      HaloExchange halo(d, boundary, 1, 1, width);
    } catch (const Error& e) {
      EXPECT_EQ(e.kind(), ErrorKind::input);
      EXPECT_NE(std::string(e.what()).find("grid.points: " + std::to_string(n_x) + " points along x"), std::string::npos) << e.what();
      return true;
    }
    return false;
  };
  const int p = world.size();
  EXPECT_TRUE(refused(4 * p - 1, testing::periodic, 4));
  EXPECT_FALSE(refused(4 * p, testing::periodic, 4));
  if (p == 1) {
    EXPECT_TRUE(refused(2, testing::neumann, 2));
    EXPECT_FALSE(refused(3, testing::neumann, 2));
    EXPECT_TRUE(refused(3, testing::dirichlet, 2));
    EXPECT_FALSE(refused(4, testing::dirichlet, 2));
  }
}

TEST_P(HaloMpiTest, HalosChangeInFinishAndNotBefore) {
  const Arrangement a{
      testing::unit_grid(23, 17, testing::periodic, testing::mixed), testing::periodic, testing::mixed, {0, 0}, 2, 2, 1, {}, true};
  const Decomposition d(world, a.grid, a.processes, a.width);
  const Boundary boundary = testing::boundary_of(a.x, a.y, 2, testing::zero);
  HaloExchange halo(d, boundary, 2, 1, a.width, {}, true);
  Field u(d, 2, 2);
  Field* pointer = &u;
  fill(u, 0);
  halo.begin({&pointer, 1});
  // Work that needs no halo goes on here, beside the messages.
  double sum_of_halo = 0.0;
  for (int j = -2; j < u.n_y() + 2; ++j) {
    for (int i = -2; i < u.n_x() + 2; ++i) {
      const bool interior = i >= 0 && i < u.n_x() && j >= 0 && j < u.n_y();
      if (!interior) sum_of_halo += u.at(0, i, j);
    }
  }
  EXPECT_EQ(sum_of_halo, untouched * ((u.n_x() + 4) * (u.n_y() + 4) - u.n_x() * u.n_y()));
  halo.finish();
  expect_filled(a, u, 0);
}

TEST_P(HaloMpiTest, MisuseIsAnErrorAndLeavesTheExchangeUsable) {
  const Arrangement a{
      testing::unit_grid(23, 17, testing::neumann, testing::periodic), testing::neumann, testing::periodic, {0, 0}, 2, 2, 1, {}, false};
  const Decomposition d(world, a.grid, a.processes, a.width);
  const Boundary boundary = testing::boundary_of(a.x, a.y, 2, testing::zero);
  HaloExchange halo(d, boundary, 2, 1, a.width);
  Field u(d, 2, 2);
  Field v(d, 2, 1);
  Field* one[1] = {&u};
  Field* two[2] = {&u, &u};
  Field* narrow[1] = {&v};
  const auto expect_bug = [&](std::span<Field* const> fields) {
    try {
      halo.begin(fields);
      ADD_FAILURE() << "begin() should have thrown";
    } catch (const Error& e) {
      EXPECT_EQ(e.kind(), ErrorKind::bug);
    }
  };
  fill(u, 0);
  expect_bug(two);
  expect_bug(narrow);
  halo.begin(one);
  expect_bug(one);
  halo.finish();
  expect_filled(a, u, 0);
  halo.exchange(u);
  expect_filled(a, u, 0);
}

TEST_P(HaloMpiTest, BytesSentAreThoseOfTheMessages) {
  const Grid grid = testing::unit_grid(40, 0, testing::periodic);
  const Decomposition d(world, grid, {0, 0}, 2);
  const Boundary boundary = Boundary::natural(grid);
  HaloExchange halo(d, boundary, 3, 1, 2, {0, 2});
  Field u(d, 3, 2);
  for (int n = 0; n < 3; ++n) halo.exchange(u);
  EXPECT_EQ(halo.bytes_sent(), world.size() == 1 ? 0 : 3 * 2 * 2 * 2 * 8);  // exchanges, sides, points, species, bytes
  EXPECT_EQ(halo.count(), 3);
}

// Two simulations in one job, and two of them on the same ranks: no message meets another's.
TEST_P(HaloMpiTest, SimulationsSideBySideDoNotHearEachOther) {
  MPI_Comm half = MPI_COMM_NULL;
  const int colour = world.rank() % 2;
  MPI_Comm_split(MPI_COMM_WORLD, colour, world.rank(), &half);
  {
    const Communicator mine(half);
    const Communicator again(half);
    const Sides& x = colour == 0 ? testing::periodic : testing::neumann;
    const Arrangement a{
        testing::unit_grid(19 + colour, 15, x, testing::periodic), x, testing::periodic, {0, 0}, 2, 1 + colour, 1, {}, true};
    const Decomposition d1(mine, a.grid, a.processes, a.width);
    const Decomposition d2(again, a.grid, a.processes, a.width);
    const Boundary boundary = testing::boundary_of(a.x, a.y, a.n_species, testing::zero);
    HaloExchange halo1(d1, boundary, a.n_species, 1, a.width, {}, true);
    HaloExchange halo2(d2, boundary, a.n_species, 1, a.width, {}, true);
    Field u(d1, a.n_species, 2);
    Field v(d2, a.n_species, 2);
    Field* pu = &u;
    Field* pv = &v;
    for (int n = 0; n < 10; ++n) {
      fill(u, 2 * colour);
      fill(v, 2 * colour + 1);
      halo1.begin({&pu, 1});
      halo2.begin({&pv, 1});
      halo2.finish();
      halo1.finish();
      expect_filled(a, u, 2 * colour);
      expect_filled(a, v, 2 * colour + 1);
    }
  }
  MPI_Comm_free(&half);
}

TEST_P(HaloMpiTest, FourRanksMakeAllThreeLayouts) {
  const auto all = layouts(world.size());
  EXPECT_EQ(all.size(), world.size() == 4 ? 3U : (world.size() == 1 ? 1U : 2U));
  for (const auto& layout : all) {
    const Decomposition d(world, testing::unit_grid(21, 19, testing::neumann), layout, 1);
    EXPECT_EQ(d.processes(), layout);
  }
}

}  // namespace
}  // namespace stiffront
