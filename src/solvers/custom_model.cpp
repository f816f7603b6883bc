// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/solvers/custom_model.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "stiffront/core/entry_error.hpp"
#include "stiffront/core/spelling.hpp"
#include "stiffront/model/space_expression.hpp"
#include "stiffront/solvers/expression_kernels.hpp"

namespace stiffront {
namespace {

using Node = ExpressionGraph::Node;

constexpr std::array<const char*, 3> places = {"t", "x", "y"};

bool is_identifier(const std::string& name) {
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
  const auto is_part = [&](char c) { return is_letter(c) || (c >= '0' && c <= '9'); };
  return !name.empty() && is_letter(name[0]) && std::all_of(name.begin(), name.end(), is_part);
}

/// Names of species and parameters, each of which stands for one thing in an expression.
class Names {
 public:
  void add(const std::string& key, const std::string& name) {
    if (!is_identifier(name)) {
      throw EntryError(key, fmt::format("\"{}\" is no name: letters, digits and _, not beginning with a digit", name));
    }
    if (std::find(places.begin(), places.end(), name) != places.end()) {
      throw EntryError(key, fmt::format("{} stands for time or place; choose another name", name));
    }
    if (std::find(taken_.begin(), taken_.end(), name) != taken_.end()) throw EntryError(key, fmt::format("{} is there twice", name));
    taken_.push_back(name);
  }

 private:
  std::vector<std::string> taken_;
};

class Compilation {
 public:
  explicit Compilation(const CustomModel& model) : model_(model), graph_(variables(model)) {}

  std::unique_ptr<ModelKernels> run() {
    names();
    diffusion();
    rates();
    return kernels(std::make_integer_sequence<int, max_custom_species>());
  }

 private:
  static std::vector<std::string> variables(const CustomModel& model) {
    std::vector<std::string> all = model.species;
    all.insert(all.end(), places.begin(), places.end());
    return all;
  }

  std::size_t n_species() const { return model_.species.size(); }

  void names() {
    if (n_species() == 0) throw EntryError("model.species", "missing: the names of the species");
    if (n_species() > max_custom_species) {
      throw EntryError("model.species", fmt::format("expected at most {} species, got {}", max_custom_species, n_species()));
    }
    Names names;
    for (std::size_t s = 0; s < n_species(); ++s) names.add(fmt::format("model.species[{}]", s), model_.species[s]);
    for (const auto& [name, value] : model_.parameters) {
      const std::string key = fmt::format("model.parameters.{}", name);
      names.add(key, name);
      if (!std::isfinite(value)) throw EntryError(key, "expected a finite number");
      parameters_[name] = value;
      description_.parameters.push_back({name, value});
    }
    description_.name = ExpressionModel<1>::name;
    description_.source = ExpressionModel<1>::source;
    description_.species = model_.species;
  }

  std::size_t species_of(const std::string& key, const std::string& name) const {
    const auto found = std::find(model_.species.begin(), model_.species.end(), name);
    if (found == model_.species.end()) {
      throw EntryError(key, fmt::format("unknown species{}", with_allowed(suggestion(name, model_.species), "", model_.species)));
    }
    return static_cast<std::size_t>(found - model_.species.begin());
  }

  void diffusion() {
    description_.diffusion.assign(n_species(), 0.0);
    for (const auto& [name, value] : model_.diffusion) {
      const std::string key = fmt::format("model.diffusion.{}", name);
      double& coefficient = description_.diffusion[species_of(key, name)];
      try {
        coefficient = constant_expression(value, parameters_);
      } catch (const ExpressionError& e) {
        throw EntryError(key, e.what());
      }
      if (!(coefficient >= 0.0)) throw EntryError(key, fmt::format("expected a number not below 0, got {}", coefficient));
    }
  }

  void rates() {
    NetworkRates network = network_rates(graph_, model_.species, model_.reactions, parameters_);
    std::vector<bool> given(n_species(), false);
    for (const auto& [name, text] : model_.reaction) {
      const std::string key = fmt::format("model.reaction.{}", name);
      const std::size_t s = species_of(key, name);
      if (given[s]) throw EntryError(key, fmt::format("{} is there twice", name));
      given[s] = true;
      Node rate = -1;
      try {
        rate = graph_.parse(text, parameters_);
      } catch (const ExpressionError& e) {
        throw EntryError(key, e.what());
      }
      if (graph_.is_constant(rate, 0.0)) continue;
      network.rates[s] = graph_.make(Operation::add, network.rates[s], rate);
      // What an expression changes is conserved by nothing: as if it were a reaction of its own.
      network.changes.emplace_back(n_species());
      network.changes.back()[s] = Rational(1);
    }
    rates_ = network.rates;
    if (!model_.reactions.empty()) {
      description_.conserved = conserved_sums(model_.species, network.changes);
      return;
    }
    std::vector<std::string> missing;
    for (std::size_t s = 0; s < n_species(); ++s) {
      if (!given[s]) missing.push_back(model_.species[s]);
    }
    if (!missing.empty()) {
      throw EntryError("model.reaction", fmt::format("no expression for {}; every species needs one", fmt::join(missing, ", ")));
    }
  }

  template <int... counts_less_one>
  std::unique_ptr<ModelKernels> kernels(std::integer_sequence<int, counts_less_one...>) {
    std::unique_ptr<ModelKernels> result;
    (kernels<counts_less_one + 1>(result), ...);
    return result;
  }

  template <int n>
  void kernels(std::unique_ptr<ModelKernels>& result) {
    if (n_species() != n) return;
    std::array<Node, n> rates;
    std::copy_n(rates_.begin(), n, rates.begin());
    result = expression_kernels<n>(ExpressionModel<n>(graph_, rates), description_);
  }

  const CustomModel& model_;
  ExpressionGraph graph_;
  std::map<std::string, double> parameters_;
  ModelDescription description_;
  std::vector<Node> rates_;
};

}  // namespace

std::unique_ptr<ModelKernels> make_custom_model(const CustomModel& model) { return Compilation(model).run(); }

}  // namespace stiffront
