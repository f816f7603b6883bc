// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <vector>

#include "stiffront/app/case_file.hpp"
#include "stiffront/core/mpi.hpp"

namespace stiffront::app {

/// Reads a case file; a name without such a file may be that of a built-in case.
/// @throws Error(io) if there is neither
CaseSource read_case_source(const std::string& name, const std::vector<std::string>& overrides);

/// The same on every rank: root reads and sends the bytes. @throws Error(io) on every rank. @mpi collective
CaseSource read_case_source(const std::string& name, const std::vector<std::string>& overrides, const Communicator& comm);

}  // namespace stiffront::app
