// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace stiffront::app {

/// What a case file may say about one model. Names only: the equations are the model's own business.
struct ModelEntry {
  std::string name;
  std::string description;                                  ///< one line
  std::string source;                                       ///< where the model is published
  std::vector<std::string> species;
  std::vector<std::pair<std::string, double>> parameters;   ///< with defaults
  std::vector<double> diffusion;                            ///< default coefficients, one per species
  std::vector<std::string> profiles;                        ///< names of initial profiles
};

/// The models a case file may name, built-in ones and those a program of the user registered.
struct ModelCatalogue {
  std::vector<ModelEntry> models;

  /// Null if there is no such model.
  const ModelEntry* find(std::string_view name) const;
};

}  // namespace stiffront::app
