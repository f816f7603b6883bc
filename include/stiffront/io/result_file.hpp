// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "stiffront/mesh/boundary.hpp"
#include "stiffront/mesh/field.hpp"

namespace stiffront {

/// What a result file says about its state besides the values.
struct StateHeader {
  double time = 0.0;
  std::int64_t step = 0;      ///< accepted steps made when the state was reached or passed
  bool interpolated = false;  ///< between the ends of the step
  std::vector<std::string> species;
  std::string case_text;  ///< the complete case file, TOML
};

/// Writes one state to an HDF5 file, all ranks together: datasets /SPECIES as [nx] or [ny][nx] doubles, /x, /y, and attributes time,
/// step, interpolated, species, case, dimension, points, lower, upper, periodic, boundary (sides x lower, x upper, y lower, y upper),
/// version, git_hash.
///
/// The file appears under its name when it is complete, or not at all. The space is asked for beforehand, so that a full disk is
/// found where it can be reported.
/// @throws Error(io) on every rank if it failed on any. @mpi collective on u.comm().
void write_state(const std::string& path, const StateHeader& header, const Boundary& boundary, const Field& u);

/// Whether the file layer was left in a state in which MPI_Finalize would crash (a parallel HDF5 file that could not be closed): the
/// program must then end by MPI_Abort.
bool must_end_by_abort();

/// Where an initial or reference state came from.
struct StateSource {
  double time = 0.0;
  std::int64_t step = 0;
  bool interpolated = false;  ///< from another grid
  std::string note;           ///< one sentence for the log
};

/// Reads the named species of a state into the interior of u. Each rank reads its own box and a margin, with no communication but
/// the final agreement.
///
/// On the same grid the values are exact. From another uniform grid over the same domain they are interpolated by cubics in each
/// direction through the four nearest points (one-sided at an end, around it where the file's grid is periodic; fewer points if there
/// are no four); where none of the points used is negative, the result is not made negative either. Positions are exact rational
/// numbers of the two spacings, so the result does not depend on the number of ranks.
/// @throws Error(io) if the file cannot be read or is no result file; Error(input) if a species is missing or the dimension or domain
///         is another. On every rank. @mpi collective on u.comm().
StateSource read_state(const std::string& path, const std::vector<std::string>& species, Field& u);

/// Reads the attributes alone, on this process.
/// @throws Error(io)
StateHeader read_header(const std::string& path);

}  // namespace stiffront
