// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <map>
#include <string>
#include <vector>

#include "stiffront/control/method.hpp"

namespace stiffront::testing {

/// What a method must remember, kept in memory: save(), then load() into another method of the same kind.
class StoredState final : public StateVisitor {
 public:
  void save(Method& method) {
    loading_ = false;
    method.visit_state(*this);
  }
  void load(Method& method) {
    loading_ = true;
    method.visit_state(*this);
  }

  void numbers(const std::string& name, std::vector<double>& values) override { exchange(name, values); }
  void field(const std::string& name, Field& values) override {
    std::vector<double> flat;
    for (int s = 0; s < values.n_species(); ++s) {
      for (int j = 0; j < values.n_y(); ++j) flat.insert(flat.end(), values.row(s, j), values.row(s, j) + values.n_x());
    }
    exchange(name, flat);
    std::size_t n = 0;
    for (int s = 0; s < values.n_species(); ++s) {
      for (int j = 0; j < values.n_y(); ++j) {
        for (int i = 0; i < values.n_x(); ++i) values.at(s, i, j) = flat.at(n++);
      }
    }
  }
  void cells(const std::string& name, std::vector<double>& values) override { exchange(name, values); }

  std::map<std::string, std::vector<double>> stored;

 private:
  void exchange(const std::string& name, std::vector<double>& values) {
    if (loading_) {
      values = stored.at(name);
    } else {
      stored[name] = values;
    }
  }

  bool loading_ = false;
};

}  // namespace stiffront::testing
