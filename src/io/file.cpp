// SPDX-License-Identifier: BSD-3-Clause
#include "file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <vector>

#include "content_hash.hpp"
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

  /// Fills the buffer as far as the file goes.
  std::size_t read(char* buffer, std::size_t size) const {
    std::size_t done = 0;
    while (done < size) {
      const ssize_t n = ::read(fd_, buffer + done, size - done);
      if (n < 0 && errno == EINTR) continue;
      if (n < 0) fail(path_, "be read", errno);
      if (n == 0) break;
      done += static_cast<std::size_t>(n);
    }
    return done;
  }

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
  char buffer[1 << 16];
  while (const std::size_t n = in.read(buffer, sizeof buffer)) content.append(buffer, n);
  return content;
}

std::pair<std::int64_t, std::uint64_t> measure(const std::string& path) {
  const Descriptor in(path, O_RDONLY, "be read");
  ContentHash hash;
  std::int64_t length = 0;
  std::vector<char> buffer(std::size_t{1} << 20);
  while (const std::size_t n = in.read(buffer.data(), buffer.size())) {
    hash.add({buffer.data(), n});
    length += static_cast<std::int64_t>(n);
  }
  return {length, hash.value()};
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
      throw Error(ErrorKind::io,
                  fmt::format("{}: no room for {:.1f} MiB: {}", path, static_cast<double>(bytes) / 1048576.0, std::strerror(reason)));
    }
  }
  if (::ftruncate(out.get(), 0) != 0) fail(path, "be written", errno);
  out.close();
}

}  // namespace stiffront::file
