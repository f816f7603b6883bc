// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "stiffront/core/mpi.hpp"

namespace stiffront::testing {

/// A folder of a test's own, the same on all ranks, made by root and removed at the end. @mpi both ends are collective.
class TemporaryFolder {
 public:
  explicit TemporaryFolder(const Communicator& comm) : comm_(&comm) {
    std::string path;
    if (comm.is_root()) {
      path = (std::filesystem::temp_directory_path() / "stiffront-test-XXXXXX").string();
      if (::mkdtemp(path.data()) == nullptr) path = "cannot-make-a-temporary-folder";
    }
    path_ = comm.broadcast(path);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    MPI_Barrier(comm_->get());
    std::error_code ignored;
    if (comm_->is_root()) std::filesystem::remove_all(path_, ignored);
  }

  const std::string& path() const { return path_; }
  std::string file(const std::string& name) const { return (std::filesystem::path(path_) / name).string(); }

 private:
  const Communicator* comm_;
  std::string path_;
};

inline std::string content_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

inline void write_content(const std::string& path, const std::string& content) { std::ofstream(path, std::ios::binary) << content; }

}  // namespace stiffront::testing
