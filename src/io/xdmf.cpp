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
      case '&':
        r += "&amp;";
        break;
      case '<':
        r += "&lt;";
        break;
      case '>':
        r += "&gt;";
        break;
      case '"':
        r += "&quot;";
        break;
      default:
        r += c;
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
  // A uniform grid of three dimensions with one layer, and one row in 1-D, slowest direction first. Of the forms the format has this is
  // the one that all readers of ParaView 5.11 (XDMF 2 and 3) put where it belongs; grids of coordinate arrays crash them or come out at 0.
  const bool plane = grid_.dimension == 2;
  const std::string extent = fmt::format("1 {} {}", plane ? grid_.uniform_points(1) : 1, grid_.uniform_points(0));
  const std::string origin = fmt::format("0 {} {}", plane ? grid_.lower[1] : 0.0, grid_.lower[0]);
  const std::string spacing = fmt::format("1 {} {}", plane ? grid_.spacing(1) : 1.0, grid_.spacing(0));
  const auto three_numbers = [](const std::string& numbers) {
    return fmt::format("          <DataItem Format=\"XML\" NumberType=\"Float\" Precision=\"8\" Dimensions=\"3\">{}</DataItem>\n", numbers);
  };
  std::string xml =
      "<?xml version=\"1.0\" ?>\n"
      "<!DOCTYPE Xdmf SYSTEM \"Xdmf.dtd\" []>\n"
      "<Xdmf Version=\"2.0\">\n"
      "  <Domain>\n"
      "    <Grid Name=\"states\" GridType=\"Collection\" CollectionType=\"Temporal\">\n";
  for (const Entry& e : entries_) {
    xml += fmt::format("      <Grid Name=\"state\" GridType=\"Uniform\">\n        <Time Value=\"{}\" />\n", e.time);
    xml += fmt::format("        <Topology TopologyType=\"3DCoRectMesh\" Dimensions=\"{}\" />\n", extent);
    xml += "        <Geometry GeometryType=\"ORIGIN_DXDYDZ\">\n" + three_numbers(origin) + three_numbers(spacing) + "        </Geometry>\n";
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
