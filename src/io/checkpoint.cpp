// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/io/checkpoint.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "checkpoint_visitors.hpp"
#include "content_hash.hpp"
#include "fail_point.hpp"
#include "file.hpp"
#include "manifest.hpp"
#include "stiffront/core/agree.hpp"
#include "stiffront/core/error.hpp"

namespace stiffront {
namespace {

namespace fs = std::filesystem;

constexpr const char* manifest_name = "manifest.json";
constexpr const char* unfinished = ".tmp";

struct Found {
  std::int64_t step;
  std::string path;
};

/// The checkpoints in a folder, newest first. Unfinished ones have other names.
std::vector<Found> checkpoints_in(const std::string& folder) {
  std::vector<Found> found;
  std::error_code failed;
  fs::directory_iterator it(folder, failed);
  for (; !failed && it != fs::directory_iterator(); it.increment(failed)) {
    const std::string name = it->path().filename().string();
    std::int64_t step = 0;
    const auto r = std::from_chars(name.data(), name.data() + name.size(), step);
    if (r.ec == std::errc() && r.ptr == name.data() + name.size()) found.push_back({step, it->path().string()});
  }
  if (failed) file::fail(folder, "be listed", failed.value());
  std::sort(found.begin(), found.end(), [](const Found& a, const Found& b) { return a.step > b.step; });
  return found;
}

void remove_all(const std::string& path) {
  std::error_code failed;
  fs::remove_all(path, failed);
  if (failed) file::fail(path, "be removed", failed.value());
}

/// What was left behind by runs that were killed while they wrote.
void remove_unfinished(const std::string& folder) {
  std::vector<std::string> names;
  std::error_code failed;
  for (fs::directory_iterator it(folder, failed); !failed && it != fs::directory_iterator(); it.increment(failed)) {
    if (it->path().extension() == unfinished) names.push_back(it->path().string());
  }
  for (const std::string& name : names) remove_all(name);
}

/// Gives a finished checkpoint its name. With one of the same step that is there already it changes places, so that there is one at any
/// moment; where the file system cannot do that, the old one steps aside first.
void publish(const std::string& temporary, const std::string& path, const std::string& folder) {
  if (::renameat2(AT_FDCWD, temporary.c_str(), AT_FDCWD, path.c_str(), RENAME_EXCHANGE) == 0) {
    file::sync(folder);
    remove_all(temporary);
    return;
  }
  const std::string aside = path + ".old" + unfinished;
  std::error_code ignored;
  if (fs::exists(path, ignored)) file::rename(path, aside);
  file::rename(temporary, path);
  file::sync(folder);
  remove_all(aside);
}

/// Keeps the newest ones up to this step.
void prune(const std::string& folder, std::int64_t step, int keep) {
  int kept = 0;
  for (const Found& f : checkpoints_in(folder)) {
    if (f.step > step || ++kept > std::max(1, keep)) remove_all(f.path);
  }
}

/// The numbers of a run are the same on all ranks, or the run is not what it is taken for.
void require_same_numbers(const Communicator& comm, const Manifest& manifest) {
  std::string all;
  for (const auto& [name, values] : manifest.numbers) {
    all += name;
    all.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(double));
  }
  // One bit less, so that the negative has no overflow.
  const auto mine = static_cast<std::int64_t>(content_hash(all) >> 1);
  if (comm.max(mine) != -comm.max(-mine)) throw Error(ErrorKind::bug, "a number that goes into the checkpoint differs between ranks");
}

Manifest manifest_of(const std::string& text, const std::string& path) {
  try {
    return Manifest::parse(text);
  } catch (const Error& e) {
    throw Error(e.kind(), fmt::format("{}: {}", path, e.what()));
  }
}

/// Checks the files of a checkpoint, each by one rank.
void verify(const Communicator& comm, const Manifest& manifest, const std::string& path) {
  for (auto n = static_cast<std::size_t>(comm.rank()); n < manifest.shards.size(); n += static_cast<std::size_t>(comm.size())) {
    const std::string name = (fs::path(path) / shard_name(n)).string();
    const auto [bytes, hash] = file::measure(name);
    if (bytes != manifest.shards[n].bytes) {
      throw Error(ErrorKind::io, fmt::format("{}: {} bytes long instead of {}", name, bytes, manifest.shards[n].bytes));
    }
    if (hash != manifest.shards[n].hash) throw Error(ErrorKind::io, fmt::format("{}: its content was changed (wrong checksum)", name));
  }
}

/// The checkpoints a path given by the user may mean, newest first.
std::vector<std::string> candidates(const std::string& path) {
  std::error_code failed;
  if (fs::exists(fs::path(path) / manifest_name, failed)) return {path};
  std::string folder = path;
  if (fs::is_directory(fs::path(path) / "checkpoints", failed)) folder = (fs::path(path) / "checkpoints").string();
  std::vector<std::string> paths;
  for (const Found& f : checkpoints_in(folder)) paths.push_back(f.path);
  return paths;
}

}  // namespace

