// SPDX-License-Identifier: BSD-3-Clause
#include <benchmark/benchmark.h>

#include <array>
#include <cstdlib>
#include <map>
#include <string>
#include <vector>

#include "stiffront/model/builtin/bz.hpp"
#include "stiffront/model/expression_model.hpp"
#include "stiffront/solvers/radau5_kernel.hpp"

/// The Belousov-Zhabotinsky model as text against the same in C++: rates, and rates with Jacobian, of packs of cells that stay in
/// the first-level cache, and whole integrations of the reaction, where the rest of the work is the same for both.
namespace stiffront {
namespace {

constexpr int n_packs = 16;

struct Cells {
  Cells() {
    for (int p = 0; p < n_packs; ++p) {
      u[p][0] = Pack(20.0 + p);
      u[p][1] = Pack(0.05 * p);
      u[p][2] = Pack(0.1 + 0.01 * p);
      places[p] = {Pack(0.0), Pack(0.0), Pack(0.0)};
    }
  }
  Pack u[n_packs][3];
  Pack du[n_packs][3];
  Pack jacobian[n_packs][3][3];
  Place<Pack> places[n_packs];
};

ExpressionModel<3> custom_bz() {
  const Bz bz;
  const std::map<std::string, double> parameters = {{"epsilon", bz.epsilon}, {"mu", bz.mu}, {"f", bz.f}, {"q", bz.q}};
  ExpressionGraph graph({"a", "b", "c", "t", "x", "y"});
  const std::array<ExpressionGraph::Node, 3> rates = {graph.parse("(f*c - q*a - a*b)/mu", parameters),
                                                      graph.parse("(q*a - a*b + b*(1 - b))/epsilon", parameters),
                                                      graph.parse("b - c", parameters)};
  return ExpressionModel<3>(graph, rates);
}

template <class M>
void rates(benchmark::State& state, const M& model) {
  Cells cells;
  for (auto _ : state) {
    for (int p = 0; p < n_packs; ++p) model.rates(cells.u[p], cells.du[p], cells.places[p]);
    benchmark::DoNotOptimize(&cells);
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * n_packs);
}
BENCHMARK_CAPTURE(rates, built_in, Bz{});
BENCHMARK_CAPTURE(rates, custom, custom_bz());

template <class M>
void rates_jacobian(benchmark::State& state, const M& model) {
  Cells cells;
  for (auto _ : state) {
    for (int p = 0; p < n_packs; ++p) rates_and_jacobian(model, cells.u[p], cells.du[p], cells.jacobian[p], cells.places[p]);
    benchmark::DoNotOptimize(&cells);
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * n_packs);
}
BENCHMARK_CAPTURE(rates_jacobian, built_in, Bz{});
BENCHMARK_CAPTURE(rates_jacobian, custom, custom_bz());

/// As kernels do that take several packs at a time.
void rates_jacobian_together(benchmark::State& state) {
  const ExpressionModel<3> model = custom_bz();
  constexpr int n = ExpressionModel<3>::packs_together;
  Cells cells;
  for (auto _ : state) {
    for (int begin = 0; begin < n_packs; begin += n) {
      ExpressionModel<3>::Evaluation<Pack, n> evaluation(model);
      for (int p = 0; p < n; ++p) {
        for (int s = 0; s < 3; ++s) evaluation.u(s, p) = cells.u[begin + p][s];
      }
      evaluation.run(cells.places + begin);
      benchmark::DoNotOptimize(&evaluation);
      benchmark::ClobberMemory();
    }
  }
  state.SetItemsProcessed(state.iterations() * n_packs);
}
BENCHMARK(rates_jacobian_together);

constexpr int n_cells = 1001;
constexpr double dt = 1e-3;

template <class M>
void react(Radau5Kernel<M>& kernel, int n, const double* from, double* to, double* hint) {
  std::vector<float> cost(static_cast<std::size_t>(n));
  kernel.begin(0.0, dt);
  kernel.row({n, from, n_cells, to, n_cells, hint, cost.data(), 0}, [](int, int) { return Place<Pack>{0.0, 0.0, 0.0}; });
  if (kernel.finish()) std::abort();
}

/// Cells per second over an interval of 1e-3, each cell further along the cycle of an ignited one than the one before.
template <class M>
void radau5(benchmark::State& state, const M& model) {
  const double tolerance[] = {1e-5, 1e-5, 1e-5};
  Radau5Kernel<M> kernel(model, Radau5Tolerances<3>(1e-5, tolerance));
  std::vector<double> from(3 * n_cells), to(3 * n_cells), hint(n_cells, 0.0);
  from[0] = 0.5;
  from[n_cells] = 0.8;
  from[2 * n_cells] = 0.01;
  for (int i = 0; i + 1 < n_cells; ++i) {
    react(kernel, 1, from.data() + i, to.data() + i, hint.data() + i);
    for (int s = 0; s < 3; ++s) from[static_cast<std::size_t>(s * n_cells + i + 1)] = to[static_cast<std::size_t>(s * n_cells + i)];
  }
  for (auto _ : state) {
    react(kernel, n_cells, from.data(), to.data(), hint.data());
    benchmark::DoNotOptimize(to.data());
  }
  state.SetItemsProcessed(state.iterations() * n_cells);
}
BENCHMARK_CAPTURE(radau5, built_in, Bz{});
BENCHMARK_CAPTURE(radau5, custom, custom_bz());

}  // namespace
}  // namespace stiffront
