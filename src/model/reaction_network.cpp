// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/model/reaction_network.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>

#include "stiffront/core/entry_error.hpp"

namespace stiffront {
namespace {

using Node = ExpressionGraph::Node;

class Network {
 public:
  Network(ExpressionGraph& graph, const std::vector<std::string>& species, const std::map<std::string, double>& parameters)
      : graph_(graph), species_(species), parameters_(parameters) {
    for (const std::string& name : species) {
      const auto found = std::find(graph.variables().begin(), graph.variables().end(), name);
      concentrations_.push_back(graph.variable(static_cast<int>(found - graph.variables().begin())));
    }
    result_.rates.assign(species.size(), graph.constant(0.0));
  }

  void add(const Reaction& reaction, const std::string& key) {
    const auto equation = entry(key + ".equation", [&] { return parse_reaction_equation(reaction.equation, species_); });
    const auto refuse = [&](const char* message) { throw EntryError(key + ".reverse_rate", message); };
    if (reaction.reverse_rate && !equation.reversible) refuse("only for an equation with <->");
    if (!reaction.reverse_rate && equation.reversible && reaction.mass_action) refuse("missing: the coefficient of the backward direction");

    Node rate = entry(key + ".rate", [&] { return graph_.parse_value(reaction.rate, parameters_); });
    if (reaction.mass_action) rate = mass_action(rate, equation.left);
    if (reaction.reverse_rate) {
      Node reverse = entry(key + ".reverse_rate", [&] { return graph_.parse_value(*reaction.reverse_rate, parameters_); });
      if (reaction.mass_action) reverse = mass_action(reverse, equation.right);
      rate = graph_.make(Operation::subtract, rate, reverse);
    }
    std::vector<Rational> changes;
    for (std::size_t s = 0; s < species_.size(); ++s) {
      changes.push_back(equation.right[s] - equation.left[s]);
      result_.rates[s] = sum(result_.rates[s], changes[s], rate);
    }
    result_.changes.push_back(changes);
  }

  NetworkRates result() const { return result_; }

 private:
  template <class F>
  static auto entry(const std::string& key, F&& f) -> decltype(f()) {
    try {
      return f();
    } catch (const ExpressionError& e) {
      throw EntryError(key, e.what());
    }
  }

  Node mass_action(Node rate, const std::vector<Rational>& reactants) {
    for (std::size_t s = 0; s < reactants.size(); ++s) {
      if (reactants[s] == Rational(0)) continue;
      const Node power = graph_.make(Operation::power, concentrations_[s], graph_.constant(reactants[s].value()));
      rate = graph_.make(Operation::multiply, rate, power);
    }
    return rate;
  }

  Node sum(Node total, const Rational& coefficient, Node rate) {
    if (coefficient == Rational(0)) return total;
    if (coefficient == Rational(-1)) return graph_.make(Operation::subtract, total, rate);
    return graph_.make(Operation::add, total, graph_.make(Operation::multiply, graph_.constant(coefficient.value()), rate));
  }

  ExpressionGraph& graph_;
  const std::vector<std::string>& species_;
  const std::map<std::string, double>& parameters_;
  std::vector<Node> concentrations_;
  NetworkRates result_;
};

}  // namespace

NetworkRates network_rates(ExpressionGraph& graph, const std::vector<std::string>& species, const std::vector<Reaction>& reactions,
                           const std::map<std::string, double>& parameters) {
  Network network(graph, species, parameters);
  for (std::size_t r = 0; r < reactions.size(); ++r) network.add(reactions[r], fmt::format("model.reactions[{}]", r));
  return network.result();
}

}  // namespace stiffront
