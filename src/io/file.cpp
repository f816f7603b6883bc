// SPDX-License-Identifier: BSD-3-Clause
#include "file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "stiffront/core/error.hpp"

namespace stiffront::file {
namespace {

/// A file descriptor that is closed at the end; close() reports what only then comes to light (quotas, network file systems).
class Descriptor {
 public:
  Descriptor(const std::string& path, int flags, const char* what) : path_(path), fd_(::open(path.c_str(), flags | O_CLOEXEC, 0666)) {
    if (fd_ < 0) fail(path_, what, errno);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  int get() const { return fd_; }

  void write(std::string_view content) const {
    while (!content.empty()) {
      const ssize_t n = ::write(fd_, content.data(), content.size());
      if (n < 0) {
        if (errno == EINTR) continue;
        fail(path_, "be written", errno);
      }
      content.remove_prefix(static_cast<std::size_t>(n));
    }
  }
  void sync() const {
    // Pipes and some file systems know no fsync; that is no failure to write.
    if (::fsync(fd_) != 0 && errno != EINVAL && errno != EROFS) fail(path_, "be written to the disk", errno);
  }
  void close() {
    const int fd = fd_;
    fd_ = -1;
    if (::close(fd) != 0 && errno != EINTR) fail(path_, "be closed", errno);
  }

 private:
  std::string path_;
  int fd_;
};

}  // namespace

void fail(const std::string& path, const char* what, int error_number) {
  throw Error(ErrorKind::io, fmt::format("{}: cannot {}: {}", path, what, std::strerror(error_number)));
}

std::string read(const std::string& path) {
  const Descriptor in(path, O_RDONLY, "be read");
  std::string content;
  struct stat status {};
  if (::fstat(in.get(), &status) == 0 && status.st_size > 0) content.reserve(static_cast<std::size_t>(status.st_size));
  char buffer[1 << 16];
  while (true) {
    const ssize_t n = ::read(in.get(), buffer, sizeof buffer);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) fail(path, "be read", errno);
    if (n == 0) return content;
    content.append(buffer, static_cast<std::size_t>(n));
  }
}

void write(const std::string& path, std::string_view content) {
  Descriptor out(path, O_WRONLY | O_CREAT | O_TRUNC, "be written");
  out.write(content);
  out.sync();
  out.close();
}

void append(const std::string& path, std::string_view content) {
  Descriptor out(path, O_WRONLY | O_CREAT | O_APPEND, "be written");
  out.write(content);
  out.close();
}

void replace(const std::string& path, std::string_view content) {
  const std::string temporary = path + ".tmp";
  try {
    write(temporary, content);
    rename(temporary, path);
  } catch (...) {
    ::unlink(temporary.c_str());
    throw;
  }
}

void sync(const std::string& path) { Descriptor(path, O_RDONLY, "be opened").sync(); }

void rename(const std::string& from, const std::string& to) {
  if (std::rename(from.c_str(), to.c_str()) != 0) fail(to, "be created", errno);
}

void reserve(const std::string& path, long long bytes) {
  Descriptor out(path, O_WRONLY | O_CREAT | O_TRUNC, "be written");
  if (::fallocate(out.get(), 0, 0, static_cast<off_t>(bytes)) != 0) {
    const int reason = errno;
    if (reason == ENOSPC || reason == EFBIG || reason == EDQUOT || reason == EIO) {
      ::unlink(path.c_str());
      throw Error(ErrorKind::io, fmt::format("{}: no room for {:.1f} MiB: {}", path, static_cast<double>(bytes) / 1048576.0,
                                             std::strerror(reason)));
    }
  }
  if (::ftruncate(out.get(), 0) != 0) fail(path, "be written", errno);
  out.close();
}

}  // namespace stiffront::file
