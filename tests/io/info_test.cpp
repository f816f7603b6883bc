// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/io/info.hpp"

#include <gtest/gtest.h>
#include <hdf5.h>

#include <cmath>

#include "stiffront/core/error.hpp"
#include "stiffront/io/checkpoint.hpp"
#include "stiffront/io/result_file.hpp"
#include "support/diffusion_problem.hpp"
#include "support/temporary_folder.hpp"

namespace stiffront {
namespace {

class InfoTest : public ::testing::Test {
 protected:
  Communicator comm_{MPI_COMM_SELF};
  testing::TemporaryFolder folder_{comm_};
};

TEST_F(InfoTest, AStateIsDescribedWithItsGridTimeRangesAndCase) {
  Grid grid = testing::unit_grid(5, 4, true);
  testing::DiffusionProblem problem(comm_, grid,
                                    {testing::both_sides(BoundaryKind::periodic, 2),
                                     testing::both_sides(BoundaryKind::dirichlet, 2, [](double, double, double) { return 0.0; })},
                                    {1.0, 1.0}, 2);
  Field u = problem.field([](int s, double x, double) { return s == 0 ? x : 1.0; });
  u.at(1, 2, 2) = std::nan("");
  write_state(folder_.file("s.h5"), {0.125, 12, true, {"a", "b"}, "title = \"t\""}, problem.boundary, u);
  const std::string text = describe_file(folder_.file("s.h5"));
  for (const char* part : {"time      0.125\n", "step      12 (interpolated within it)", "5 x 4 points", "[0, 1], periodic / periodic",
                           "[0, 1], dirichlet / dirichlet", "a         [4][5] min 0, max 0.8, mean 0.4\n",
                           "b         [4][5] min 1, max 1, mean 1; 1 values are not finite\n", "case:\ntitle = \"t\"\n"}) {
    EXPECT_NE(text.find(part), std::string::npos) << part << "\nnot in\n" << text;
  }
}

TEST_F(InfoTest, APartOfACheckpointIsDescribedWithItsBoxAndArrays) {
  Grid grid = testing::unit_grid(5, 4);
  const Decomposition decomposition(comm_, grid, {0, 0}, 2);
  Field u(decomposition, 2, 1);
  u.at(1, 3, 2) = 7.0;
  write_checkpoint(folder_.path(), {30, 0.5, "m", {"a", "b"}, grid, ""}, decomposition, 2, [&](StateVisitor& v) { v.field("u", u); });
  const std::string text = describe_file(folder_.file("000030/rank-0000.h5"));
  for (const char* part : {"part of a checkpoint", "time      0.5\n", "step      30\n", "5 x 4 points from (0, 0)",
                           "fields/u  [2][4][5] min 0, max 7, mean 0.175\n"}) {
    EXPECT_NE(text.find(part), std::string::npos) << part << "\nnot in\n" << text;
  }
}

TEST_F(InfoTest, AForeignFileIsListed) {
  const std::string path = folder_.file("other.h5");
  const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  const hid_t group = H5Gcreate2(file, "group", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  const hsize_t extent = 3;
  const hid_t space = H5Screate_simple(1, &extent, nullptr);
  H5Dclose(H5Dcreate2(group, "zeros", H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  H5Sclose(space);
  H5Gclose(group);
  H5Fclose(file);
  const std::string text = describe_file(path);
  EXPECT_NE(text.find("no result of this program"), std::string::npos) << text;
  EXPECT_NE(text.find("group/zeros [3] min 0, max 0, mean 0"), std::string::npos) << text;
}

TEST_F(InfoTest, AFileThatCannotBeReadIsNamed) {
  testing::write_content(folder_.file("broken.h5"), "\x89HDF\r\n\x1a\nand then nothing");
  for (const char* name : {"broken.h5", "none.h5", "."}) {
    try {
      describe_file(folder_.file(name));
      FAIL() << name;
    } catch (const Error& e) {
      EXPECT_EQ(e.kind(), ErrorKind::io);
      EXPECT_NE(std::string(e.what()).find(folder_.path()), std::string::npos) << e.what();
    }
  }
}

}  // namespace
}  // namespace stiffront
