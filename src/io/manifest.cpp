// SPDX-License-Identifier: BSD-3-Clause
#include "manifest.hpp"

#include <fmt/format.h>

#include <bit>
#include <charconv>
#include <nlohmann/json.hpp>

#include "content_hash.hpp"
#include "stiffront/core/error.hpp"
#include "stiffront/core/version.hpp"

namespace stiffront {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* format_name = "stiffront-checkpoint";
constexpr int format_major = 1;
constexpr int format_minor = 0;

/// The last line, and what stands between the hash and the end.
constexpr const char* hash_key = ",\n  \"hash\": \"";
constexpr const char* hash_end = "\"\n}\n";
constexpr std::size_t hash_digits = 16;

std::string hex(std::uint64_t x) { return fmt::format("{:016x}", x); }
std::string hex(double x) { return hex(std::bit_cast<std::uint64_t>(x)); }

std::uint64_t word_of(const Json& j) {
  const auto& digits = j.get_ref<const std::string&>();
  std::uint64_t x = 0;
  const auto r = std::from_chars(digits.data(), digits.data() + digits.size(), x, 16);
  if (r.ec != std::errc() || r.ptr != digits.data() + digits.size()) throw Error(ErrorKind::io, "not a hexadecimal number: " + digits);
  return x;
}

double number_of(const Json& j) { return std::bit_cast<double>(word_of(j)); }

void require_cover(const Manifest& m) {
  const Grid& grid = m.header.grid;
  std::int64_t covered = 0;
  for (const Shard& s : m.shards) {
    for (std::size_t d = 0; d < 2; ++d) {
      if (s.box[d] < 0 || s.box[d + 2] < 1 || s.box[d] > grid.points[d] - s.box[d + 2])
        throw Error(ErrorKind::io, "a box lies outside of the grid");
    }
    const std::int64_t points = s.box[2] * s.box[3];
    if (points > grid.total_points() - covered) throw Error(ErrorKind::io, "its boxes overlap");
    covered += points;
  }
  if (covered != grid.total_points()) throw Error(ErrorKind::io, "its boxes do not cover the grid");
}

Manifest from_json(const Json& j) {
  if (j.at("format") != format_name) throw Error(ErrorKind::io, "its manifest is that of another program");
  const int major = j.at("format_version").at(0).get<int>();
  if (major != format_major) {
    throw Error(ErrorKind::io, fmt::format("it is of format version {}; this program reads version {}", major, format_major));
  }
  Manifest m;
  CheckpointHeader& h = m.header;
  h.step = j.at("step").get<std::int64_t>();
  h.time = number_of(j.at("time_bits"));
  h.model = j.at("model").get<std::string>();
  h.species = j.at("species").get<std::vector<std::string>>();
  h.case_text = j.at("case").get<std::string>();
  const Json& grid = j.at("grid");
  const auto points = grid.at("points").get<std::vector<std::int64_t>>();
  if (points.empty() || points.size() > 2) throw Error(ErrorKind::io, "its grid has no dimension this program knows");
  h.grid.dimension = static_cast<int>(points.size());
  for (std::size_t d = 0; d < points.size(); ++d) {
    // Beyond this no product of two overflows, and no run was ever made.
    if (points[d] < 1 || points[d] > (std::int64_t{1} << 31)) throw Error(ErrorKind::io, "its grid has no sensible number of points");
    h.grid.points[d] = points[d];
    h.grid.lower[d] = number_of(grid.at("lower_bits").at(d));
    h.grid.upper[d] = number_of(grid.at("upper_bits").at(d));
    h.grid.periodic[d] = grid.at("periodic").at(d).get<bool>();
  }
  for (const auto& [name, values] : j.at("numbers").items()) {
    for (const Json& v : values) m.numbers[name].push_back(number_of(v));
    m.numbers[name];
  }
  m.fields = j.at("fields").get<std::vector<std::string>>();
  m.cells = j.at("cells").get<std::vector<std::string>>();
  for (const Json& s : j.at("shards")) {
    m.shards.push_back({s.at("box").get<std::array<std::int64_t, 4>>(), s.at("bytes").get<std::int64_t>(), word_of(s.at("hash"))});
  }
  require_cover(m);
  return m;
}

}  // namespace

std::string shard_name(std::size_t rank) { return fmt::format("rank-{:04}.h5", rank); }

std::string Manifest::text() const {
  Json j;
  j["format"] = format_name;
  j["format_version"] = {format_major, format_minor};
  j["version"] = version::number;
  j["git_hash"] = version::git_hash;
  j["step"] = header.step;
  j["time"] = fmt::format("{}", header.time);
  j["time_bits"] = hex(header.time);
  j["model"] = header.model;
  j["species"] = header.species;
  Json& grid = j["grid"];
  for (std::size_t d = 0; d < static_cast<std::size_t>(header.grid.dimension); ++d) {
    grid["points"].push_back(header.grid.points[d]);
    grid["lower_bits"].push_back(hex(header.grid.lower[d]));
    grid["upper_bits"].push_back(hex(header.grid.upper[d]));
    grid["periodic"].push_back(static_cast<bool>(header.grid.periodic[d]));
  }
  j["numbers"] = Json::object();
  for (const auto& [name, values] : numbers) {
    j["numbers"][name] = Json::array();
    for (double v : values) j["numbers"][name].push_back(hex(v));
  }
  j["fields"] = fields;
  j["cells"] = cells;
  j["shards"] = Json::array();
  for (std::size_t n = 0; n < shards.size(); ++n) {
    Json s;
    s["file"] = shard_name(n);
    s["box"] = shards[n].box;
    s["bytes"] = shards[n].bytes;
    s["hash"] = hex(shards[n].hash);
    j["shards"].push_back(std::move(s));
  }
  j["case"] = header.case_text;
  std::string body = j.dump(2, ' ', false, Json::error_handler_t::replace);
  body.resize(body.size() - 2);  // the closing "\n}"
  return body + hash_key + hex(content_hash(body)) + hash_end;
}

Manifest Manifest::parse(const std::string& text) {
  const std::size_t tail = std::string_view(hash_key).size() + hash_digits + std::string_view(hash_end).size();
  const std::string body = text.size() > tail ? text.substr(0, text.size() - tail) : std::string();
  if (body.empty() || text.substr(body.size()) != hash_key + hex(content_hash(body)) + hash_end) {
    throw Error(ErrorKind::io, "its manifest is damaged");
  }
  try {
    return from_json(Json::parse(text));
  } catch (const nlohmann::json::exception& e) {
    throw Error(ErrorKind::io, fmt::format("its manifest cannot be understood: {}", e.what()));
  }
}

}  // namespace stiffront
