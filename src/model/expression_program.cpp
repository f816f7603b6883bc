// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/model/expression_program.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <functional>
#include <initializer_list>
#include <limits>
#include <map>
#include <queue>
#include <set>
#include <utility>

#include "expression_code.hpp"
#include "stiffront/core/error.hpp"

namespace stiffront {
namespace {

using Node = ExpressionGraph::Node;
using Code = ExpressionProgram::Code;

/// An instruction before registers are known: its operands are nodes, -1 where it has none.
struct Selected {
  Selected(Code instruction, std::initializer_list<Node> nodes, double first = 0.0, double second = 0.0)
      : code(instruction), k(first), l(second) {
    operands.fill(-1);
    std::copy(nodes.begin(), nodes.end(), operands.begin());
  }

  Code code;
  std::array<Node, 4> operands;
  double k;
  double l;
};

Code function_code(Operation operation) {
  switch (operation) {
    case Operation::power:
      return Code::power;
    case Operation::minimum:
      return Code::minimum;
    case Operation::maximum:
      return Code::maximum;
    case Operation::absolute:
      return Code::absolute;
    case Operation::square_root:
      return Code::square_root;
    case Operation::exponential:
      return Code::exponential;
    case Operation::logarithm:
      return Code::logarithm;
    case Operation::logarithm10:
      return Code::logarithm10;
    case Operation::sine:
      return Code::sine;
    case Operation::cosine:
      return Code::cosine;
    case Operation::tangent:
      return Code::tangent;
    case Operation::arc_sine:
      return Code::arc_sine;
    case Operation::arc_cosine:
      return Code::arc_cosine;
    case Operation::arc_tangent:
      return Code::arc_tangent;
    case Operation::hyperbolic_sine:
      return Code::hyperbolic_sine;
    case Operation::hyperbolic_cosine:
      return Code::hyperbolic_cosine;
    case Operation::hyperbolic_tangent:
      return Code::hyperbolic_tangent;
    default:
      throw Error(ErrorKind::bug, "this operation is not a function");
  }
}

/// Chooses an instruction for a node; what only this node needs may become part of it.
class Selection {
 public:
  Selection(const ExpressionGraph& graph, const std::vector<Node>& outputs) : graph_(graph) {
    const std::vector<Node> needed = graph.reachable(outputs);
    if (needed.empty()) return;
    uses_.resize(static_cast<std::size_t>(needed.back()) + 1, 0);
    for (Node n : outputs) ++uses_[static_cast<std::size_t>(n)];
    for (Node n : needed) {
      for (Node operand : {graph.data(n).a, graph.data(n).b, graph.data(n).c}) {
        if (operand >= 0) ++uses_[static_cast<std::size_t>(operand)];
      }
    }
  }

  Selected select(Node n) const {
    const ExpressionGraph::NodeData& d = graph_.data(n);
    switch (d.operation) {
      case Operation::constant:
        return {Code::constant, {}, d.value};
      case Operation::add:
        return sum(d.a, d.b);
      case Operation::subtract:
        return difference(d.a, d.b);
      case Operation::multiply:
        return product(d.a, d.b);
      case Operation::divide:
        return quotient(d.a, d.b);
      case Operation::negate:
        return {Code::negate, {d.a}};
      case Operation::multiply_add:
        return product_and_sum(d.a, d.b, d.c);
      case Operation::less:
        return {Code::less, {d.a, d.b}};
      case Operation::less_equal:
        return {Code::less_equal, {d.a, d.b}};
      case Operation::greater:
        return {Code::less, {d.b, d.a}};
      case Operation::greater_equal:
        return {Code::less_equal, {d.b, d.a}};
      case Operation::equal:
        return {Code::equal, {d.a, d.b}};
      case Operation::not_equal:
        return {Code::not_equal, {d.a, d.b}};
      case Operation::select:
        return choice(d.a, d.b, d.c);
      default:
        return {function_code(d.operation), {d.a, d.b}};
    }
  }

 private:
  Node left(Node n) const { return graph_.data(n).a; }
  Node right(Node n) const { return graph_.data(n).b; }
  bool is_constant(Node n) const { return graph_.is_constant(n); }
  double value(Node n) const { return graph_.data(n).value; }
  bool lone(Node n, Operation operation) const { return graph_.data(n).operation == operation && uses_[static_cast<std::size_t>(n)] == 1; }
  /// A lone operation on two operands of which none is a constant.
  bool lone_plain(Node n, Operation operation) const { return lone(n, operation) && !is_constant(left(n)) && !is_constant(right(n)); }
  /// A lone k + a (or a - k), whichever way round it was written.
  bool lone_shift(Node n, Node& a, double& k) const {
    if (lone(n, Operation::add) && (is_constant(left(n)) || is_constant(right(n)))) {
      const bool first = is_constant(left(n));
      a = first ? right(n) : left(n);
      k = value(first ? left(n) : right(n));
      return true;
    }
    if (lone(n, Operation::subtract) && is_constant(right(n))) {
      a = left(n);
      k = -value(right(n));
      return true;
    }
    return false;
  }
  bool lone_k_minus(Node n) const { return lone(n, Operation::subtract) && is_constant(left(n)); }

