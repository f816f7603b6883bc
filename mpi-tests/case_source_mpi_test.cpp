// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>

#include "stiffront/app/case_source.hpp"
#include "stiffront/core/error.hpp"

namespace stiffront::app {
namespace {

TEST(CaseSourceMpi, RootAloneReadsAndEveryRankHasItsBytes) {
  const Communicator comm(MPI_COMM_WORLD);
  // Each rank names a file of its own: only root's is there.
  const std::string name =
      ::testing::TempDir() + "/case_source_" + std::to_string(comm.size()) + "_" + std::to_string(comm.rank()) + ".toml";
  const std::string text = "title = \"of root\"\n" + std::string(100000, '#') + "\n";
  if (comm.is_root()) std::ofstream(name) << text;
  EXPECT_EQ(read_case_source(name, {}, comm).text, text);
  if (comm.is_root()) std::remove(name.c_str());
}

TEST(CaseSourceMpi, EveryRankThrowsWhatRootCannotRead) {
  const Communicator comm(MPI_COMM_WORLD);
  try {
    read_case_source("no-such-case.toml", {}, comm);
    ADD_FAILURE() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::io);
    EXPECT_EQ(std::string(error.what()).substr(0, 44), "no-such-case.toml: No such file or directory");
  }
  comm.barrier();  // nobody was left behind
}

}  // namespace
}  // namespace stiffront::app
