// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "stiffront/model/expression.hpp"
#include "stiffront/model/rational.hpp"

namespace stiffront {

/// One reaction as a user writes it.
struct Reaction {
  std::string equation;  ///< "A + 2 B -> C", "A <-> B"; nothing, or 0, on a side stands for what is not modelled
  NumberOrText rate;     ///< coefficient of the law of mass action, or the whole rate
  /// Of the backward direction of "<->". By the law of mass action it must be there; otherwise `rate` may be the net rate.
  std::optional<NumberOrText> reverse_rate;
  bool mass_action = true;
};

/// Who takes part in a reaction; one coefficient per species on either side.
struct ReactionEquation {
  std::vector<Rational> left;
  std::vector<Rational> right;
  bool reversible = false;
};

/// Reads an equation. Coefficients are integers or decimal fractions, "2 A", "2A" or "2*A".
/// @throws ExpressionError with column and remedy
ReactionEquation parse_reaction_equation(const std::string& text, const std::vector<std::string>& species);

/// What a network does to its species.
struct NetworkRates {
  std::vector<ExpressionGraph::Node> rates;    ///< one per species
  std::vector<std::vector<Rational>> changes;  ///< per reaction, the change of each species
};

/// The rates of a network: sum over reactions of (right - left) times the reaction's rate, which by the law of mass action is
/// k times the product of the reactants to the powers of their coefficients, less the same for the backward direction.
///
/// @param graph the species are among its variables, under their names
/// @throws EntryError whose key is model.reactions[i].equation, .rate or .reverse_rate
NetworkRates network_rates(ExpressionGraph& graph, const std::vector<std::string>& species, const std::vector<Reaction>& reactions,
                           const std::map<std::string, double>& parameters);

}  // namespace stiffront
