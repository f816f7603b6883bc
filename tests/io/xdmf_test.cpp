// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/io/xdmf.hpp"

#include <gtest/gtest.h>
#include <hdf5.h>

#include <sstream>
#include <vector>

#include "stiffront/io/result_file.hpp"
#include "support/diffusion_problem.hpp"
#include "support/temporary_folder.hpp"

namespace stiffront {
namespace {

/// A document taken apart just far enough: tags must nest; data items are kept with their attributes and text.
struct Item {
  std::string attributes;
  std::string text;
};
struct Document {
  std::vector<Item> items;
  std::vector<double> times;
};

std::string attribute(const std::string& attributes, const std::string& name) {
  const std::size_t begin = attributes.find(" " + name + "=\"");
  if (begin == std::string::npos) return "";
  const std::size_t value = begin + name.size() + 3;
  return attributes.substr(value, attributes.find('"', value) - value);
}

Document parse(const std::string& xml) {
  Document d;
  std::vector<std::string> open;
  for (std::size_t at = xml.find('<'); at != std::string::npos; at = xml.find('<', at + 1)) {
    const std::size_t end = xml.find('>', at);
    if (end == std::string::npos) {
      ADD_FAILURE() << "a tag does not end";
      return d;
    }
    const std::string tag = xml.substr(at + 1, end - at - 1);
    if (tag[0] == '?' || tag[0] == '!') continue;
    const std::string name = tag.substr(tag[0] == '/', tag.find_first_of(" /", 1) - (tag[0] == '/'));
    if (tag[0] == '/') {
      if (open.empty() || open.back() != tag.substr(1)) ADD_FAILURE() << "</" << tag << " does not match";
      if (!open.empty()) open.pop_back();
      continue;
    }
    if (name == "Time") d.times.push_back(std::stod(attribute(tag, "Value")));
    if (tag.back() == '/') continue;
    if (name == "DataItem") d.items.push_back({tag, xml.substr(end + 1, xml.find('<', end) - end - 1)});
    open.push_back(name);
  }
  EXPECT_TRUE(open.empty());
  return d;
}

std::vector<hsize_t> extent_in_file(const std::string& path, const std::string& name) {
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  if (file < 0) return {};
  const hid_t dataset = H5Dopen2(file, name.c_str(), H5P_DEFAULT);
  std::vector<hsize_t> extent;
  if (dataset >= 0) {
    const hid_t space = H5Dget_space(dataset);
    extent.resize(static_cast<std::size_t>(H5Sget_simple_extent_ndims(space)));
    H5Sget_simple_extent_dims(space, extent.data(), nullptr);
    H5Sclose(space);
    H5Dclose(dataset);
  }
  H5Fclose(file);
  return extent;
}

class XdmfTest : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(InDimensions, XdmfTest, ::testing::Values(1, 2));

TEST_P(XdmfTest, EveryReferencedDatasetExistsWithTheShapeGivenAndTimesIncrease) {
  const Communicator comm(MPI_COMM_SELF);
  testing::TemporaryFolder folder(comm);
  const Grid grid = testing::unit_grid(11, GetParam() == 1 ? 1 : 6);
  ASSERT_EQ(grid.dimension, GetParam());
  testing::DiffusionProblem problem(
      comm, grid, {testing::both_sides(BoundaryKind::neumann, 2), testing::both_sides(BoundaryKind::neumann, 2)}, {1.0, 1.0}, 2);
  const Field u = problem.field([](int s, double x, double) { return s + x; });
  const std::vector<std::string> species{"a", "b<c"};  // a name that XML would misread
  XdmfSeries series(folder.file("fields.xdmf"), grid, species);
  const std::vector<std::pair<double, std::string>> states{
      {0.5, "fields-000002.h5"}, {0.0, "fields-000000.h5"}, {0.25, "fields-000002-1.h5"}};
  for (const auto& [t, name] : states) {
    write_state(folder.file(name), {t, 0, false, species, ""}, problem.boundary, u);
    series.add(t, name);
    series.add(t, name);  // written again by a continued run
  }
  series.write();

  const Document d = parse(testing::content_of(folder.file("fields.xdmf")));
  EXPECT_EQ(d.times, (std::vector<double>{0.0, 0.25, 0.5}));
  int references = 0;
  for (const Item& item : d.items) {
    if (attribute(item.attributes, "Format") != "HDF") continue;
    ++references;
    const std::size_t colon = item.text.find(":/");
    ASSERT_NE(colon, std::string::npos) << item.text;
    std::string name = item.text.substr(colon + 1);
    if (const std::size_t lt = name.find("&lt;"); lt != std::string::npos) name.replace(lt, 4, "<");
    // One layer, in 1-D of one row: leading ones that the dataset does not have.
    std::vector<hsize_t> expected(static_cast<std::size_t>(3 - GetParam()), 1);
    for (hsize_t n : extent_in_file(folder.file(item.text.substr(0, colon)), name)) expected.push_back(n);
    std::vector<hsize_t> given;
    std::istringstream dimensions(attribute(item.attributes, "Dimensions"));
    for (hsize_t n; dimensions >> n;) given.push_back(n);
    EXPECT_EQ(given, expected) << item.text;
  }
  EXPECT_EQ(references, 3 * 2);
  // Origin and spacing, slowest direction first.
  std::vector<double> numbers;
  for (const Item& item : d.items) {
    std::istringstream text(item.text);
    if (attribute(item.attributes, "Format") == "XML" && numbers.size() < 6) {
      for (double x; text >> x;) numbers.push_back(x);
    }
  }
  EXPECT_EQ(numbers,
            (std::vector<double>{0.0, grid.lower[1], grid.lower[0], 1.0, GetParam() == 2 ? grid.spacing(1) : 1.0, grid.spacing(0)}));
}

}  // namespace
}  // namespace stiffront
