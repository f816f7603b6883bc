// SPDX-License-Identifier: BSD-3-Clause
#include "custom_model_of.hpp"

namespace stiffront::app {

CustomModel custom_model_of(const ModelOptions& options) {
  CustomModel model;
  model.species = options.species;
  model.parameters = options.parameters;
  model.diffusion = options.diffusion;
  model.reaction = options.reaction;
  for (const ReactionOptions& r : options.reactions) {
    model.reactions.push_back({r.equation, r.rate, r.reverse_rate, r.mass_action});
  }
  return model;
}

}  // namespace stiffront::app
