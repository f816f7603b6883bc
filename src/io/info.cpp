// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/io/info.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "hdf5.hpp"
#include "stiffront/core/error.hpp"
#include "stiffront/io/result_file.hpp"

namespace stiffront {
namespace {

/// Range and mean of a dataset, read in pieces of whole rows so that a large one needs no memory of its size.
std::string statistics(hid_t file, const std::string& name) {
  const hdf5::Handle dataset(H5Dopen2(file, name.c_str(), H5P_DEFAULT), H5Dclose, name);
  const std::vector<hsize_t> extent = hdf5::extent_of(dataset);
  const hdf5::Handle type(H5Dget_type(dataset), H5Tclose, name);
  if (extent.empty() || H5Tget_class(type) != H5T_FLOAT) return "no array of numbers";
  hsize_t row = 1;
  for (std::size_t d = 1; d < extent.size(); ++d) row *= extent[d];
  const hsize_t rows_at_once = std::max<hsize_t>(1, (hsize_t{1} << 20) / std::max<hsize_t>(row, 1));
  double lowest = std::numeric_limits<double>::infinity();
  double highest = -lowest;
  double sum = 0.0;
  std::int64_t finite = 0, other = 0;
  std::vector<double> values;
  for (hsize_t first = 0; first < extent[0]; first += rows_at_once) {
    std::vector<hsize_t> offset(extent.size(), 0), count = extent;
    offset[0] = first;
    count[0] = std::min(rows_at_once, extent[0] - first);
    const hdf5::Handle space(H5Dget_space(dataset), H5Sclose, name);
    hdf5::check(H5Sselect_hyperslab(space, H5S_SELECT_SET, offset.data(), nullptr, count.data(), nullptr), name);
    const hdf5::Handle memory = hdf5::simple_space(count);
    values.resize(count[0] * row);
    hdf5::check(H5Dread(dataset, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, values.data()),
                fmt::format("cannot read the dataset '{}'", name));
    for (double v : values) {
      if (!std::isfinite(v)) {
        ++other;
        continue;
      }
      ++finite;
      lowest = std::min(lowest, v);
      highest = std::max(highest, v);
      sum += v;
    }
  }
  std::string text = fmt::format("[{}] ", fmt::join(extent, "]["));
  text += finite > 0 ? fmt::format("min {:.6g}, max {:.6g}, mean {:.6g}", lowest, highest, sum / static_cast<double>(finite)) : "";
  if (other > 0) text += fmt::format("{}{} values are not finite", finite > 0 ? "; " : "", other);
  return text;
}

std::string describe_state(hid_t file, const std::string& path) {
  const StateHeader header = read_header(path);
  const std::vector<std::int64_t> points = hdf5::read_integers(file, "points");
  const std::vector<double> lower = hdf5::read_numbers(file, "lower");
  const std::vector<double> upper = hdf5::read_numbers(file, "upper");
  const std::vector<std::string> sides = hdf5::read_texts(file, "boundary");
  std::string text = fmt::format("{}: a state\n  time      {}\n  step      {}{}\n", path, header.time, header.step,
                                 header.interpolated ? " (interpolated within it)" : "");
  text += fmt::format("  grid      {} points\n", fmt::join(points, " x "));
  for (std::size_t d = 0; d < points.size(); ++d) {
    text +=
        fmt::format("  {}         [{}, {}], {} / {}\n", d == 0 ? "x" : "y", lower.at(d), upper.at(d), sides.at(2 * d), sides.at(2 * d + 1));
  }
  text += fmt::format("  version   {} ({})\n", hdf5::read_text(file, "version"), hdf5::read_text(file, "git_hash"));
  for (const std::string& s : header.species) text += fmt::format("  {:<9} {}\n", s, statistics(file, s));
  if (!header.case_text.empty()) text += "case:\n" + header.case_text;
  if (text.back() != '\n') text += '\n';
  return text;
}

herr_t add_name(hid_t, const char* name, const H5L_info_t*, void* names) {
  static_cast<std::vector<std::string>*>(names)->emplace_back(name);
  return 0;
}

herr_t add_attribute(hid_t, const char* name, const H5A_info_t*, void* names) {
  static_cast<std::vector<std::string>*>(names)->emplace_back(name);
  return 0;
}

/// One line per dataset below a group; `prefix` is empty or ends with a slash.
std::string describe_group(hid_t file, const std::string& prefix) {
  constexpr std::size_t longest = 1000;  // groups may contain themselves
  if (prefix.size() > longest) throw Error(ErrorKind::io, "its groups are nested too deeply");
  const hdf5::Handle group(H5Gopen2(file, prefix.empty() ? "/" : prefix.c_str(), H5P_DEFAULT), H5Gclose, prefix);
  std::vector<std::string> names;
  hdf5::check(H5Literate(group, H5_INDEX_NAME, H5_ITER_INC, nullptr, &add_name, &names), prefix);
  std::string text;
  for (const std::string& name : names) {
    const std::string path = prefix + name;
    text += hdf5::has_dataset(file, path) ? fmt::format("  {:<9} {}\n", path, statistics(file, path)) : describe_group(file, path + "/");
  }
  return text;
}

std::string describe_checkpoint(hid_t file, const std::string& path) {
  const std::vector<std::int64_t> box = hdf5::read_integers(file, "box");
  std::string text = fmt::format("{}: one rank's part of a checkpoint (see manifest.json beside it)\n", path);
  text += fmt::format("  time      {}\n  step      {}\n", hdf5::read_numbers(file, "time").at(0), hdf5::read_integers(file, "step").at(0));
  text += fmt::format("  box       {} x {} points from ({}, {})\n", box.at(2), box.at(3), box.at(0), box.at(1));
  return text + describe_group(file, "");
}

std::string describe_any(hid_t file, const std::string& path) {
  std::vector<std::string> attributes;
  hdf5::check(H5Aiterate2(file, H5_INDEX_NAME, H5_ITER_INC, nullptr, &add_attribute, &attributes), path);
  std::string text = fmt::format("{}: an HDF5 file, but no result of this program\n", path) + describe_group(file, "");
  if (!attributes.empty()) text += fmt::format("  attributes: {}\n", fmt::join(attributes, ", "));
  return text;
}

}  // namespace

std::string describe_file(const std::string& path) {
  const hdf5::Handle file = hdf5::open_file(path);
  try {
    if (hdf5::has_attribute(file, "species") && hdf5::has_attribute(file, "boundary")) return describe_state(file, path);
    if (hdf5::has_attribute(file, "format") && hdf5::read_text(file, "format") == "stiffront-checkpoint") {
      return describe_checkpoint(file, path);
    }
    return describe_any(file, path);
  } catch (const Error& e) {
    const std::string message = e.what();
    throw Error(e.kind(), message.starts_with(path) ? message : fmt::format("{}: {}", path, message));
  } catch (const std::exception& e) {  // an attribute of another length, a size beyond all memory
    throw Error(ErrorKind::io, fmt::format("{}: the file is damaged ({})", path, e.what()));
  }
}

}  // namespace stiffront