  Selected sum(Node x, Node y) const {
    if (is_constant(x)) std::swap(x, y);
    if (is_constant(y)) return {Code::add_k, {x}, value(y)};
    for (const auto& [p, q] : {std::pair(x, y), std::pair(y, x)}) {
      if (lone_plain(p, Operation::add)) return {Code::add_add, {left(p), right(p), q}};
      if (lone_plain(p, Operation::subtract)) return {Code::subtract_add, {left(p), right(p), q}};
      if (lone_k_minus(p)) return {Code::k_minus_add, {right(p), q}, value(left(p))};
    }
    return {Code::add, {x, y}};
  }

  Selected difference(Node x, Node y) const {
    if (is_constant(x)) return {Code::k_minus, {y}, value(x)};
    if (is_constant(y)) return {Code::add_k, {x}, -value(y)};
    if (lone_plain(x, Operation::add)) return {Code::add_subtract, {left(x), right(x), y}};
    if (lone_plain(x, Operation::subtract)) return {Code::subtract_subtract, {left(x), right(x), y}};
    if (lone_k_minus(x)) return {Code::k_minus_subtract, {right(x), y}, value(left(x))};
    if (lone_plain(y, Operation::add)) return {Code::minus_sum, {left(y), right(y), x}};
    if (lone_plain(y, Operation::subtract)) return {Code::minus_difference, {left(y), right(y), x}};
    return {Code::subtract, {x, y}};
  }

  Selected product(Node x, Node y) const {
    if (is_constant(y)) std::swap(x, y);
    if (is_constant(x)) return multiple(value(x), y);
    Node a = -1;
    double k = 0.0;
    for (const auto& [p, q] : {std::pair(x, y), std::pair(y, x)}) {
      if (lone_shift(p, a, k)) return {Code::multiply_k_plus, {a, q}, k};
      if (lone_k_minus(p)) return {Code::multiply_k_minus, {right(p), q}, value(left(p))};
      if (lone_plain(p, Operation::add)) return {Code::multiply_sum, {left(p), right(p), q}};
      if (lone_plain(p, Operation::subtract)) return {Code::multiply_difference, {left(p), right(p), q}};
      if (lone_plain(p, Operation::multiply)) return {Code::multiply_multiply, {left(p), right(p), q}};
    }
    return {Code::multiply, {x, y}};
  }

  Selected multiple(double k, Node y) const {
    Node a = -1;
    double l = 0.0;
    if (lone_shift(y, a, l)) return {Code::scale_k_plus, {a}, k, l};
    if (lone_k_minus(y)) return {Code::scale_k_minus, {right(y)}, k, value(left(y))};
    if (lone_plain(y, Operation::add)) return {Code::scale_sum, {left(y), right(y)}, k};
    if (lone_plain(y, Operation::subtract)) return {Code::scale_difference, {left(y), right(y)}, k};
    if (lone_plain(y, Operation::multiply)) return {Code::scale_product, {left(y), right(y)}, k};
    if (lone(y, Operation::multiply_add)) {
      const Selected inner = product_and_sum(left(y), right(y), graph_.data(y).c);
      if (inner.code == Code::fma) return {Code::scale_fma, {inner.operands[0], inner.operands[1], inner.operands[2]}, k};
    }
    return {Code::scale, {y}, k};
  }

  Selected quotient(Node x, Node y) const {
    Node a = -1;
    double l = 0.0;
    const bool shifted = lone_shift(y, a, l);
    if (is_constant(x)) return shifted ? Selected{Code::k_over_l_plus, {a}, value(x), l} : Selected{Code::k_over, {y}, value(x)};
    return shifted ? Selected{Code::over_k_plus, {x, a}, l} : Selected{Code::divide, {x, y}};
  }

  Selected product_and_sum(Node x, Node y, Node z) const {
    if (is_constant(y)) std::swap(x, y);
    const bool subtracts = lone(z, Operation::negate);
    if (is_constant(x)) {
      if (is_constant(z)) return {Code::fma_k_to_l, {y}, value(x), value(z)};
      if (subtracts) return {Code::fms_k, {y, -1, left(z)}, value(x)};
      return {Code::fma_k, {y, -1, z}, value(x)};
    }
    if (lone(y, Operation::negate)) std::swap(x, y);
    if (lone(x, Operation::negate)) {
      if (is_constant(z)) return {Code::fnma_to_k, {left(x), y}, value(z)};
      return {Code::fnma, {left(x), y, z}};
    }
    if (is_constant(z)) return {Code::fma_to_k, {x, y}, value(z)};
    if (subtracts) return {Code::fms, {x, y, left(z)}};
    return {Code::fma, {x, y, z}};
  }

