// SPDX-License-Identifier: BSD-3-Clause
#include <H5public.h>
#include <fmt/format.h>
#include <mpi.h>
#include <sundials/sundials_config.h>

#include "stiffront/app/command_line.hpp"
#include "stiffront/core/version.hpp"

namespace stiffront::app {

std::string version_text() {
  char mpi[MPI_MAX_LIBRARY_VERSION_STRING] = "";
  int length = 0;
  MPI_Get_library_version(mpi, &length);  // allowed before MPI_Init
  std::string mpi_line(mpi, static_cast<std::size_t>(length));
  mpi_line = mpi_line.substr(0, mpi_line.find_first_of(",\n"));
  return fmt::format(
      "stiffront {} ({})\ncompiler   {}\nflags      {}, denormals flushed to zero\nMPI        {}\nHDF5       {}.{}.{}\n"
      "SUNDIALS   {}",
      version::number, version::git_hash, version::compiler, version::flags, mpi_line, H5_VERS_MAJOR, H5_VERS_MINOR, H5_VERS_RELEASE,
      SUNDIALS_VERSION);
}

}  // namespace stiffront::app