void visit_progress(StateVisitor& visitor, Progress& progress) {
  visitor.integer("accepted_steps", progress.accepted);
  visitor.integer("rejected_steps", progress.rejected);
  visitor.number("time", progress.t);
  visitor.number("dt", progress.dt);
  visitor.number("resume_dt", progress.resume_dt);
}

void write_checkpoint(const std::string& folder, const CheckpointHeader& header, const Decomposition& decomposition, int keep,
                      const VisitState& visit) {
  const Communicator& comm = decomposition.comm();
  const std::string path = (fs::path(folder) / fmt::format("{:06}", header.step)).string();
  const std::string temporary = path + unfinished;
  try {
    collectively(comm, [&] {
      if (!comm.is_root()) return;
      std::error_code failed;
      fs::create_directories(folder, failed);
      if (failed) file::fail(folder, "be created", failed.value());
      remove_unfinished(folder);
      fs::create_directory(temporary, failed);
      if (failed) file::fail(temporary, "be created", failed.value());
    });

    Manifest manifest;
    manifest.header = header;
    Shard mine;
    mine.box = decomposition.box_of(comm.rank());
    collectively(comm, [&] {
      SavingVisitor visitor(decomposition, manifest);
      visit(visitor);
      const std::string image = visitor.image();
      file::write((fs::path(temporary) / shard_name(static_cast<std::size_t>(comm.rank()))).string(), image);
      mine.bytes = static_cast<std::int64_t>(image.size());
      mine.hash = content_hash(image);
    });
    fail_point("checkpoint.after_shard");
    require_same_numbers(comm, manifest);
    if (comm.is_root()) manifest.shards.resize(static_cast<std::size_t>(comm.size()));
    check_mpi(MPI_Gather(&mine, sizeof mine, MPI_BYTE, manifest.shards.data(), sizeof mine, MPI_BYTE, 0, comm.get()), "MPI_Gather");

    collectively(comm, [&] {
      if (!comm.is_root()) return;
      fail_point("checkpoint.before_manifest");
      file::write((fs::path(temporary) / manifest_name).string(), manifest.text());
      file::sync(temporary);
      fail_point("checkpoint.before_rename");
      publish(temporary, path, folder);
      fail_point("checkpoint.before_prune");
      prune(folder, header.step, keep);
    });
  } catch (...) {
    std::error_code ignored;
    if (comm.is_root()) fs::remove_all(temporary, ignored);
    throw;
  }
}

Checkpoint::Checkpoint(const Communicator& comm, const std::string& path) : comm_(&comm) {
  std::string list;
  collectively(comm, [&] {
    if (!comm.is_root()) return;
    for (const std::string& c : candidates(path)) list += c + "\n";
  });
  list = comm.broadcast(list);
  for (std::size_t begin = 0; begin < list.size() && !manifest_;) {
    const std::size_t end = list.find('\n', begin);
    path_ = list.substr(begin, end - begin);
    begin = end + 1;
    try {
      std::string text;
      collectively(comm, [&] {
        if (comm.is_root()) text = file::read((fs::path(path_) / manifest_name).string());
      });
      const auto manifest = std::make_shared<const Manifest>(manifest_of(comm.broadcast(text), path_));
      collectively(comm, [&] { verify(comm, *manifest, path_); });
      manifest_ = manifest;
    } catch (const Error& e) {
      // Every rank has the same error here.
      if (e.kind() != ErrorKind::io) throw;
      warnings_.push_back(fmt::format("the checkpoint {} cannot be used: {}", path_, e.what()));
    }
  }
  if (!manifest_) {
    throw Error(ErrorKind::io, warnings_.empty() ? fmt::format("{}: no checkpoint here to continue from", path)
                                                 : fmt::format("{}: no valid checkpoint: {}", path, fmt::join(warnings_, "; ")));
  }
  header_ = manifest_->header;
}

void Checkpoint::require(const std::string& model, const std::vector<std::string>& species, const Grid& grid) const {
  const auto refuse = [&](const std::string& what) {
    throw Error(ErrorKind::input, fmt::format("{}: cannot be continued by this case: {}", path_, what));
  };
  if (header_.model != model) refuse(fmt::format("it is of the model \"{}\", not \"{}\"", header_.model, model));
  if (header_.species != species) {
    refuse(fmt::format("its species are {}, not {}", fmt::join(header_.species, ", "), fmt::join(species, ", ")));
  }
  const Grid& mine = header_.grid;
  if (mine.dimension != grid.dimension || mine.points != grid.points) {
    refuse(fmt::format("its grid has {} x {} points, not {} x {}; to go on from it on another grid, start from one of the result files",
                       mine.points[0], mine.points[1], grid.points[0], grid.points[1]));
  }
  if (mine.lower != grid.lower || mine.upper != grid.upper || mine.periodic != grid.periodic) {
    refuse("its grid lies elsewhere or has other periodic directions");
  }
}

void Checkpoint::load(const Decomposition& decomposition, const VisitState& visit) const {
  collectively(*comm_, [&] {
    LoadingVisitor visitor(decomposition, *manifest_, path_);
    visit(visitor);
    visitor.require_all_asked_for();
  });
}

}  // namespace stiffront
