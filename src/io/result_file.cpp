// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/io/result_file.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <optional>

#include "file.hpp"
#include "hdf5.hpp"
#include "seal.hpp"
#include "stiffront/core/agree.hpp"
#include "stiffront/core/error.hpp"
#include "stiffront/core/version.hpp"

namespace stiffront {
namespace {

bool abort_needed = false;

const char* name_of(BoundaryKind kind) {
  switch (kind) {
    case BoundaryKind::periodic:
      return "periodic";
    case BoundaryKind::dirichlet:
      return "dirichlet";
    default:
      return "neumann";
  }
}

std::vector<double> positions(const Grid& grid, int direction) {
  std::vector<double> x(static_cast<std::size_t>(grid.uniform_points(direction)));
  for (std::size_t i = 0; i < x.size(); ++i)
    x[i] = grid.position(direction, grid.index_of_uniform(direction, static_cast<std::int64_t>(i)));
  return x;
}

/// The points of a rank's part that belong to the uniform grid, by local index: the first and the last of a part always do.
std::vector<int> uniform(const Grid& grid, int direction, std::int64_t offset, int n) {
  std::vector<int> points;
  for (int i = 0; i < n; ++i) {
    if (!grid.is_sub_cell(direction, offset + i)) points.push_back(i);
  }
  return points;
}

void write_attributes(hid_t file, const StateHeader& header, const Boundary& boundary, const Grid& grid) {
  const auto n = static_cast<std::ptrdiff_t>(grid.dimension);
  hdf5::write_attribute(file, "time", header.time);
  hdf5::write_attribute(file, "step", header.step);
  hdf5::write_attribute(file, "interpolated", std::int64_t{header.interpolated ? 1 : 0});
  hdf5::write_attribute(file, "species", header.species);
  hdf5::write_attribute(file, "dimension", std::int64_t{grid.dimension});
  std::vector<std::int64_t> points;
  for (int d = 0; d < grid.dimension; ++d) points.push_back(grid.uniform_points(d));
  hdf5::write_attribute(file, "points", points);
  hdf5::write_attribute(file, "lower", std::vector<double>(grid.lower.begin(), grid.lower.begin() + n));
  hdf5::write_attribute(file, "upper", std::vector<double>(grid.upper.begin(), grid.upper.begin() + n));
  std::vector<std::int64_t> periodic;
  std::vector<std::string> sides;
  for (int d = 0; d < grid.dimension; ++d) {
    periodic.push_back(grid.periodic[static_cast<std::size_t>(d)] ? 1 : 0);
    for (int which = 0; which < 2; ++which) sides.emplace_back(name_of(boundary.side(d, which).kind));
  }
  hdf5::write_attribute(file, "periodic", periodic);
  hdf5::write_attribute(file, "boundary", sides);
  hdf5::write_attribute(file, "version", std::string(version::number));
  hdf5::write_attribute(file, "git_hash", std::string(version::git_hash));
  hdf5::write_attribute(file, "case", header.case_text);
}

/// Writes this rank's part of a dataset; every rank takes part, some perhaps with nothing to write.
/// @return where its values are in the file
seal::Extent write_part(hid_t file, const std::string& name, const std::vector<hsize_t>& extent, const std::vector<hsize_t>& offset,
                        const std::vector<hsize_t>& count, const double* values, bool takes_part) {
  const std::string what = fmt::format("cannot write the dataset '{}'", name);
  const hdf5::Handle space = hdf5::simple_space(extent);
  hdf5::Handle dataset(H5Dcreate2(file, name.c_str(), H5T_IEEE_F64LE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Dclose, what);
  const hdf5::Handle memory = hdf5::simple_space(count);
  if (takes_part) {
    hdf5::check(H5Sselect_hyperslab(space, H5S_SELECT_SET, offset.data(), nullptr, count.data(), nullptr), what);
  } else {
    hdf5::check(H5Sselect_none(space), what);
    hdf5::check(H5Sselect_none(memory), what);
  }
  const hdf5::Handle transfer(H5Pcreate(H5P_DATASET_XFER), H5Pclose, what);
  hdf5::check(H5Pset_dxpl_mpio(transfer, H5FD_MPIO_COLLECTIVE), what);
  hdf5::check(H5Dwrite(dataset, H5T_NATIVE_DOUBLE, memory, space, transfer, values), what);
  std::int64_t size = sizeof(double);
  for (hsize_t n : extent) size *= static_cast<std::int64_t>(n);
  const haddr_t begin = H5Dget_offset(dataset);
  dataset.close(what);
  return begin == HADDR_UNDEF ? seal::Extent{} : seal::Extent{static_cast<std::int64_t>(begin), size};
}

/// Does one thing after the other even if some fail, because the other ranks take part in each; throws the first failure at the end.
class Sequence {
 public:
  template <class F>
  void then(F&& f) {
    try {
      f();
    } catch (const Error& e) {
      if (!first_) first_ = e;
    }
  }
  void end() const {
    if (first_) throw Error(*first_);
  }

 private:
  std::optional<Error> first_;
};

/// @param values gets the places of the values in the file
void write_content(hid_t file, const StateHeader& header, const Boundary& boundary, const Field& u, std::vector<seal::Extent>& values) {
  const Decomposition& d = u.decomposition();
  const Grid& grid = d.grid();
  Sequence sequence;
  sequence.then([&] { write_attributes(file, header, boundary, grid); });

  const char* axes[2] = {"x", "y"};
  for (int direction = 0; direction < grid.dimension; ++direction) {
    const std::vector<double> x = positions(grid, direction);
    sequence.then([&] { values.push_back(write_part(file, axes[direction], {x.size()}, {0}, {x.size()}, x.data(), u.comm().is_root())); });
  }

  const std::vector<int> columns = uniform(grid, 0, d.offset_x(), d.n_x());
  const std::vector<int> rows = uniform(grid, 1, d.offset_y(), d.n_y());
  std::vector<hsize_t> extent, offset, count;
  if (grid.dimension == 2) {
    extent.push_back(static_cast<hsize_t>(grid.uniform_points(1)));
    offset.push_back(static_cast<hsize_t>(grid.uniform_index(1, d.offset_y() + rows.front())));
    count.push_back(rows.size());
  }
  extent.push_back(static_cast<hsize_t>(grid.uniform_points(0)));
  offset.push_back(static_cast<hsize_t>(grid.uniform_index(0, d.offset_x() + columns.front())));
  count.push_back(columns.size());
  std::vector<double> block;
  block.reserve(columns.size() * rows.size());
  for (int s = 0; s < u.n_species(); ++s) {
    block.clear();
    for (int j : rows) {
      for (int i : columns) block.push_back(u.at(s, i, j));
    }
    sequence.then([&] {
      values.push_back(write_part(file, header.species[static_cast<std::size_t>(s)], extent, offset, count, block.data(), true));
    });
  }
  sequence.end();
}

}  // namespace

bool must_end_by_abort() { return abort_needed; }

void write_state(const std::string& path, const StateHeader& header, const Boundary& boundary, const Field& u) {
  if (header.species.size() != static_cast<std::size_t>(u.n_species())) {
    throw Error(ErrorKind::bug, "a state was to be written with another number of species names than it has species");
  }
  for (const std::string& name : header.species) {
    if (name == "x" || name == "y") {
      throw Error(ErrorKind::input, fmt::format("model.species: '{}' is the name of a coordinate; call the species otherwise", name));
    }
  }
  const Communicator& comm = u.comm();
  const Grid& grid = u.decomposition().grid();
  const std::string temporary = path + ".tmp";
  hdf5::silence();

  collectively(comm, [&] {
    if (!comm.is_root()) return;
    const auto doubles = static_cast<long long>(grid.total_points() * u.n_species() + grid.points[0] + grid.points[1]);
    file::reserve(temporary, doubles * static_cast<long long>(sizeof(double)) + static_cast<long long>(header.case_text.size()) + 65536);
  });
  try {
    hdf5::Handle file;
    std::vector<seal::Extent> values;
    collectively(comm, [&] {
      const hdf5::Handle access = hdf5::file_access();
      hdf5::check(H5Pset_fapl_mpio(access, comm.get(), MPI_INFO_NULL), "parallel HDF5");
      const hdf5::Handle creation(H5Pcreate(H5P_FILE_CREATE), H5Pclose, "HDF5 property list");
      hdf5::check(H5Pset_userblock(creation, seal::block_size), "HDF5 user block");
      file =
          hdf5::Handle(H5Fcreate(temporary.c_str(), H5F_ACC_TRUNC, creation, access), H5Fclose, fmt::format("{}: cannot be created", path));
    });
    collectively(comm, [&] {
      Sequence sequence;
      sequence.then([&] { write_content(file, header, boundary, u, values); });
      // What cannot be written may come to light only now. A file that cannot be closed is left to the library's own end, which
      // does not survive it.
      sequence.then([&] {
        try {
          file.close("cannot be completed");
        } catch (const Error&) {
          abort_needed = true;
          throw;
        }
      });
      try {
        sequence.end();
      } catch (const Error& e) {
        throw Error(ErrorKind::io, fmt::format("{}: {}", path, e.what()));
      }
    });
    collectively(comm, [&] {
      if (!comm.is_root()) return;
      seal::put(temporary, values);
      file::sync(temporary);
      file::rename(temporary, path);
    });
  } catch (...) {
    abort_needed = comm.max(std::int64_t{abort_needed ? 1 : 0}) != 0;
    if (comm.is_root()) {
      std::error_code ignored;
      std::filesystem::remove(temporary, ignored);
    }
    throw;
  }
}

}  // namespace stiffront
