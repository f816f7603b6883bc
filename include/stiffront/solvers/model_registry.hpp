// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "stiffront/model/model.hpp"
#include "stiffront/solvers/model_kernels.hpp"

namespace stiffront {

/// The models that can be chosen by name.
class ModelRegistry {
 public:
  using Make = std::function<std::unique_ptr<ModelKernels>(const std::map<std::string, double>& parameters)>;

  template <Model M>
  void add() {
    add(describe<M>(), [](const std::map<std::string, double>& parameters) -> std::unique_ptr<ModelKernels> {
      return std::make_unique<ModelKernelsOf<M>>(parameters);
    });
  }
  /// @throws Error(bug) if the name is taken.
  void add(ModelDescription description, Make make);

  /// In order of their names.
  std::vector<ModelDescription> descriptions() const;
  bool contains(const std::string& name) const { return entries_.contains(name); }
  /// @throws Error(input) for an unknown model or parameter.
  std::unique_ptr<ModelKernels> make(const std::string& name, const std::map<std::string, double>& parameters) const;

 private:
  struct Entry {
    ModelDescription description;
    Make make;
  };
  std::map<std::string, Entry> entries_;
};

/// Adds every model in include/stiffront/model/builtin.
void register_builtin_models(ModelRegistry& registry);

}  // namespace stiffront
