// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include "stiffront/core/error.hpp"

namespace stiffront {

/// A mistake in an expression, with the column (in characters, from 1) at which it was noticed.
class ExpressionError : public Error {
 public:
  /// @param at index of the byte of `text` at which it was noticed
  ExpressionError(const std::string& text, std::size_t at, const std::string& message);
  int column() const { return column_; }

 private:
  ExpressionError(int column, const std::string& message);

  int column_;
};

enum class Operation : std::uint8_t {
  constant,
  variable,
  add,
  subtract,
  multiply,
  divide,
  negate,
  multiply_add,  // multiply_add: a*b + c, rounded once where the target can
  power,
  minimum,
  maximum,
  absolute,
  square_root,
  exponential,
  logarithm,
  logarithm10,
  sine,
  cosine,
  tangent,
  arc_sine,
  arc_cosine,
  arc_tangent,
  hyperbolic_sine,
  hyperbolic_cosine,
  hyperbolic_tangent,
  less,
  less_equal,
  greater,
  greater_equal,
  equal,
  not_equal,  // 1 or 0
  select,     // a != 0 ? b : c
};

/// A number, or an expression that gives one.
using NumberOrText = std::variant<double, std::string>;

/// Expressions over named variables as a graph in which equal parts are one node: arithmetic on constants is done when a node is
/// made, derivatives are graphs again, and an ExpressionProgram evaluates any set of nodes together.
///
/// A node's operands have smaller numbers than the node, so ascending order is an order of evaluation, and no algorithm on the
/// graph needs recursion. Simplifications keep every value that is finite: 0*a is 0 even where a is not finite.
///
/// Grammar: docs/custom-models.md. Names given as constants or variables hide the constants pi and e.
class ExpressionGraph {
 public:
  using Node = int;

  /// @param variables their names; variable k is the k-th input of a program.
  explicit ExpressionGraph(std::vector<std::string> variables);

  /// @param constants named numbers (parameters).
  /// @throws ExpressionError with column and remedy: bad syntax, unknown names, and parts that can have no finite value.
  Node parse(const std::string& text, const std::map<std::string, double>& constants);
  Node parse_value(const NumberOrText& value, const std::map<std::string, double>& constants);
  /// The partial derivative by a variable. Comparisons count as locally constant; abs, min and max have one-sided derivatives.
  /// The derivatives of sqrt(a) and of a^p, 0 < p < 1, at a = 0 are taken as 0, so that they are finite.
  Node differentiate(Node node, int variable);
  bool depends_on(Node node, int variable) const;
  /// All nodes needed for these, in ascending order.
  std::vector<Node> reachable(const std::vector<Node>& roots) const;

  Node constant(double value);
  Node variable(int k);
  /// @throws Error(input) when the graph has grown beyond any sensible model.
  Node make(Operation operation, Node a, Node b = -1, Node c = -1);

  struct NodeData {
    Operation operation;
    Node a, b, c;  // -1: none
    double value;  // of a constant; the number of a variable
  };
  const NodeData& data(Node node) const { return nodes_[static_cast<std::size_t>(node)]; }
  bool is_constant(Node node) const { return data(node).operation == Operation::constant; }
  bool is_constant(Node node, double value) const { return is_constant(node) && data(node).value == value; }
  int n_variables() const { return static_cast<int>(variables_.size()); }
  const std::vector<std::string>& variables() const { return variables_; }

 private:
  Node intern(NodeData d);
  Node integer_power(Node a, int n);
  Node power(Node a, Node b);
  Node derivative_of(Node node, int variable);

  std::vector<std::string> variables_;
  std::vector<NodeData> nodes_;
  std::map<std::tuple<Operation, Node, Node, Node, std::uint64_t>, Node> known_;
  std::map<std::pair<int, Node>, Node> derivatives_;
};

}  // namespace stiffront
