// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

/// Files in plain POSIX, on one process, with every failure as Error(io) that names the file and the system's reason.
namespace stiffront::file {

/// "PATH: cannot WHAT: reason of errno".
[[noreturn]] void fail(const std::string& path, const char* what, int error_number);

std::string read(const std::string& path);
/// Length and content_hash of a file, read piece by piece.
std::pair<std::int64_t, std::uint64_t> measure(const std::string& path);
/// Creates or replaces the file and waits until it is on the disk.
void write(const std::string& path, std::string_view content);
/// Adds to the end, creating the file if needed.
void append(const std::string& path, std::string_view content);
/// Writes under a temporary name and renames: a reader sees the old content or the new, never a part.
void replace(const std::string& path, std::string_view content);
/// Waits until what was written to a file, or the entries of a folder, are on the disk.
void sync(const std::string& path);
void rename(const std::string& from, const std::string& to);
/// Finds out whether a file of so many bytes can be written: creates it, asks for the space and leaves it empty. File systems that
/// cannot promise space are believed.
void reserve(const std::string& path, long long bytes);

}  // namespace stiffront::file
