// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/model/expression.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

namespace stiffront {

namespace {

/// The number of characters up to and including the one at a byte; UTF-8's continuation bytes do not begin one.
int column_of(const std::string& text, std::size_t at) {
  const auto begins = [](char c) { return (static_cast<unsigned char>(c) & 0xc0U) != 0x80U; };
  return 1 + static_cast<int>(std::count_if(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), begins));
}

}  // namespace

ExpressionError::ExpressionError(const std::string& text, std::size_t at, const std::string& message)
    : ExpressionError(column_of(text, at), message) {}

ExpressionError::ExpressionError(int column, const std::string& message)
    : Error(ErrorKind::input, fmt::format("column {}: {}", column, message)), column_(column) {}

namespace {

using Node = ExpressionGraph::Node;

// A model of eight species with all derivatives has some thousands.
constexpr std::size_t max_nodes = 300'000;

// Beyond it a product of many factors is slower than pow().
constexpr double largest_expanded_power = 64.0;

double fold(Operation operation, double a, double b, double c) {
  switch (operation) {
    case Operation::add:
      return a + b;
    case Operation::subtract:
      return a - b;
    case Operation::multiply:
      return a * b;
    case Operation::divide:
      return a / b;
    case Operation::negate:
      return -a;
    case Operation::multiply_add:
      return a * b + c;
    case Operation::power:
      return std::pow(a, b);
    case Operation::minimum:
      return a < b ? a : b;
    case Operation::maximum:
      return a > b ? a : b;
    case Operation::absolute:
      return std::abs(a);
    case Operation::square_root:
      return std::sqrt(a);
    case Operation::exponential:
      return std::exp(a);
    case Operation::logarithm:
      return std::log(a);
    case Operation::logarithm10:
      return std::log10(a);
    case Operation::sine:
      return std::sin(a);
    case Operation::cosine:
      return std::cos(a);
    case Operation::tangent:
      return std::tan(a);
    case Operation::arc_sine:
      return std::asin(a);
    case Operation::arc_cosine:
      return std::acos(a);
    case Operation::arc_tangent:
      return std::atan(a);
    case Operation::hyperbolic_sine:
      return std::sinh(a);
    case Operation::hyperbolic_cosine:
      return std::cosh(a);
    case Operation::hyperbolic_tangent:
      return std::tanh(a);
    case Operation::less:
      return a < b ? 1.0 : 0.0;
    case Operation::less_equal:
      return a <= b ? 1.0 : 0.0;
    case Operation::greater:
      return a > b ? 1.0 : 0.0;
    case Operation::greater_equal:
      return a >= b ? 1.0 : 0.0;
    case Operation::equal:
      return a == b ? 1.0 : 0.0;
    case Operation::not_equal:
      return a != b ? 1.0 : 0.0;
    case Operation::select:
      return a != 0.0 ? b : c;
    case Operation::constant:
    case Operation::variable:
      break;
  }
  throw Error(ErrorKind::bug, "an operation without a value was folded");
}

}  // namespace

ExpressionGraph::ExpressionGraph(std::vector<std::string> variables) : variables_(std::move(variables)) {}

Node ExpressionGraph::intern(NodeData d) {
  const auto key = std::make_tuple(d.operation, d.a, d.b, d.c, std::bit_cast<std::uint64_t>(d.value));
  const auto known = known_.find(key);
  if (known != known_.end()) return known->second;
  if (nodes_.size() >= max_nodes) throw Error(ErrorKind::input, "the expressions and their derivatives are too large");
  nodes_.push_back(d);
  return known_[key] = static_cast<Node>(nodes_.size()) - 1;
}

Node ExpressionGraph::parse_value(const NumberOrText& value, const std::map<std::string, double>& constants) {
  const double* number = std::get_if<double>(&value);
  if (number == nullptr) return parse(std::get<std::string>(value), constants);
  if (!std::isfinite(*number)) throw ExpressionError("", 0, "this is not a finite number");
  return constant(*number);
}

Node ExpressionGraph::constant(double value) { return intern({Operation::constant, -1, -1, -1, value}); }
Node ExpressionGraph::variable(int k) { return intern({Operation::variable, -1, -1, -1, static_cast<double>(k)}); }

