// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "stiffront/model/reaction_network.hpp"
#include "stiffront/solvers/model_kernels.hpp"

namespace stiffront {

inline constexpr int max_custom_species = 8;

/// A model as a user writes it, without a line of C++. Either or both of `reaction` and `reactions` say what happens; what they give
/// for a species is added.
struct CustomModel {
  std::vector<std::string> species;  ///< letters, digits and _; not t, x, y
  std::vector<std::pair<std::string, double>> parameters;
  std::vector<std::pair<std::string, NumberOrText>> diffusion;  ///< expressions of parameters; species left out: 0
  std::vector<std::pair<std::string, std::string>> reaction;    ///< rates: expressions of species, parameters, t, x and y
  std::vector<Reaction> reactions;                              ///< a reaction network
};

/// Compiles a model; its description has the diffusion coefficients evaluated, and the sums that the reactions conserve.
///
/// Without a network every species needs its expression.
/// @throws EntryError with the key of the entry at fault (model.species, model.parameters.k, model.diffusion.u, model.reaction.u,
///         model.reactions[0].rate) and, for expressions and equations, the column and remedy; Error(input) for a model that is
///         too large.
std::unique_ptr<ModelKernels> make_custom_model(const CustomModel& model);

}  // namespace stiffront
