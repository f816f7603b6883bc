// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/app/case_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "case_rules.hpp"
#include "case_tree.hpp"
#include "schema.hpp"
#include "stiffront/app/methods.hpp"
#include "stiffront/core/spelling.hpp"

namespace stiffront::app {
namespace {

bool starts_with(const std::string& text, const std::string& beginning) { return text.rfind(beginning, 0) == 0; }

void add_once(std::vector<std::string>& list, const std::string& word) {
  if (std::find(list.begin(), list.end(), word) == list.end()) list.push_back(word);
}

/// What may stand in the table `section` ("" is the top).
std::vector<std::string> allowed_in(const std::string& section, const std::string& method) {
  const std::string prefix = section.empty() ? "" : section + ".";
  std::vector<std::string> names;
  for (const Key& key : schema()) {
    if (!applies(key, method) || !starts_with(key.path, prefix)) continue;
    const std::string rest = key.path.substr(prefix.size());
    add_once(names, rest.substr(0, rest.find('.')));
  }
  return names;
}

/// Where a key of this name would be right.
std::vector<std::string> homes_of(const std::string& name, const std::string& section) {
  std::vector<std::string> siblings;  // the same section with another method
  std::vector<std::string> homes;
  for (const Key& key : schema()) {
    const std::size_t dot = key.path.rfind('.');
    if (dot == std::string::npos || key.path.substr(dot + 1) != name) continue;
    const std::string home = key.path.substr(0, dot);
    if (home == section) {
      add_once(siblings, "method \"" + key.method + "\"");
    } else {
      add_once(homes, "[" + home + "]");
    }
  }
  return siblings.empty() ? homes : siblings;
}

[[noreturn]] void refuse_unknown(const CaseTree& tree, const std::string& section, const std::string& name, const std::string& method) {
  const std::vector<std::string> allowed = allowed_in(section, method);
  std::string where = section.empty() ? " at the top" : " in [" + section + "]";
  if (section == "method") where += " with name = \"" + method + "\"";
  const std::vector<std::string> homes = homes_of(name, section);
  std::string hint = suggestion(name, allowed);
  if (!homes.empty() && homes.size() < 6) hint = fmt::format("; it belongs to {}", fmt::join(homes, " or "));
  tree.fail(section.empty() ? name : section + "." + name, "unknown key" + with_allowed(hint, where, allowed));
}

/// Every entry of the table is a key, leads to keys, or is claimed by a key "SECTION.*".
void check_names(const CaseTree& tree, const ConfigNode& table, const std::string& section, const std::string& method) {
  for (const auto& [name, node] : table.entries) {
    const std::string path = section.empty() ? name : section + "." + name;
    bool is_key = false;
    bool is_section = false;
    for (const Key& key : schema()) {
      if (!applies(key, method)) continue;
      is_key = is_key || key.path == path || key.path == section + ".*";
      is_section = is_section || starts_with(key.path, path + ".");
    }
    if (is_key) continue;
    if (!is_section) refuse_unknown(tree, section, name, method);
    if (node.type != ConfigNode::Type::table) tree.fail(path, fmt::format("expected a table, got {}", short_text(node)));
    check_names(tree, node, path, method);
  }
}

void read_key(const Key& key, Case& c, const CaseTree& tree) {
  const bool rest_of_section = key.path.ends_with(".*");
  const std::string path = rest_of_section ? key.section() : key.path;
  if (const ConfigNode* node = tree.find(path)) key.read(c, *node, path);
}

/// What method.name says; empty if it says nothing or no text.
std::string named_method(const ConfigNode& root) {
  const ConfigNode* method = root.find("method");
  const ConfigNode* name = method != nullptr ? method->find("name") : nullptr;
  return name != nullptr && name->type == ConfigNode::Type::string ? name->string : std::string();
}

}  // namespace

Case parse_case(const CaseSource& source, const std::vector<ModelDescription>& models) {
  ConfigNode root = parse_toml(source.text, source.file);
  const std::string method_in_file = named_method(root);
  ConfigNode overridden = root;
  for (const std::string& override : source.overrides) apply_override(overridden, override);
  if (named_method(overridden) != method_in_file) {
    // Another method chosen on the command line: what the file says about its own does not apply.
    if (ConfigNode* method = root.find("method")) method->entries.clear();
    overridden = root;
    for (const std::string& override : source.overrides) apply_override(overridden, override);
  }
  root = std::move(overridden);
  const CaseTree tree(std::move(root), source.file);

  Case c;
  c.file = source.file;
  c.text = source.text;
  c.overrides = source.overrides;
  if (tree.has("converge")) c.converge.emplace();

  const auto is_method_name = [](const Key& key) { return key.path == "method.name"; };
  const Key& method_key = *std::find_if(schema().begin(), schema().end(), is_method_name);
  read_key(method_key, c, tree);
  const std::string method = method_name(c.method);
  check_names(tree, tree.root(), "", method);  // before anything is missed: it may only be misspelt
  for (const Key& key : schema()) {
    if (applies(key, method) && !is_method_name(key)) read_key(key, c, tree);
  }
  complete(c, tree, models);
  return c;
}

bool Case::same_options(const Case& other) const {
  return title == other.title && grid == other.grid && boundary == other.boundary && space == other.space && model == other.model &&
         initial == other.initial && time == other.time && method == other.method && diffusion_solver == other.diffusion_solver &&
         reaction_solver == other.reaction_solver && output == other.output && limits == other.limits && converge == other.converge;
}

}  // namespace stiffront::app
