// SPDX-License-Identifier: BSD-3-Clause
// libFuzzer: a manifest is read or refused as damaged. The hash at its end is put right, so that what lies behind it is reached.
#include "../../src/io/manifest.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <cstdlib>
#include <string>

#include "../../src/io/content_hash.hpp"
#include "stiffront/core/error.hpp"

using namespace stiffront;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  const std::string key = ",\n  \"hash\": \"";
  const std::string body = text.substr(0, text.rfind(key));
  for (const std::string& whole : {text, body + key + fmt::format("{:016x}", content_hash(body)) + "\"\n}\n"}) {
    try {
      Manifest::parse(whole);
    } catch (const Error& e) {
      if (e.kind() != ErrorKind::io) std::abort();
    }
  }
  return 0;
}