Node ExpressionGraph::integer_power(Node a, int n) {
  Node result = -1;
  Node square = a;
  for (int k = n; k > 0; k /= 2) {
    if (k % 2 == 1) result = result < 0 ? square : make(Operation::multiply, result, square);
    if (k > 1) square = make(Operation::multiply, square, square);
  }
  return result;
}

/// Small integer powers by multiplication: exact signs for negative bases, and cheap.
Node ExpressionGraph::power(Node a, Node b) {
  if (is_constant(b)) {
    const double p = data(b).value;
    if (p == 0.0) return constant(1.0);
    if (p == 0.5) return make(Operation::square_root, a);
    if (p == std::nearbyint(p) && std::abs(p) <= largest_expanded_power) {
      const Node product = integer_power(a, static_cast<int>(std::abs(p)));
      return p > 0.0 ? product : make(Operation::divide, constant(1.0), product);
    }
  }
  return intern({Operation::power, a, b, -1, 0.0});
}

Node ExpressionGraph::make(Operation operation, Node a, Node b, Node c) {
  const auto constant_or_absent = [&](Node n) { return n < 0 || is_constant(n); };
  const auto value = [&](Node n) { return n < 0 ? 0.0 : data(n).value; };
  if (constant_or_absent(a) && constant_or_absent(b) && constant_or_absent(c)) {
    return constant(fold(operation, value(a), value(b), value(c)));
  }
  const auto is_negation = [&](Node n) { return data(n).operation == Operation::negate; };
  switch (operation) {
    case Operation::add:
      if (is_constant(a, 0.0)) return b;
      if (is_constant(b, 0.0)) return a;
      if (is_negation(b)) return make(Operation::subtract, a, data(b).a);
      if (is_negation(a)) return make(Operation::subtract, b, data(a).a);
      if (a > b) std::swap(a, b);  // one node for both orders
      break;
    case Operation::subtract:
      if (is_constant(b, 0.0)) return a;
      if (is_constant(a, 0.0)) return make(Operation::negate, b);
      if (is_negation(b)) return make(Operation::add, a, data(b).a);
      if (a == b) return constant(0.0);
      break;
    case Operation::multiply:
      if (is_constant(a, 0.0) || is_constant(b, 0.0)) return constant(0.0);
      if (is_constant(a, 1.0)) return b;
      if (is_constant(b, 1.0)) return a;
      if (is_constant(a, -1.0)) return make(Operation::negate, b);
      if (is_constant(b, -1.0)) return make(Operation::negate, a);
      if (a > b) std::swap(a, b);
      break;
    case Operation::divide:
      if (is_constant(a, 0.0)) return constant(0.0);
      if (is_constant(b, 1.0)) return a;
      if (is_constant(b, -1.0)) return make(Operation::negate, a);
      break;
    case Operation::negate:
      if (is_negation(a)) return data(a).a;
      break;
    case Operation::power:
      return power(a, b);
    case Operation::select:
      if (is_constant(a)) return data(a).value != 0.0 ? b : c;
      if (b == c) return b;
      break;
    default:
      break;
  }
  return intern({operation, a, b, c, 0.0});
}

std::vector<Node> ExpressionGraph::reachable(const std::vector<Node>& roots) const {
  if (roots.empty()) return {};
  Node top = 0;
  for (Node root : roots) top = root > top ? root : top;
  std::vector<bool> needed(static_cast<std::size_t>(top) + 1, false);
  for (Node root : roots) needed[static_cast<std::size_t>(root)] = true;
  std::vector<Node> found;
  for (Node n = top; n >= 0; --n) {
    if (!needed[static_cast<std::size_t>(n)]) continue;
    found.push_back(n);
    for (Node operand : {data(n).a, data(n).b, data(n).c}) {
      if (operand >= 0) needed[static_cast<std::size_t>(operand)] = true;
    }
  }
  return {found.rbegin(), found.rend()};
}

bool ExpressionGraph::depends_on(Node node, int k) const {
  for (Node n : reachable({node})) {
    if (data(n).operation == Operation::variable && static_cast<int>(data(n).value) == k) return true;
  }
  return false;
}

}  // namespace stiffront
