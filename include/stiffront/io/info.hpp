// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>

namespace stiffront {

/// What is in a result file, as text for a terminal: grid, boundary, time, step, versions, and for every species its range, mean and
/// the number of values that are not finite. One rank's file of a checkpoint is described likewise; any other HDF5 file gets its datasets and attributes listed. On one process.
/// @throws Error(io) if the file cannot be read.
std::string describe_file(const std::string& path);

}  // namespace stiffront
