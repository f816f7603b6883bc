// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "hdf5.hpp"
#include "stiffront/core/agree.hpp"
#include "stiffront/core/error.hpp"
#include "stiffront/io/result_file.hpp"

namespace stiffront {
namespace {

/// The points of the file's grid from which one point of ours is interpolated, in one direction.
struct Stencil {
  std::int64_t first = 0;  ///< index in the file's grid; may be outside 0..n-1 where that is periodic
  int count = 1;           ///< 1..4, and up to 10 for grids with sub-cells, whose differences are of order eight
  std::array<double, 10> weight{1.0};
};

/// Lagrange weights of `count` points at 0, 1, .. for the place s.
std::array<double, 10> lagrange(int count, double s) {
  std::array<double, 10> w{};
  for (int k = 0; k < count; ++k) {
    double product = 1.0;
    for (int m = 0; m < count; ++m) {
      if (m != k) product *= (s - m) / (k - m);
    }
    w[static_cast<std::size_t>(k)] = product;
  }
  return w;
}

std::int64_t intervals(const Grid& grid, std::size_t d) { return grid.intervals(static_cast<int>(d)); }

/// Distance of point i from the lower end in fifths of a spacing, of which a sub-cell is one.
std::int64_t fifths(const Grid& grid, std::size_t d, std::int64_t i) {
  static_assert(5.0 * Grid::sub_cell_place == 1.0);
  const int direction = static_cast<int>(d);
  if (!grid.is_sub_cell(direction, i)) return 5 * grid.uniform_index(direction, i);
  return i == 1 ? 1 : 5 * intervals(grid, d) - 1;
}

/// The stencil of point i of `to` in the grid `from` over the same domain: its place is a fraction of whole numbers, exactly.
Stencil stencil(const Grid& from, const Grid& to, std::size_t d, std::int64_t i) {
  const std::int64_t whole = fifths(to, d, i) * intervals(from, d);
  const std::int64_t unit = 5 * intervals(to, d);
  const std::int64_t base = whole / unit;
  const std::int64_t rest = whole % unit;
  Stencil r;
  r.first = base;
  if (rest == 0) {
    // The last point of a grid with end point, in a periodic one, is the first again.
    return r;
  }
  const std::int64_t n = from.points[d];
  r.count = static_cast<int>(std::min<std::int64_t>(to.has_sub_cells(static_cast<int>(d)) ? 10 : 4, n));
  r.first = base - (r.count - 1) / 2;
  if (!from.periodic[d]) r.first = std::clamp<std::int64_t>(r.first, 0, n - r.count);
  const double s = static_cast<double>(base - r.first) + static_cast<double>(rest) / static_cast<double>(unit);
  r.weight = lagrange(r.count, s);
  return r;
}

/// One run of consecutive points of the file's grid and where it goes in the block that was read.
struct Run {
  std::int64_t from;
  std::int64_t to;
  std::int64_t count;
};

/// Points first .. first+count-1 of a periodic line of n points, as runs within 0..n-1.
std::vector<Run> runs(std::int64_t first, std::int64_t count, std::int64_t n) {
  std::vector<Run> r;
  for (std::int64_t done = 0; done < count;) {
    const std::int64_t from = ((first + done) % n + n) % n;
    const std::int64_t length = std::min(count - done, n - from);
    r.push_back({from, done, length});
    done += length;
  }
  return r;
}

/// All points of the file that this rank needs in one direction, and the stencils into them.
struct Line {
  std::int64_t first;
  std::int64_t count;
  std::int64_t n;
  std::vector<Stencil> stencils;
};

Line line(const Grid& from, const Grid& to, std::size_t d, std::int64_t offset, int size) {
  Line r{0, 1, from.points[d], {}};
  std::int64_t last = 0;
  for (int i = 0; i < size; ++i) {
    r.stencils.push_back(stencil(from, to, d, offset + i));
    const Stencil& s = r.stencils.back();
    r.first = i == 0 ? s.first : std::min(r.first, s.first);
    last = i == 0 ? s.first + s.count - 1 : std::max(last, s.first + s.count - 1);
  }
  r.count = last - r.first + 1;
  return r;
}

std::vector<double> read_block(hid_t dataset, const Line& x, const Line& y, int dimension) {
  std::vector<double> block(static_cast<std::size_t>(x.count * y.count));
  const char* what = "cannot read the values";
  for (const Run& row : runs(y.first, y.count, y.n)) {
    for (const Run& column : runs(x.first, x.count, x.n)) {
      const hdf5::Handle space(H5Dget_space(dataset), H5Sclose, what);
      const hdf5::Handle memory = hdf5::simple_space({static_cast<hsize_t>(y.count), static_cast<hsize_t>(x.count)});
      const std::array<hsize_t, 2> from{static_cast<hsize_t>(row.from), static_cast<hsize_t>(column.from)};
      const std::array<hsize_t, 2> to{static_cast<hsize_t>(row.to), static_cast<hsize_t>(column.to)};
      const std::array<hsize_t, 2> count{static_cast<hsize_t>(row.count), static_cast<hsize_t>(column.count)};
      const std::size_t skip = dimension == 2 ? 0 : 1;
      hdf5::check(H5Sselect_hyperslab(space, H5S_SELECT_SET, from.data() + skip, nullptr, count.data() + skip, nullptr), what);
      hdf5::check(H5Sselect_hyperslab(memory, H5S_SELECT_SET, to.data(), nullptr, count.data(), nullptr), what);
      hdf5::check(H5Dread(dataset, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, block.data()), what);
    }
  }
  return block;
}

void interpolate(const std::vector<double>& block, const Line& x, const Line& y, int species, Field& u) {
  for (int j = 0; j < u.n_y(); ++j) {
    const Stencil& sy = y.stencils[static_cast<std::size_t>(j)];
    for (int i = 0; i < u.n_x(); ++i) {
      const Stencil& sx = x.stencils[static_cast<std::size_t>(i)];
      const double* corner = block.data() + (sy.first - y.first) * x.count + (sx.first - x.first);
      if (sx.count == 1 && sy.count == 1) {
        u.at(species, i, j) = *corner;
        continue;
      }
      double sum = 0.0;
      bool negative = false;
      for (int l = 0; l < sy.count; ++l) {
        double row = 0.0;
        for (int k = 0; k < sx.count; ++k) {
          const double value = corner[l * x.count + k];
          negative = negative || value < 0.0;
          row += sx.weight[static_cast<std::size_t>(k)] * value;
        }
        sum += sy.weight[static_cast<std::size_t>(l)] * row;
      }
      u.at(species, i, j) = sum < 0.0 && !negative ? 0.0 : sum;
    }
  }
}

Grid read_grid(hid_t file) {
  Grid grid;
  const std::vector<std::int64_t> points = hdf5::read_integers(file, "points");
  const std::vector<double> lower = hdf5::read_numbers(file, "lower");
  const std::vector<double> upper = hdf5::read_numbers(file, "upper");
  const std::vector<std::int64_t> periodic = hdf5::read_integers(file, "periodic");
  const std::size_t n = points.size();
  if (n < 1 || n > 2 || lower.size() != n || upper.size() != n || periodic.size() != n) {
    throw Error(ErrorKind::io, "its grid attributes do not fit together");
  }
  grid.dimension = static_cast<int>(n);
  for (std::size_t d = 0; d < n; ++d) {
    grid.points[d] = points[d];
    grid.lower[d] = lower[d];
    grid.upper[d] = upper[d];
    grid.periodic[d] = periodic[d] != 0;
    if (intervals(grid, d) < 1) throw Error(ErrorKind::io, "its grid has no extent");
  }
  return grid;
}

std::string size_of(const Grid& grid) {
  return grid.dimension == 1 ? fmt::format("{}", grid.uniform_points(0))
                             : fmt::format("{} x {}", grid.uniform_points(0), grid.uniform_points(1));
}

/// Whether two grids cover one domain up to round-off; a periodic grid's missing end point does not matter.
void require_same_domain(const Grid& from, const Grid& to) {
  if (from.dimension != to.dimension) {
    throw Error(ErrorKind::input,
                fmt::format("holds a state in {} dimension{}, not {}", from.dimension, from.dimension == 1 ? "" : "s", to.dimension));
  }
  for (std::size_t d = 0; d < static_cast<std::size_t>(to.dimension); ++d) {
    const double tiny = 1e-12 * (to.upper[d] - to.lower[d]);
    if (std::abs(from.lower[d] - to.lower[d]) <= tiny && std::abs(from.upper[d] - to.upper[d]) <= tiny) continue;
    throw Error(ErrorKind::input, fmt::format("holds a state on [{}, {}] in {}, not on [{}, {}]", from.lower[d], from.upper[d],
                                              d == 0 ? "x" : "y", to.lower[d], to.upper[d]));
  }
}

bool same_points(const Grid& a, const Grid& b) {
  for (std::size_t d = 0; d < static_cast<std::size_t>(a.dimension); ++d) {
    if (a.uniform_points(static_cast<int>(d)) != b.uniform_points(static_cast<int>(d)) || a.periodic[d] != b.periodic[d]) return false;
  }
  return true;
}

StateHeader header_of(hid_t file) {
  StateHeader header;
  header.time = hdf5::read_numbers(file, "time").at(0);
  header.step = hdf5::read_integers(file, "step").at(0);
  header.interpolated = hdf5::has_attribute(file, "interpolated") && hdf5::read_integers(file, "interpolated").at(0) != 0;
  header.species = hdf5::read_texts(file, "species");
  header.case_text = hdf5::has_attribute(file, "case") ? hdf5::read_text(file, "case") : std::string();
  return header;
}

/// Runs f and puts the file's name before the message of a failure.
template <class F>
auto naming(const std::string& path, F&& f) {
  try {
    return f();
  } catch (const Error& e) {
    const std::string text = e.what();
    throw Error(e.kind(), text.starts_with(path) ? text : fmt::format("{}: {}", path, text));
  } catch (const std::exception& e) {  // an attribute of another length, a size beyond all memory
    throw Error(ErrorKind::io, fmt::format("{}: the file is damaged ({})", path, e.what()));
  }
}

}  // namespace

StateHeader read_header(const std::string& path) {
  return naming(path, [&] { return header_of(hdf5::open_file(path)); });
}

StateSource read_state(const std::string& path, const std::vector<std::string>& species, Field& u) {
  StateSource source;
  const Decomposition& d = u.decomposition();
  const Grid& to = d.grid();
  const auto read = [&] {
    const hdf5::Handle file = hdf5::open_file(path);
    if (!hdf5::has_attribute(file, "species") || !hdf5::has_attribute(file, "points")) {
      throw Error(ErrorKind::io, "is no result file of this program (no attributes 'species' and 'points')");
    }
    const StateHeader header = header_of(file);
    const Grid from = read_grid(file);
    require_same_domain(from, to);
    const Line x = line(from, to, 0, d.offset_x(), d.n_x());
    const Line y = to.dimension == 2 ? line(from, to, 1, d.offset_y(), d.n_y()) : Line{0, 1, 1, {Stencil{}}};
    for (std::size_t s = 0; s < species.size(); ++s) {
      if (!hdf5::has_dataset(file, species[s])) {
        throw Error(ErrorKind::input, fmt::format("has no species '{}'; it holds {}", species[s], fmt::join(header.species, ", ")));
      }
      const hdf5::Handle dataset(H5Dopen2(file, species[s].c_str(), H5P_DEFAULT), H5Dclose, species[s]);
      const std::vector<hsize_t> expected =
          from.dimension == 1 ? std::vector<hsize_t>{static_cast<hsize_t>(from.points[0])}
                              : std::vector<hsize_t>{static_cast<hsize_t>(from.points[1]), static_cast<hsize_t>(from.points[0])};
      if (hdf5::extent_of(dataset) != expected) {
        throw Error(ErrorKind::io, fmt::format("the dataset '{}' has not the shape of the grid", species[s]));
      }
      interpolate(read_block(dataset, x, y, from.dimension), x, y, static_cast<int>(s), u);
    }
    source.time = header.time;
    source.step = header.step;
    source.interpolated = !same_points(from, to);
    source.note = source.interpolated
                      ? fmt::format("{}: state at t = {} interpolated from {} points to {}", path, header.time, size_of(from), size_of(to))
                      : fmt::format("{}: state at t = {} read as it is", path, header.time);
  };
  collectively(u.comm(), [&] { naming(path, read); });
  return source;
}

}  // namespace stiffront
