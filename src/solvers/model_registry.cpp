// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/solvers/model_registry.hpp"

#include <fmt/format.h>

#include <utility>

#include "stiffront/core/error.hpp"

namespace stiffront {

void ModelRegistry::add(ModelDescription description, Make make) {
  const std::string name = description.name;
  if (!entries_.emplace(name, Entry{std::move(description), std::move(make)}).second) {
    throw Error(ErrorKind::bug, fmt::format("the model \"{}\" is registered twice", name));
  }
}

std::vector<ModelDescription> ModelRegistry::descriptions() const {
  std::vector<ModelDescription> all;
  for (const auto& [name, entry] : entries_) all.push_back(entry.description);
  return all;
}

std::unique_ptr<ModelKernels> ModelRegistry::make(const std::string& name, const std::map<std::string, double>& parameters) const {
  const auto it = entries_.find(name);
  if (it == entries_.end()) throw Error(ErrorKind::input, fmt::format("model.name: no model is called \"{}\"", name));
  return it->second.make(parameters);
}

}  // namespace stiffront
