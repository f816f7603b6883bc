// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/io/xdmf.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "file.hpp"

namespace stiffront {
namespace {

std::string escaped(const std::string& text) {
  std::string r;
  for (char c : text) {
    switch (c) {
      case '&': r += "&amp;"; break;
      case '<': r += "&lt;"; break;
      case '>': r += "&gt;"; break;
      case '"': r += "&quot;"; break;
      default: r += c;
    }
  }
  return r;
}

std::string dataset(const std::string& extent, const std::string& file_name, const std::string& name) {
  return fmt::format("<DataItem Format=\"HDF\" NumberType=\"Float\" Precision=\"8\" Dimensions=\"{}\">{}:/{}</DataItem>", extent,
                     escaped(file_name), escaped(name));
}

}  // namespace

XdmfSeries::XdmfSeries(std::string path, const Grid& grid, std::vector<std::string> species)
    : path_(std::move(path)), grid_(grid), species_(std::move(species)) {}

void XdmfSeries::add(double time, const std::string& file_name) {
  std::erase_if(entries_, [&](const Entry& e) { return e.file_name == file_name; });
  const auto after = std::upper_bound(entries_.begin(), entries_.end(), time, [](double t, const Entry& e) { return t < e.time; });
  entries_.insert(after, {time, file_name});
}

std::string XdmfSeries::text() const {
  const bool plane = grid_.dimension == 2;
  const std::string n_x = fmt::format("{}", grid_.points[0]);
  const std::string n_y = fmt::format("{}", grid_.points[1]);
  const std::string extent = plane ? n_y + " " + n_x : n_x;
  std::string xml =
      "<?xml version=\"1.0\" ?>\n"
      "<!DOCTYPE Xdmf SYSTEM \"Xdmf.dtd\" []>\n"
      "<Xdmf Version=\"2.0\">\n"
      "  <Domain>\n";
  if (!plane) {
    // The second coordinate of the polyline's points, once for all states.
    xml += fmt::format("    <DataItem Name=\"zero\" Format=\"XML\" NumberType=\"Float\" Precision=\"8\" Dimensions=\"{}\">", n_x);
    for (std::int64_t i = 0; i < grid_.points[0]; ++i) xml += i % 60 == 59 ? "0\n" : "0 ";
    xml += "</DataItem>\n";
  }
  xml += "    <Grid Name=\"states\" GridType=\"Collection\" CollectionType=\"Temporal\">\n";
  for (const Entry& e : entries_) {
    xml += fmt::format("      <Grid Name=\"state\" GridType=\"Uniform\">\n        <Time Value=\"{}\" />\n", e.time);
    if (plane) {
      xml += fmt::format("        <Topology TopologyType=\"2DRectMesh\" Dimensions=\"{}\" />\n        <Geometry GeometryType=\"VXVY\">\n",
                         extent);
      xml += "          " + dataset(n_x, e.file_name, "x") + "\n          " + dataset(n_y, e.file_name, "y") + "\n";
    } else {
      xml += fmt::format("        <Topology TopologyType=\"Polyline\" NumberOfElements=\"1\" NodesPerElement=\"{}\" />\n", n_x);
      xml += "        <Geometry GeometryType=\"X_Y\">\n          " + dataset(n_x, e.file_name, "x") +
             "\n          <DataItem Reference=\"XML\">/Xdmf/Domain/DataItem[@Name=\"zero\"]</DataItem>\n";
    }
    xml += "        </Geometry>\n";
    for (const std::string& s : species_) {
      xml += fmt::format("        <Attribute Name=\"{}\" AttributeType=\"Scalar\" Center=\"Node\">\n          {}\n        </Attribute>\n",
                         escaped(s), dataset(extent, e.file_name, s));
    }
    xml += "      </Grid>\n";
  }
  xml += "    </Grid>\n  </Domain>\n</Xdmf>\n";
  return xml;
}

void XdmfSeries::write() const { file::replace(path_, text()); }

}  // namespace stiffront
