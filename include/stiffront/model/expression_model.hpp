// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <concepts>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "stiffront/model/expression_contraction.hpp"
#include "stiffront/model/expression_program.hpp"
#include "stiffront/model/model.hpp"

namespace stiffront {

/// A model of M species whose rates are expressions: rates by one program, rates and exact Jacobian by another. The rates have the
/// same bits from both.
///
/// Species, parameters and their defaults are known at run time only (ModelDescription); the static members are empty.
template <int M>
class ExpressionModel {
  static constexpr int n_inputs = M + 3;  // the species, t, x, y

  struct Programs {
    ExpressionProgram rates;
    ExpressionProgram rates_and_jacobian;
    std::vector<bool> is_zero;  // entries of the Jacobian, row by row; they are outputs M, M + 1, ...
    bool need_place = false;
  };

 public:
  static constexpr int n_species = M;
  static constexpr const char* name = "custom";
  static constexpr const char* source = "written in the case file";
  static constexpr std::array<const char*, 0> species{};
  static constexpr std::array<double, 0> diffusion{};
  static constexpr std::array<Parameter<ExpressionModel>, 0> parameters{};
  static constexpr std::array<Profile<ExpressionModel>, 0> profiles{};
  /// A kernel's loop should evaluate so many packs of cells together: an instruction is then looked up once for all of them.
  static constexpr int packs_together = 8;

  /// Nothing reacts.
  ExpressionModel() {
    std::vector<std::string> nameless(n_inputs);
    ExpressionGraph graph(std::move(nameless));
    std::array<ExpressionGraph::Node, M> zero;
    zero.fill(graph.constant(0.0));
    *this = ExpressionModel(graph, zero);
  }

  /// @param graph  its variables are the species, then t, x and y
  /// @param rates  one node per species
  /// @throws Error(input) if the Jacobian is too large
  ExpressionModel(ExpressionGraph& graph, const std::array<ExpressionGraph::Node, M>& rates) {
    const std::vector<ExpressionGraph::Node> values = contract(graph, {rates.begin(), rates.end()});
    std::vector<ExpressionGraph::Node> all = values;
    auto programs = std::make_shared<Programs>();
    for (int i = 0; i < M; ++i) {
      for (int j = 0; j < M; ++j) {
        const ExpressionGraph::Node entry = graph.differentiate(values[static_cast<std::size_t>(i)], j);
        programs->is_zero.push_back(graph.is_constant(entry, 0.0));
        all.push_back(entry);
      }
    }
    programs->rates = ExpressionProgram(graph, values);
    programs->rates_and_jacobian = ExpressionProgram(graph, contract(graph, all, values));
    for (int k = M; k < n_inputs; ++k) {
      programs->need_place |= programs->rates.uses_input(k) || programs->rates_and_jacobian.uses_input(k);
    }
    programs_ = std::move(programs);
  }

  template <class T, class P>
  void rates(const T* u, T* du, const P& place) const {
    if constexpr (std::same_as<T, double> || std::same_as<T, Pack>) {
      ExpressionProgram::Frame<T, 1> frame(programs_->rates);
      for (int s = 0; s < M; ++s) frame.input(s) = u[s];
      if (programs_->need_place) set_place(frame, 0, place);
      frame.run();
      for (int s = 0; s < M; ++s) du[s] = frame.output(s);
    } else {
      along(u, du, place);
    }
  }

  /// The rates of n packs of cells in one go.
  template <int n>
  void rates_of_several(const Pack (*u)[M], Pack (*du)[M], const Place<Pack>* places) const {
    ExpressionProgram::Frame<Pack, n> frame(programs_->rates);
    for (int p = 0; p < n; ++p) {
      for (int s = 0; s < M; ++s) frame.input(s, p) = u[p][s];
      if (programs_->need_place) set_place(frame, p, places[p]);
    }
    frame.run();
    for (int p = 0; p < n; ++p) {
      for (int s = 0; s < M; ++s) du[p][s] = frame.output(s, p);
    }
  }

  template <class T>
  void rates_and_jacobian(const T* u, T* du, T (*jacobian)[M], const Place<T>& place) const {
    Evaluation<T, 1> evaluation(*this);
    for (int s = 0; s < M; ++s) evaluation.u(s) = u[s];
    evaluation.run(&place);
    for (int i = 0; i < M; ++i) {
      du[i] = evaluation.rate(i);
      for (int j = 0; j < M; ++j) jacobian[i][j] = evaluation.jacobian(i, j);
    }
  }

  /// Rates and Jacobians of n cells or packs of cells in one go, with nothing copied: set u, run, read the results.
  template <class T, int n>
  class Evaluation {
   public:
    explicit Evaluation(const ExpressionModel& model) : programs_(*model.programs_), frame_(programs_.rates_and_jacobian) {}

    T& u(int s, int p = 0) { return frame_.input(s, p); }
    /// @param places n of them
    void run(const Place<T>* places) {
      if (programs_.need_place) {
        for (int p = 0; p < n; ++p) set_place(frame_, p, places[p]);
      }
      frame_.run();
    }
    T rate(int i) const { return frame_.output(i); }
    T jacobian(int i, int j) const { return frame_.output(M + i * M + j); }
    /// Of one of the n: input(s) is the state, outputs are the rates and then the Jacobian row by row.
    auto values(int p) const { return frame_.values(p); }
    bool needs_places() const { return programs_.need_place; }

   private:
    const Programs& programs_;
    ExpressionProgram::Frame<T, n> frame_;
  };

 private:
  template <class T, int n, class P>
  static void set_place(ExpressionProgram::Frame<T, n>& frame, int p, const P& place) {
    frame.input(M, p) = T(place.t);
    frame.input(M + 1, p) = T(place.x);
    frame.input(M + 2, p) = T(place.y);
  }

  /// Rates of duals: the Jacobian applied to the derivatives of the arguments.
  template <class T, int N, class P>
  void along(const Dual<T, N>* u, Dual<T, N>* du, const P& place) const {
    Evaluation<T, 1> evaluation(*this);
    for (int s = 0; s < M; ++s) evaluation.u(s) = u[s].value;
    const Place<T> here{T(place.t), T(place.x), T(place.y)};
    evaluation.run(&here);
    for (int i = 0; i < M; ++i) {
      du[i] = Dual<T, N>(evaluation.rate(i));
      for (int j = 0; j < M; ++j) {
        if (programs_->is_zero[static_cast<std::size_t>(i * M + j)]) continue;
        const T entry = evaluation.jacobian(i, j);
        for (int k = 0; k < N; ++k) du[i].derivative[k] = mul_add(entry, u[j].derivative[k], du[i].derivative[k]);
      }
    }
  }

  std::shared_ptr<const Programs> programs_;
};

}  // namespace stiffront
