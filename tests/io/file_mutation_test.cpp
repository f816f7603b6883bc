// SPDX-License-Identifier: BSD-3-Clause
// Whatever the bytes of a manifest, it is read or refused as damaged: no crash, no hang, no error of another kind.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "../../src/io/content_hash.hpp"
#include "../../src/io/manifest.hpp"
#include "stiffront/core/error.hpp"
#include "support/mutation.hpp"

namespace stiffront {
namespace {

const std::vector<std::string> json_fragments = {"{",
                                                 "}",
                                                 "[",
                                                 "]",
                                                 ",",
                                                 ":",
                                                 "\"",
                                                 "null",
                                                 "true",
                                                 "-1",
                                                 "1e400",
                                                 "9223372036854775807",
                                                 "[[[[[[[[",
                                                 "\\u0000",
                                                 "\"shards\"",
                                                 "\"numbers\": {}",
                                                 "\"points\": [0]",
                                                 "\n",
                                                 "\xff",
                                                 std::string(1, '\0')};

Manifest example() {
  Manifest m;
  m.header = {120, 0.25, "bz", {"a", "b"}, Grid{2, {9, 7}}, "title = \"t\"\n"};
  m.numbers["dt"] = {1e-3};
  m.numbers["control"] = {1.0, 2.0, 3.0};
  m.fields = {"state"};
  m.cells = {"hints"};
  m.shards = {{{0, 0, 9, 4}, 1000, 1}, {{0, 4, 9, 3}, 900, 2}};
  return m;
}

TEST(FileMutation, AnyManifestIsReadOrRefusedAsDamaged) {
  const std::string whole = example().text();
  ASSERT_NO_THROW(Manifest::parse(whole));
  for (std::uint64_t seed = 0; seed < testing::mutation_rounds(3000); ++seed) {
    testing::Mutation mutation(seed);
    const std::string changed = mutation.of(whole, json_fragments);
    if (changed == whole) continue;
    EXPECT_THROW(
        {
          try {
            Manifest::parse(changed);
          } catch (const Error& e) {
            EXPECT_EQ(e.kind(), ErrorKind::io) << "seed " << seed;
            throw;
          }
        },
        Error)
        << "seed " << seed << "\n"
        << changed;
  }
}

TEST(FileMutation, ForgedManifestsWithTheRightHashAreReadOrRefused) {
  const std::string text = example().text();
  const std::string key = ",\n  \"hash\": \"";
  const std::string body = text.substr(0, text.rfind(key));
  int read = 0;
  for (std::uint64_t seed = 0; seed < testing::mutation_rounds(6000); ++seed) {
    testing::Mutation mutation(seed);
    const std::string changed = mutation.of(body, json_fragments);
    try {
      Manifest::parse(changed + key + fmt::format("{:016x}", content_hash(changed)) + "\"\n}\n");
      ++read;
    } catch (const Error& e) {
      EXPECT_EQ(e.kind(), ErrorKind::io) << "seed " << seed << ": " << e.what();
    }
  }
  EXPECT_GT(read, 50);
}

}  // namespace
}  // namespace stiffront
