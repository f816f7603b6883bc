// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <vector>

#include "stiffront/mesh/grid.hpp"

namespace stiffront {

/// The time series over a run's result files, as XDMF 2 for ParaView and VisIt.
///
/// Two dimensions are a 2DRectMesh over /x and /y (a 2DCoRectMesh is laid into the y-z plane by the reader of VTK); one dimension is one
/// polyline, so that any number of species can be plotted over it.
class XdmfSeries {
 public:
  /// @param path of the XML file; the result files are beside it.
  XdmfSeries(std::string path, const Grid& grid, std::vector<std::string> species);

  /// Adds a state; a later one with the same file name replaces it. Times ascend.
  void add(double time, const std::string& file_name);
  /// Rewrites the file: complete or not at all. On one process. @throws Error(io)
  void write() const;
  std::string text() const;

 private:
  struct Entry {
    double time;
    std::string file_name;
  };
  std::string path_;
  Grid grid_;
  std::vector<std::string> species_;
  std::vector<Entry> entries_;
};

}  // namespace stiffront