  Selected choice(Node condition, Node yes, Node no) const {
    const Node a = left(condition);
    const Node b = right(condition);
    if (lone(condition, Operation::less)) return {Code::select_if_less, {a, b, yes, no}};
    if (lone(condition, Operation::greater)) return {Code::select_if_less, {b, a, yes, no}};
    if (lone(condition, Operation::less_equal)) return {Code::select_if_less_equal, {a, b, yes, no}};
    if (lone(condition, Operation::greater_equal)) return {Code::select_if_less_equal, {b, a, yes, no}};
    if (lone(condition, Operation::equal)) return {Code::select_if_equal, {a, b, yes, no}};
    if (lone(condition, Operation::not_equal)) return {Code::select_if_not_equal, {a, b, yes, no}};
    return {Code::select, {condition, yes, no}};
  }

  const ExpressionGraph& graph_;
  std::vector<int> uses_;
};

/// The nodes that become instructions, in an order of evaluation: outputs one after the other, each with what it still lacks.
std::vector<std::pair<Node, Selected>> schedule(const ExpressionGraph& graph, const std::vector<Node>& outputs) {
  const Selection selection(graph, outputs);
  std::vector<std::pair<Node, Selected>> order;
  std::set<Node> begun;
  struct Visit {
    Node node;
    Selected selected;
    std::size_t next;
  };
  std::vector<Visit> stack;
  const auto begin = [&](Node n) {
    if (n < 0 || graph.data(n).operation == Operation::variable || !begun.insert(n).second) return;
    stack.push_back({n, selection.select(n), 0});
  };
  for (Node output : outputs) {
    if (graph.is_constant(output)) continue;
    begin(output);
    while (!stack.empty()) {
      Visit& visit = stack.back();
      if (visit.next < visit.selected.operands.size()) {
        begin(visit.selected.operands[visit.next++]);
        continue;
      }
      order.emplace_back(visit.node, visit.selected);
      stack.pop_back();
    }
  }
  return order;
}

std::uint16_t narrow(std::size_t n) {
  if (n > std::numeric_limits<std::uint16_t>::max()) {
    throw Error(ErrorKind::input, "the expressions and their derivatives are too large");
  }
  return static_cast<std::uint16_t>(n);
}

}  // namespace

ExpressionProgram::ExpressionProgram(const ExpressionGraph& graph, const std::vector<ExpressionGraph::Node>& outputs)
    : uses_input_(static_cast<std::size_t>(graph.n_variables()), false), n_registers_(graph.n_variables()) {
  const std::vector<std::pair<Node, Selected>> order = schedule(graph, outputs);

  // Inputs have the first registers, for good.
  std::map<Node, int> register_of;
  for (Node n : graph.reachable(outputs)) {
    if (graph.data(n).operation != Operation::variable) continue;
    const int k = static_cast<int>(graph.data(n).value);
    uses_input_[static_cast<std::size_t>(k)] = true;
    register_of[n] = k;
  }

  constexpr std::size_t never = std::numeric_limits<std::size_t>::max();
  std::map<Node, std::size_t> last_use;
  for (std::size_t i = 0; i < order.size(); ++i) {
    for (Node operand : order[i].second.operands) {
      if (operand >= 0) last_use[operand] = i;
    }
  }
  for (Node output : outputs) last_use[output] = never;

  std::map<std::uint64_t, std::uint16_t> known_constants;  // by their bits: -0 is not 0
  const auto constant = [&](double value) {
    const auto [place, fresh] = known_constants.try_emplace(std::bit_cast<std::uint64_t>(value), narrow(constants_.size()));
    if (fresh) constants_.push_back(value);
    return place->second;
  };

  std::priority_queue<int, std::vector<int>, std::greater<>> free;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const auto& [node, selected] = order[i];
    std::array<std::uint16_t, 4> operands{};
    for (std::size_t o = 0; o < operands.size(); ++o) {
      if (selected.operands[o] >= 0) operands[o] = narrow(static_cast<std::size_t>(register_of.at(selected.operands[o])));
    }
    for (std::size_t o = 0; o < operands.size(); ++o) {
      const Node operand = selected.operands[o];
      if (operand < 0 || last_use.at(operand) != i || operands[o] < graph.n_variables()) continue;
      const auto same = std::find(selected.operands.begin(), selected.operands.end(), operand);
      if (same == selected.operands.begin() + static_cast<std::ptrdiff_t>(o)) free.push(operands[o]);
    }
    int result = n_registers_;
    if (free.empty()) {
      ++n_registers_;
    } else {
      result = free.top();
      free.pop();
    }
    register_of[node] = result;
    Instruction instruction{selected.code, narrow(static_cast<std::size_t>(result)), operands[0], operands[1], operands[2], 0, 0};
    if (selected.operands[3] >= 0) {
      instruction.k = operands[3];
    } else {
      instruction.k = constant(selected.k);
      instruction.l = constant(selected.l);
    }
    instructions_.push_back(instruction);
  }
  std::map<Node, std::uint16_t> constant_register;
  for (Node output : outputs) {
    if (!graph.is_constant(output)) {
      outputs_.push_back(narrow(static_cast<std::size_t>(register_of.at(output))));
      continue;
    }
    const auto [place, fresh] = constant_register.try_emplace(output, narrow(static_cast<std::size_t>(n_registers_)));
    if (fresh) {
      constant_outputs_.push_back({place->second, graph.data(output).value});
      ++n_registers_;
    }
    outputs_.push_back(place->second);
  }
}

}  // namespace stiffront
