// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/mesh/field.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <utility>

#include "stiffront/core/simd.hpp"
#include "support/grids.hpp"

namespace stiffront {
namespace {

class FieldTest : public ::testing::Test {
 protected:
  const Communicator self{MPI_COMM_SELF};
};

TEST_F(FieldTest, PointsAreDistinctAndStartAtZero) {
  for (const int n_y : {0, 5}) {
    for (const int halo : {1, 2, 4}) {
      const Decomposition d(self, testing::unit_grid(13, n_y, testing::neumann), {0, 0}, 1);
      Field u(d, 3, halo);
      const auto for_each = [&](auto f) {
        int number = 0;
        for (int s = 0; s < 3; ++s) {
          for (int j = -u.halo_y(); j < u.n_y() + u.halo_y(); ++j) {
            for (int i = -u.halo(); i < u.n_x() + u.halo(); ++i) f(u.at(s, i, j), ++number);
          }
        }
      };
      EXPECT_EQ(u.halo_y(), n_y == 0 ? 0 : halo);
      for_each([](double& x, int) { ASSERT_EQ(x, 0.0); });
      for_each([](double& x, int number) { x = number; });
      for_each([](double& x, int number) { ASSERT_EQ(x, number); });
    }
  }
}

TEST_F(FieldTest, RowsAreAlignedAndTheirPaddingStaysZero) {
  for (int n_x = 1; n_x < 40; ++n_x) {
    const Decomposition d(self, testing::unit_grid(n_x, 3, testing::periodic), {0, 0}, 1);
    Field u(d, 2, 4);
    for (int s = 0; s < 2; ++s) {
      for (int j = -4; j < 7; ++j) {
        ASSERT_EQ(reinterpret_cast<std::uintptr_t>(u.row(s, j)) % 64, 0U);
        std::fill(u.row(s, j) - 4, u.row(s, j) + n_x + 4, 1.0);
      }
    }
    // A pack that starts at the last point, shifted by the halo width in any direction, reads no more than ones and zeros.
    for (int s = 0; s < 2; ++s) {
      for (int j = 0; j < 3; ++j) {
        for (const std::ptrdiff_t shift : {std::ptrdiff_t{-4}, std::ptrdiff_t{4}, -4 * u.row_stride(), 4 * u.row_stride()}) {
          const Pack p = Pack::load(u.row(s, j) + n_x - 1 + shift);
          for (int l = 0; l < pack_size; ++l) ASSERT_TRUE(p[l] == 0.0 || p[l] == 1.0);
          ASSERT_EQ(p[0], 1.0);
        }
      }
    }
  }
}

TEST_F(FieldTest, CopyingTheInteriorLeavesHalosAlone) {
  const Decomposition d(self, testing::unit_grid(9, 4, testing::neumann), {0, 0}, 1);
  Field u(d, 2, 2);
  Field v = u.similar();
  for (int s = 0; s < 2; ++s) {
    for (int j = -2; j < 6; ++j) {
      std::fill(u.row(s, j) - 2, u.row(s, j) + 11, 3.0 + s);
      std::fill(v.row(s, j) - 2, v.row(s, j) + 11, -1.0);
    }
  }
  v.copy_interior(u, 1);
  const auto expect = [&](double interior0, double interior1) {
    for (int j = -2; j < 6; ++j) {
      for (int i = -2; i < 11; ++i) {
        const bool interior = i >= 0 && i < 9 && j >= 0 && j < 4;
        ASSERT_EQ(v.at(0, i, j), interior ? interior0 : -1.0);
        ASSERT_EQ(v.at(1, i, j), interior ? interior1 : -1.0);
      }
    }
  };
  expect(-1.0, 4.0);
  v.copy_interior(u);
  expect(3.0, 4.0);
}

TEST_F(FieldTest, SwapExchangesTheStorage) {
  const Decomposition d(self, testing::unit_grid(9, 0, testing::neumann), {0, 0}, 1);
  Field u(d, 1, 1);
  Field v(d, 1, 1);
  u.at(0, 3) = 7.0;
  const double* storage = u.row(0, 0);
  swap(u, v);
  EXPECT_EQ(v.row(0, 0), storage);
  EXPECT_EQ(v.at(0, 3), 7.0);
  EXPECT_EQ(u.at(0, 3), 0.0);
}

}  // namespace
}  // namespace stiffront
