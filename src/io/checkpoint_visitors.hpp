// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <set>
#include <string>
#include <vector>

#include "hdf5.hpp"
#include "manifest.hpp"

namespace stiffront {

/// Collects what it is shown: arrays into one rank's file, the rest into the manifest.
///
/// The file is an HDF5 image in memory: it is written by plain system calls, whose failures are certain and leave nothing behind in
/// the HDF5 library.
class SavingVisitor final : public StateVisitor {
 public:
  SavingVisitor(const Decomposition& decomposition, Manifest& manifest);

  void numbers(const std::string& name, std::vector<double>& values) override;
  void field(const std::string& name, Field& values) override;
  void cells(const std::string& name, std::vector<double>& values) override;

  /// The finished file; nothing can be added any more.
  std::string image();

 private:
  void claim(const std::string& name);

  const Decomposition* decomposition_;
  Manifest* manifest_;
  std::set<std::string> names_;
  hdf5::Handle file_;
};

/// Gives back what a checkpoint holds, from the files of all boxes that overlap this rank's.
class LoadingVisitor final : public StateVisitor {
 public:
  LoadingVisitor(const Decomposition& decomposition, const Manifest& manifest, std::string path);

  void numbers(const std::string& name, std::vector<double>& values) override;
  void field(const std::string& name, Field& values) override;
  void cells(const std::string& name, std::vector<double>& values) override;

  /// @throws Error(input) if something was not asked for.
  void require_all_asked_for() const;

 private:
  /// Reads layer `layer` of a dataset [layers][n_y][n_x] into rows of this rank's box.
  template <class Row>
  void read(const std::string& name, int layers, Row&& row);
  [[noreturn]] void lacks(const std::string& name) const;

  const Decomposition* decomposition_;
  const Manifest* manifest_;
  std::string path_;
  std::set<std::string> asked_;
};

}  // namespace stiffront
