// SPDX-License-Identifier: BSD-3-Clause
// libFuzzer: a result file is refused unless nothing but its values was changed. Files without a seal are left out: HDF5 1.10 itself
// crashes on some (docs/files.md).
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "stiffront/core/error.hpp"
#include "stiffront/io/result_file.hpp"

using namespace stiffront;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string path = std::filesystem::temp_directory_path() / ("stiffront-fuzz-" + std::to_string(::getpid()) + ".h5");
  const std::string text(reinterpret_cast<const char*>(data), size);
  if (text.starts_with("\x89HDF")) return 0;
  std::ofstream(path, std::ios::binary) << text;
  try {
    read_header(path);
  } catch (const Error& e) {
    if (e.kind() != ErrorKind::io) std::abort();
  }
  return 0;
}
