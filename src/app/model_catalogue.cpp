// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/app/model_catalogue.hpp"

namespace stiffront::app {

const ModelEntry* ModelCatalogue::find(std::string_view name) const {
  for (const ModelEntry& model : models) {
    if (model.name == name) return &model;
  }
  return nullptr;
}

}  // namespace stiffront::app
