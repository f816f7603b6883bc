// SPDX-License-Identifier: BSD-3-Clause
#include <numbers>
#include <utility>

#include "stiffront/model/expression.hpp"

namespace stiffront {

using Node = ExpressionGraph::Node;

Node ExpressionGraph::differentiate(Node node, int k) {
  // Operands come first, so each derivative finds those it is made of.
  for (Node n : reachable({node})) {
    if (!derivatives_.contains({k, n})) derivatives_[{k, n}] = derivative_of(n, k);
  }
  return derivatives_.at({k, node});
}

Node ExpressionGraph::derivative_of(Node node, int k) {
  const NodeData d = data(node);
  const Node zero = constant(0.0);
  const Node one = constant(1.0);
  if (d.operation == Operation::variable) return static_cast<int>(d.value) == k ? one : zero;
  const auto of = [&](Node operand) { return operand < 0 ? zero : derivatives_.at({k, operand}); };
  const Node da = of(d.a);
  const Node db = of(d.b);
  const Node dc = of(d.c);
  // Whatever does not vary has the derivative 0, even where a formula below would make a NaN of it.
  if (da == zero && db == zero && dc == zero) return zero;

  const auto plus = [&](Node a, Node b) { return make(Operation::add, a, b); };
  const auto minus = [&](Node a, Node b) { return make(Operation::subtract, a, b); };
  const auto times = [&](Node a, Node b) { return make(Operation::multiply, a, b); };
  const auto over = [&](Node a, Node b) { return make(Operation::divide, a, b); };
  const auto negative = [&](Node a) { return make(Operation::negate, a); };
  const auto function = [&](Operation f, Node a) { return make(f, a); };
  const auto cosine_of_arc = [&] { return function(Operation::square_root, minus(one, times(d.a, d.a))); };
  switch (d.operation) {
    case Operation::add:
      return plus(da, db);
    case Operation::subtract:
      return minus(da, db);
    case Operation::multiply:
      return plus(times(da, d.b), times(d.a, db));
    case Operation::divide:
      return over(minus(da, times(node, db)), d.b);
    case Operation::negate:
      return negative(da);
    case Operation::multiply_add:
      return plus(plus(times(da, d.b), times(d.a, db)), dc);
    case Operation::power: {
      // d(a^b) = b a^(b-1) da + a^b log(a) db
      Node by_base = times(d.b, make(Operation::power, d.a, minus(d.b, one)));
      if (is_constant(d.b) && data(d.b).value > 0.0 && data(d.b).value < 1.0) {
        by_base = make(Operation::select, make(Operation::equal, d.a, zero), zero, by_base);
      }
      const Node by_exponent =
          make(Operation::select, make(Operation::greater, d.a, zero), times(node, function(Operation::logarithm, d.a)), zero);
      return plus(times(by_base, da), times(by_exponent, db));
    }
    case Operation::minimum:
      return make(Operation::select, make(Operation::less, d.a, d.b), da, db);
    case Operation::maximum:
      return make(Operation::select, make(Operation::greater, d.a, d.b), da, db);
    case Operation::absolute:
      return make(Operation::select, make(Operation::less, d.a, zero), negative(da), da);
    case Operation::square_root:
      return make(Operation::select, make(Operation::equal, node, zero), zero, over(times(constant(0.5), da), node));
    case Operation::exponential:
      return times(node, da);
    case Operation::logarithm:
      return over(da, d.a);
    case Operation::logarithm10:
      return over(times(constant(1.0 / std::numbers::ln10), da), d.a);
    case Operation::sine:
      return times(function(Operation::cosine, d.a), da);
    case Operation::cosine:
      return negative(times(function(Operation::sine, d.a), da));
    case Operation::tangent:
      return times(plus(one, times(node, node)), da);
    case Operation::arc_sine:
      return over(da, cosine_of_arc());
    case Operation::arc_cosine:
      return negative(over(da, cosine_of_arc()));
    case Operation::arc_tangent:
      return over(da, plus(one, times(d.a, d.a)));
    case Operation::hyperbolic_sine:
      return times(function(Operation::hyperbolic_cosine, d.a), da);
    case Operation::hyperbolic_cosine:
      return times(function(Operation::hyperbolic_sine, d.a), da);
    case Operation::hyperbolic_tangent:
      return times(minus(one, times(node, node)), da);
    case Operation::select:
      return make(Operation::select, d.a, db, dc);
    case Operation::constant:
    case Operation::variable:
    case Operation::less:
    case Operation::less_equal:
    case Operation::greater:
    case Operation::greater_equal:
    case Operation::equal:
    case Operation::not_equal:
      break;
  }
  return zero;
}

}  // namespace stiffront
