// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/io/output_directory.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <optional>
#include <utility>

#include "file.hpp"
#include "stiffront/core/agree.hpp"
#include "stiffront/core/error.hpp"

namespace stiffront {
namespace {

namespace fs = std::filesystem;

/// fields-NNNNNN[-K].h5 taken apart.
struct StateName {
  std::int64_t step;
  std::int64_t index;
};

std::optional<StateName> parse(const std::string& name) {
  const std::string_view prefix = "fields-";
  const std::string_view suffix = ".h5";
  if (!name.starts_with(prefix) || !name.ends_with(suffix)) return std::nullopt;
  const char* end = name.data() + name.size() - suffix.size();
  StateName r{0, 0};
  auto at = std::from_chars(name.data() + prefix.size(), end, r.step);
  if (at.ec != std::errc()) return std::nullopt;
  if (at.ptr != end) {
    if (*at.ptr != '-') return std::nullopt;
    at = std::from_chars(at.ptr + 1, end, r.index);
    if (at.ec != std::errc() || at.ptr != end) return std::nullopt;
  }
  return r;
}

/// Calls f with the name of each entry of a folder; a folder that cannot be listed is an error.
template <class F>
void for_each_entry(const std::string& path, F&& f) {
  std::error_code failed;
  fs::directory_iterator it(path, failed);
  for (; !failed && it != fs::directory_iterator(); it.increment(failed)) f(it->path().filename().string());
  if (failed) file::fail(path, "be listed", failed.value());
}

/// What a run that failed leaves behind.
bool is_failure(const std::string& name) {
  return name == OutputDirectory::failed_cell || (name.starts_with("failed-") && name.ends_with(".h5"));
}

bool is_result(const std::string& name) {
  static const char* const names[] = {"fields.xdmf", "history.csv", "probes.csv", "summary.json", "checkpoints", "converge.json"};
  return parse(name) || is_failure(name) || std::find(std::begin(names), std::end(names), name) != std::end(names);
}

/// A file that a run was writing when it was killed.
bool is_leftover(const std::string& name) {
  const std::string_view suffix = ".tmp";
  return name.ends_with(suffix) && is_result(name.substr(0, name.size() - suffix.size()));
}

void remove_entry(const fs::path& path) {
  std::error_code failed;
  fs::remove_all(path, failed);
  if (failed) file::fail(path.string(), "be removed", failed.value());
}

void prove_writable(const std::string& path, const std::string& probe) {
  try {
    file::write(probe, "");
  } catch (const Error& e) {
    throw Error(ErrorKind::io,
                fmt::format("output.directory: nothing can be written to '{}' ({}); choose another with -o DIR", path, e.what()));
  }
}

}  // namespace

std::vector<std::string> results_in(const std::string& path) {
  std::vector<std::string> results;
  std::error_code ignored;
  if (!fs::is_directory(path, ignored)) return results;
  for_each_entry(path, [&](const std::string& name) {
    if (is_result(name)) results.push_back(name);
  });
  std::sort(results.begin(), results.end());
  return results;
}

OutputDirectory::OutputDirectory(const Communicator& comm, std::string path, ExistingResults existing)
    : comm_(&comm), path_(std::move(path)) {
  std::string probe;
  collectively(comm, [&] {
    if (!comm.is_root()) return;
    std::error_code failed;
    if (fs::exists(path_, failed) && !fs::is_directory(path_, failed)) {
      throw Error(ErrorKind::io, fmt::format("output.directory: '{}' is a file, not a folder", path_));
    }
    fs::create_directories(path_, failed);
    if (failed) {
      throw Error(ErrorKind::io, fmt::format("output.directory: the folder '{}' cannot be created: {}", path_, failed.message()));
    }
    const std::vector<std::string> results = results_in(path_);
    if (existing == ExistingResults::refuse && !results.empty()) {
      throw Error(ErrorKind::io,
                  fmt::format("output.directory: '{}' holds the results of another run ({}{}); choose another folder with -o DIR, go on "
                              "with that run by --restart latest, or replace its results by --force",
                              path_, fmt::join(results.begin(), results.begin() + std::min<std::ptrdiff_t>(3, std::ssize(results)), ", "),
                              results.size() > 3 ? ", ..." : ""));
    }
    probe = file(fmt::format(".stiffront-{}-{}", ::getpid(), static_cast<const void*>(this)));
    prove_writable(path_, probe);
    std::vector<std::string> unwanted;
    for_each_entry(path_, [&](const std::string& name) {
      if (is_leftover(name) || (existing == ExistingResults::replace && is_result(name))) unwanted.push_back(name);
    });
    for (const std::string& name : unwanted) remove_entry(fs::path(path_) / name);
  });
  probe = comm.broadcast(probe);
  const auto remove_probe = [&] {
    std::error_code ignored;
    if (comm.is_root()) fs::remove(probe, ignored);
  };
  try {
    collectively(comm, [&] {
      std::error_code failed;
      if (fs::exists(probe, failed)) return;
      throw Error(ErrorKind::io, fmt::format("output.directory: rank {} does not see '{}': the folder must be on a file system that all "
                                             "ranks share",
                                             comm.rank(), fs::absolute(path_).string()));
    });
  } catch (...) {
    remove_probe();
    throw;
  }
  remove_probe();
}

std::string OutputDirectory::file(const std::string& name) const { return (fs::path(path_) / name).string(); }

std::string OutputDirectory::state_name(std::int64_t step, int index) {
  return index == 0 ? fmt::format("fields-{:06}.h5", step) : fmt::format("fields-{:06}-{}.h5", step, index);
}

std::string OutputDirectory::failed_state_name(std::int64_t step) { return fmt::format("failed-{:06}.h5", step); }

std::vector<std::string> OutputDirectory::state_names() const {
  std::vector<std::pair<StateName, std::string>> found;
  for_each_entry(path_, [&](const std::string& name) {
    if (const auto parts = parse(name)) found.emplace_back(*parts, name);
  });
  // Index 0 is the last of its step.
  const auto key = [](const StateName& s) { return std::pair(s.step, static_cast<std::uint64_t>(s.index) - 1); };
  std::sort(found.begin(), found.end(), [&](const auto& a, const auto& b) { return key(a.first) < key(b.first); });
  std::vector<std::string> names;
  for (auto& f : found) names.push_back(std::move(f.second));
  return names;
}

void OutputDirectory::remove_states_after(std::int64_t step) const {
  for (const std::string& name : state_names()) {
    if (parse(name)->step > step) remove_entry(fs::path(path_) / name);
  }
}

void OutputDirectory::remove_failures() const {
  std::vector<std::string> unwanted;
  for_each_entry(path_, [&](const std::string& name) {
    if (is_failure(name)) unwanted.push_back(name);
  });
  for (const std::string& name : unwanted) remove_entry(fs::path(path_) / name);
}

}  // namespace stiffront
