// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/model/expression_contraction.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace stiffront {
namespace {

using Node = ExpressionGraph::Node;

/// Constants may be merged if neither overflow nor underflow enters that was not there before.
bool is_ordinary(double k) { return std::abs(k) > 1e-290 && std::abs(k) < 1e290; }

/// The nodes of a graph made anew, operands first, by a rule; some are left alone.
class Rewriting {
 public:
  Rewriting(ExpressionGraph& graph, const std::vector<Node>& roots, const std::vector<Node>& kept)
      : graph_(graph), roots_(roots), kept_(graph.reachable(kept)) {}

  template <class Rule>
  std::vector<Node> apply(Rule rule) {
    std::map<Node, Node> made;
    const auto of = [&](Node operand) { return operand < 0 ? -1 : made.at(operand); };
    for (Node n : graph_.reachable(roots_)) {
      const ExpressionGraph::NodeData d = graph_.data(n);
      const bool alone = d.a < 0 || std::binary_search(kept_.begin(), kept_.end(), n);
      made[n] = alone ? n : rule(n, d.operation, of(d.a), of(d.b), of(d.c));
    }
    std::vector<Node> result;
    for (Node root : roots_) result.push_back(made.at(root));
    return result;
  }

 private:
  ExpressionGraph& graph_;
  const std::vector<Node>& roots_;
  std::vector<Node> kept_;
};

/// Gathers constant factors and signs.
class Factors {
 public:
  explicit Factors(ExpressionGraph& graph) : graph_(graph) {}

  Node make(Operation operation, Node a, Node b, Node c) {
    switch (operation) {
      case Operation::multiply:
        return product(a, b);
      case Operation::divide:
        return quotient(a, b);
      case Operation::negate:
        return negative(a);
      default:
        return graph_.make(operation, a, b, c);
    }
  }

 private:
  bool is(Node n, Operation operation) const { return graph_.data(n).operation == operation; }
  double value(Node n) const { return graph_.data(n).value; }

  Node product(Node a, Node b) {
    if (graph_.is_constant(b)) return scaled(value(b), a);
    if (graph_.is_constant(a)) return scaled(value(a), b);
    if (is(a, Operation::negate)) return negative(product(graph_.data(a).a, b));
    if (is(b, Operation::negate)) return negative(product(a, graph_.data(b).a));
    return graph_.make(Operation::multiply, a, b);
  }

  /// k a, with k merged into a factor that a has.
  Node scaled(double k, Node a) {
    const ExpressionGraph::NodeData d = graph_.data(a);
    if (d.operation == Operation::negate) return scaled(-k, d.a);
    if (d.operation == Operation::multiply) {
      for (const auto& [constant, other] : {std::pair(d.a, d.b), std::pair(d.b, d.a)}) {
        if (!graph_.is_constant(constant)) continue;
        const double merged = k * value(constant);
        if (is_ordinary(merged)) return graph_.make(Operation::multiply, graph_.constant(merged), other);
      }
    }
    if (d.operation == Operation::divide && graph_.is_constant(d.a)) {
      const double merged = k * value(d.a);
      if (is_ordinary(merged)) return graph_.make(Operation::divide, graph_.constant(merged), d.b);
    }
    return graph_.make(Operation::multiply, graph_.constant(k), a);
  }

  Node quotient(Node a, Node b) {
    if (graph_.is_constant(b)) {
      const double reciprocal = 1.0 / value(b);
      if (is_ordinary(reciprocal)) return product(a, graph_.constant(reciprocal));
    }
    if (is(b, Operation::negate)) return negative(quotient(a, graph_.data(b).a));
    if (is(a, Operation::negate)) return negative(quotient(graph_.data(a).a, b));
    return graph_.make(Operation::divide, a, b);
  }

  Node negative(Node a) {
    const ExpressionGraph::NodeData d = graph_.data(a);
    if (d.operation == Operation::subtract) return graph_.make(Operation::subtract, d.b, d.a);
    const bool has_factor = (d.operation == Operation::multiply && (graph_.is_constant(d.a) || graph_.is_constant(d.b))) ||
                            (d.operation == Operation::divide && graph_.is_constant(d.a));
    return has_factor ? scaled(-1.0, a) : graph_.make(Operation::negate, a);
  }

  ExpressionGraph& graph_;
};

/// a*b + c instead of a product and a sum, where nothing else needs the product.
std::vector<Node> fuse(ExpressionGraph& graph, const std::vector<Node>& roots, const std::vector<Node>& kept) {
  std::map<Node, int> uses;
  for (Node root : roots) ++uses[root];
  for (Node n : graph.reachable(roots)) {
    const ExpressionGraph::NodeData& d = graph.data(n);
    for (Node operand : {d.a, d.b, d.c}) {
      if (operand >= 0) ++uses[operand];
    }
  }
  return Rewriting(graph, roots, kept).apply([&](Node n, Operation operation, Node a, Node b, Node c) {
    if (operation != Operation::add && operation != Operation::subtract) return graph.make(operation, a, b, c);
    const ExpressionGraph::NodeData old = graph.data(n);
    // Made anew, an operand may have become something else than the product it was.
    const auto is_lone_product = [&](Node before, Node now) {
      return graph.data(now).operation == Operation::multiply && uses.at(before) == 1;
    };
    const auto fused = [&](Node product, Node rest, bool negated) {
      Node left = graph.data(product).a;
      Node right = graph.data(product).b;
      if (graph.is_constant(right)) std::swap(left, right);
      if (negated) left = graph.make(Operation::negate, left);
      return graph.make(Operation::multiply_add, left, right, rest);
    };
    if (is_lone_product(old.b, b)) return fused(b, a, operation == Operation::subtract);
    if (is_lone_product(old.a, a)) return fused(a, operation == Operation::add ? b : graph.make(Operation::negate, b), false);
    return graph.make(operation, a, b, c);
  });
}

}  // namespace

std::vector<Node> contract(ExpressionGraph& graph, const std::vector<Node>& roots, const std::vector<Node>& kept) {
  Factors factors(graph);
  const std::vector<Node> gathered = Rewriting(graph, roots, kept).apply([&](Node, Operation operation, Node a, Node b, Node c) {
    return factors.make(operation, a, b, c);
  });
  return fuse(graph, gathered, kept);
}

}  // namespace stiffront
