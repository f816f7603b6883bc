// SPDX-License-Identifier: BSD-3-Clause
#include "checkpoint_visitors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <utility>

#include "stiffront/core/error.hpp"

namespace stiffront {
namespace {

constexpr std::size_t growth = std::size_t{4} << 20;  // bytes by which an image in memory grows

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// Creates a dataset, with the groups in its name.
hdf5::Handle create(hid_t file, const std::string& name, const std::vector<hsize_t>& extent) {
  const hdf5::Handle space = hdf5::simple_space(extent);
  const hdf5::Handle link(H5Pcreate(H5P_LINK_CREATE), H5Pclose, name);
  hdf5::check(H5Pset_create_intermediate_group(link, 1), name);
  return hdf5::Handle(H5Dcreate2(file, name.c_str(), H5T_IEEE_F64LE, space, link, H5P_DEFAULT, H5P_DEFAULT), H5Dclose,
                      fmt::format("cannot make the dataset '{}'", name));
}

std::string field_path(const std::string& name) { return fmt::format("fields/{}", name); }
std::string cells_path(const std::string& name) { return fmt::format("cells/{}", name); }

}  // namespace

SavingVisitor::SavingVisitor(const Decomposition& decomposition, Manifest& manifest)
    : decomposition_(&decomposition), manifest_(&manifest) {
  hdf5::silence();
  const hdf5::Handle access = hdf5::file_access();
  hdf5::check(H5Pset_fapl_core(access, growth, 0), "HDF5 file in memory");
  const std::string name = shard_name(static_cast<std::size_t>(decomposition.comm().rank()));
  file_ = hdf5::Handle(H5Fcreate(name.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access), H5Fclose, "cannot make an HDF5 file in memory");
  hdf5::write_attribute(file_, "format", std::string("stiffront-checkpoint"));
  hdf5::write_attribute(file_, "step", manifest.header.step);
  hdf5::write_attribute(file_, "time", manifest.header.time);
  const auto box = decomposition.box_of(decomposition.comm().rank());
  hdf5::write_attribute(file_, "box", std::vector<std::int64_t>(box.begin(), box.end()));
}

void SavingVisitor::claim(const std::string& name) {
  if (!names_.insert(name).second) throw Error(ErrorKind::bug, fmt::format("a checkpoint cannot hold '{}' twice", name));
}

void SavingVisitor::numbers(const std::string& name, std::vector<double>& values) {
  claim(name);
  manifest_->numbers[name] = values;
}

void SavingVisitor::field(const std::string& name, Field& values) {
  claim(name);
  manifest_->fields.push_back(name);
  const auto n_x = static_cast<std::size_t>(values.n_x());
  const auto n_y = static_cast<std::size_t>(values.n_y());
  const hdf5::Handle dataset = create(file_, field_path(name), {static_cast<hsize_t>(values.n_species()), n_y, n_x});
  const hdf5::Handle space(H5Dget_space(dataset), H5Sclose, name);
  const hdf5::Handle memory = hdf5::simple_space({1, n_y, n_x});
  const hsize_t count[3] = {1, n_y, n_x};
  std::vector<double> block(n_x * n_y);
  for (int s = 0; s < values.n_species(); ++s) {
    for (int j = 0; j < values.n_y(); ++j) {
      std::memcpy(block.data() + static_cast<std::size_t>(j) * n_x, values.row(s, j), n_x * sizeof(double));
    }
    const hsize_t offset[3] = {static_cast<hsize_t>(s), 0, 0};
    hdf5::check(H5Sselect_hyperslab(space, H5S_SELECT_SET, offset, nullptr, count, nullptr), name);
    hdf5::check(H5Dwrite(dataset, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, block.data()), fmt::format("cannot store '{}'", name));
  }
}

void SavingVisitor::cells(const std::string& name, std::vector<double>& values) {
  claim(name);
  const auto n_x = static_cast<std::size_t>(decomposition_->n_x());
  const auto n_y = static_cast<std::size_t>(decomposition_->n_y());
  if (values.size() != n_x * n_y) {
    throw Error(ErrorKind::bug, fmt::format("'{}' holds {} numbers for {} cells", name, values.size(), n_x * n_y));
  }
  manifest_->cells.push_back(name);
  const hdf5::Handle dataset = create(file_, cells_path(name), {1, n_y, n_x});
  hdf5::check(H5Dwrite(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), fmt::format("cannot store '{}'", name));
}

std::string SavingVisitor::image() {
  hdf5::check(H5Fflush(file_, H5F_SCOPE_GLOBAL), "HDF5 file in memory");
  const ssize_t size = hdf5::check(H5Fget_file_image(file_, nullptr, 0), "HDF5 file in memory");
  std::string image(static_cast<std::size_t>(size), '\0');
  hdf5::check(H5Fget_file_image(file_, image.data(), image.size()), "HDF5 file in memory");
  file_.close("HDF5 file in memory");
  return image;
}

LoadingVisitor::LoadingVisitor(const Decomposition& decomposition, const Manifest& manifest, std::string path)
    : decomposition_(&decomposition), manifest_(&manifest), path_(std::move(path)) {}

void LoadingVisitor::lacks(const std::string& name) const {
  throw Error(ErrorKind::input,
              fmt::format("{}: holds no '{}': it was written by another method or version and cannot be continued here", path_, name));
}

void LoadingVisitor::numbers(const std::string& name, std::vector<double>& values) {
  const auto found = manifest_->numbers.find(name);
  if (found == manifest_->numbers.end()) lacks(name);
  asked_.insert(name);
  values = found->second;
}

template <class Row>
void LoadingVisitor::read(const std::string& name, int layers, Row&& row) {
  const auto mine = decomposition_->box_of(decomposition_->comm().rank());
  for (std::size_t n = 0; n < manifest_->shards.size(); ++n) {
    const auto& box = manifest_->shards[n].box;
    std::int64_t from[2], to[2];
    for (std::size_t d = 0; d < 2; ++d) {
      from[d] = std::max(mine[d], box[d]);
      to[d] = std::min(mine[d] + mine[d + 2], box[d] + box[d + 2]);
    }
    if (from[0] >= to[0] || from[1] >= to[1]) continue;
    const std::string path = (std::filesystem::path(path_) / shard_name(n)).string();
    const hdf5::Handle file = hdf5::open_file(path);
    const hdf5::Handle dataset(H5Dopen2(file, name.c_str(), H5P_DEFAULT), H5Dclose, fmt::format("{}: no '{}'", path, name));
    const std::vector<hsize_t> expected{static_cast<hsize_t>(layers), static_cast<hsize_t>(box[3]), static_cast<hsize_t>(box[2])};
    if (hdf5::extent_of(dataset) != expected)
      throw Error(ErrorKind::input, fmt::format("{}: '{}' has another shape than in this run", path, name));
    const auto n_x = static_cast<hsize_t>(to[0] - from[0]);
    const auto n_y = static_cast<hsize_t>(to[1] - from[1]);
    const hdf5::Handle space(H5Dget_space(dataset), H5Sclose, path);
    const hdf5::Handle memory = hdf5::simple_space({1, n_y, n_x});
    const hsize_t count[3] = {1, n_y, n_x};
    std::vector<double> block(n_x * n_y);
    for (int layer = 0; layer < layers; ++layer) {
      const hsize_t offset[3] = {static_cast<hsize_t>(layer), static_cast<hsize_t>(from[1] - box[1]),
                                 static_cast<hsize_t>(from[0] - box[0])};
      hdf5::check(H5Sselect_hyperslab(space, H5S_SELECT_SET, offset, nullptr, count, nullptr), path);
      hdf5::check(H5Dread(dataset, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, block.data()),
                  fmt::format("{}: cannot read '{}'", path, name));
      for (hsize_t j = 0; j < n_y; ++j) {
        double* start = row(layer, static_cast<int>(from[1] - mine[1]) + static_cast<int>(j)) + (from[0] - mine[0]);
        std::memcpy(start, block.data() + j * n_x, n_x * sizeof(double));
      }
    }
  }
}

void LoadingVisitor::field(const std::string& name, Field& values) {
  if (!contains(manifest_->fields, name)) lacks(name);
  asked_.insert(name);
  read(field_path(name), values.n_species(), [&](int s, int j) { return values.row(s, j); });
}

void LoadingVisitor::cells(const std::string& name, std::vector<double>& values) {
  if (!contains(manifest_->cells, name)) lacks(name);
  asked_.insert(name);
  const int n_x = decomposition_->n_x();
  values.assign(static_cast<std::size_t>(n_x) * static_cast<std::size_t>(decomposition_->n_y()), 0.0);
  read(cells_path(name), 1, [&](int, int j) { return values.data() + static_cast<std::ptrdiff_t>(j) * n_x; });
}

void LoadingVisitor::require_all_asked_for() const {
  const auto require = [&](const std::string& name) {
    if (asked_.contains(name)) return;
    throw Error(ErrorKind::input,
                fmt::format("{}: holds '{}', which this run has no use for: it was written by another method or version", path_, name));
  };
  for (const auto& entry : manifest_->numbers) require(entry.first);
  for (const std::string& name : manifest_->fields) require(name);
  for (const std::string& name : manifest_->cells) require(name);
}

}  // namespace stiffront
