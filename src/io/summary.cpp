// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/io/summary.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "file.hpp"
#include "stiffront/core/version.hpp"

namespace stiffront {
namespace {

using Json = nlohmann::ordered_json;

/// JSON has no word for what is not finite, and the library would write null.
Json number(double x) {
  if (std::isnan(x)) return "nan";
  if (std::isinf(x)) return x > 0.0 ? "inf" : "-inf";
  return x;
}

Json work(const Summary& s) {
  const Work& w = s.work;
  Json j;
  j["diffusion_steps"] = w.diffusion_steps;
  j["diffusion_rejections"] = w.diffusion_rejections;
  j["diffusion_stages"] = w.diffusion_stages;
  j["reaction_steps"] = w.reaction_steps;
  j["reaction_rejections"] = w.reaction_rejections;
  j["reaction_newton_iterations"] = w.reaction_newton_iterations;
  j["reaction_rhs"] = w.reaction_rhs;
  j["reaction_jacobians"] = w.reaction_jacobians;
  j["sweeps"] = w.sweeps;
  j["line_solves"] = w.line_solves;
  j["rhs_evaluations"] = w.rhs_evaluations;
  j["linear_iterations"] = w.linear_iterations;
  j["halo_exchanges"] = w.halo_exchanges;
  j["halo_messages"] = s.halo_messages;
  j["halo_bytes"] = s.halo_bytes;
  j["allreduces"] = s.allreduces;
  return j;
}

Json grid(const Summary& s) {
  Json j;
  j["points"] = Json::array();
  j["lower"] = Json::array();
  j["upper"] = Json::array();
  for (std::size_t d = 0; d < static_cast<std::size_t>(s.grid.dimension); ++d) {
    j["points"].push_back(s.grid.uniform_points(static_cast<int>(d)));
    j["lower"].push_back(number(s.grid.lower[d]));
    j["upper"].push_back(number(s.grid.upper[d]));
  }
  j["processes"] = s.processes;
  return j;
}

}  // namespace

std::string summary_json(const Summary& s) {
  Json j;
  j["schema"] = 1;
  j["status"] = s.status;
  if (!s.reason.empty()) j["reason"] = s.reason;
  if (!s.note.empty()) j["note"] = s.note;
  if (s.final_error) j["final_error"] = number(*s.final_error);
  if (!s.advice.empty()) j["advice"] = s.advice;
  if (!s.title.empty()) j["title"] = s.title;
  j["model"] = s.model;
  j["method"] = s.method;
  if (!s.choice.empty()) j["choice"] = s.choice;
  j["grid"] = grid(s);
  j["time"] = number(s.time);
  j["steps"]["accepted"] = s.accepted;
  j["steps"]["rejected"] = s.rejected;
  j["work"] = work(s);
  j["wall_seconds"] = Json::object();
  for (const auto& [phase, seconds] : s.wall_seconds) j["wall_seconds"][phase] = number(seconds);
  j["ranks"] = s.ranks;
  j["imbalance"] = number(s.imbalance);
  if (s.balance) {
    j["balance"]["imbalance_before"] = number(s.balance->before);
    j["balance"]["imbalance_after"] = number(s.balance->after);
    j["balance"]["messages"] = s.balance->messages;
    j["balance"]["bytes"] = s.balance->bytes;
    j["balance"]["cells"] = s.balance->cells;
  }
  j["rank_work"] = Json::array();
  for (const Summary::RankWork& w : s.rank_work) {
    Json rank;
    rank["reaction_newton_iterations"] = w.newton_iterations;
    rank["diffusion_seconds"] = number(w.diffusion);
    rank["reaction_seconds"] = number(w.reaction);
    rank["communication_seconds"] = number(w.communication);
    j["rank_work"].push_back(rank);
  }
  j["negatives"] = s.negatives;
  j["peak_memory_mib"] = number(s.peak_memory_mib);
  j["output_files"] = s.output_files;
  j["checkpoints"] = s.checkpoints;
  j["restarted"] = s.restarted;
  j["version"] = version::number;
  j["git_hash"] = version::git_hash;
  j["compiler"] = version::compiler;
  j["flags"] = version::flags;
  j["checksum"] = s.checksum;
  // Messages may quote bytes of a file that are no UTF-8.
  return j.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

void write_summary(const std::string& path, const Summary& summary) { file::replace(path, summary_json(summary)); }

}  // namespace stiffront
