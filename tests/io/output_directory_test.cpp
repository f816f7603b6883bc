// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/io/output_directory.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>

#include "stiffront/core/error.hpp"
#include "support/temporary_folder.hpp"

namespace stiffront {
namespace {

using testing::TemporaryFolder;
using testing::write_content;
namespace fs = std::filesystem;

class OutputDirectoryTest : public ::testing::Test {
 protected:
  std::string message_of(const std::string& path, ExistingResults existing) {
    try {
      OutputDirectory(comm_, path, existing);
    } catch (const Error& e) {
      EXPECT_EQ(e.kind(), ErrorKind::io);
      return e.what();
    }
    return "";
  }
  Communicator comm_{MPI_COMM_SELF};
  TemporaryFolder folder_{comm_};
};

TEST_F(OutputDirectoryTest, IsMadeWithItsParentsAndLeftEmpty) {
  const OutputDirectory made(comm_, folder_.file("a/b/c"), ExistingResults::refuse);
  EXPECT_TRUE(fs::is_directory(folder_.file("a/b/c")));
  EXPECT_TRUE(fs::is_empty(folder_.file("a/b/c")));
}

TEST_F(OutputDirectoryTest, ResultsOfAnotherRunAreRefusedWithTheRemedyAndLeftAlone) {
  write_content(folder_.file("fields-000010.h5"), "precious");
  write_content(folder_.file("summary.json"), "{}");
  const std::string message = message_of(folder_.path(), ExistingResults::refuse);
  EXPECT_NE(message.find("fields-000010.h5, summary.json"), std::string::npos) << message;
  EXPECT_NE(message.find("--force"), std::string::npos) << message;
  EXPECT_NE(message.find("--restart latest"), std::string::npos) << message;
  EXPECT_EQ(testing::content_of(folder_.file("fields-000010.h5")), "precious");
}

TEST_F(OutputDirectoryTest, FilesThatAreNoResultsAreNeitherRefusedNorRemoved) {
  write_content(folder_.file("notes.txt"), "mine");
  write_content(folder_.file("fields-best.h5"), "mine");
  write_content(folder_.file("fields-10-.h5"), "mine");
  EXPECT_EQ(message_of(folder_.path(), ExistingResults::refuse), "");
  EXPECT_EQ(message_of(folder_.path(), ExistingResults::replace), "");
  EXPECT_TRUE(fs::exists(folder_.file("notes.txt")));
  EXPECT_TRUE(fs::exists(folder_.file("fields-best.h5")));
  EXPECT_TRUE(fs::exists(folder_.file("fields-10-.h5")));
}

TEST_F(OutputDirectoryTest, ReplacingRemovesEveryResult) {
  for (const char* name :
       {"fields-000000.h5", "fields-1234567.h5", "fields-000003-1.h5", "fields.xdmf", "history.csv", "probes.csv", "summary.json"}) {
    write_content(folder_.file(name), "old");
  }
  fs::create_directories(folder_.file("checkpoints/000120"));
  EXPECT_EQ(results_in(folder_.path()).size(), 8U);
  const OutputDirectory replaced(comm_, folder_.path(), ExistingResults::replace);
  EXPECT_TRUE(fs::is_empty(folder_.path()));
}

TEST_F(OutputDirectoryTest, FilesCutShortByAKillAreCleanedAway) {
  write_content(folder_.file("fields-000010.h5.tmp"), "part");
  write_content(folder_.file("fields-000005.h5"), "whole");
  const OutputDirectory continued(comm_, folder_.path(), ExistingResults::keep);
  EXPECT_FALSE(fs::exists(folder_.file("fields-000010.h5.tmp")));
  EXPECT_TRUE(fs::exists(folder_.file("fields-000005.h5")));
}

TEST_F(OutputDirectoryTest, AFileInTheWayIsNamed) {
  write_content(folder_.file("out"), "");
  EXPECT_NE(message_of(folder_.file("out"), ExistingResults::refuse).find("is a file, not a folder"), std::string::npos);
  EXPECT_NE(message_of(folder_.file("out/below"), ExistingResults::refuse).find("cannot be created"), std::string::npos);
}

TEST_F(OutputDirectoryTest, AFolderThatCannotBeWrittenIsFoundBeforeTheFirstStep) {
  if (::geteuid() == 0) {
    // Root may write anywhere but into the kernel's own folders.
    EXPECT_NE(message_of("/proc/self/task", ExistingResults::refuse).find("nothing can be written"), std::string::npos);
    return;
  }
  ASSERT_EQ(::chmod(folder_.path().c_str(), 0555), 0);
  const std::string message = message_of(folder_.path(), ExistingResults::refuse);
  ::chmod(folder_.path().c_str(), 0755);
  EXPECT_NE(message.find("nothing can be written"), std::string::npos) << message;
  EXPECT_NE(message.find("-o DIR"), std::string::npos) << message;
}

TEST_F(OutputDirectoryTest, NamesOfStatesAreInOrderOfTime) {
  const OutputDirectory d(comm_, folder_.path(), ExistingResults::refuse);
  const std::vector<std::string> expected{"fields-000000.h5", "fields-000002-1.h5", "fields-000002-2.h5",
                                          "fields-000002.h5", "fields-999999.h5",   "fields-1000000-1.h5"};
  EXPECT_EQ(OutputDirectory::state_name(2, 1), expected[1]);
  EXPECT_EQ(OutputDirectory::state_name(999999), expected[4]);
  for (const std::string& name : expected) write_content(folder_.file(name), "");
  EXPECT_EQ(d.state_names(), expected);
  d.remove_states_after(2);
  EXPECT_EQ(d.state_names(), std::vector<std::string>(expected.begin(), expected.begin() + 4));
}

}  // namespace
}  // namespace stiffront
