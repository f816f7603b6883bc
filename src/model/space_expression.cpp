// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/model/space_expression.hpp"

namespace stiffront {

SpaceExpression::SpaceExpression(const NumberOrText& value, const std::map<std::string, double>& parameters) {
  ExpressionGraph graph({"t", "x", "y"});
  program_ = std::make_shared<const ExpressionProgram>(graph, std::vector<ExpressionGraph::Node>{graph.parse_value(value, parameters)});
}

double SpaceExpression::operator()(double t, double x, double y) const {
  ExpressionProgram::Frame<double, 1> frame(*program_);
  frame.input(0) = t;
  frame.input(1) = x;
  frame.input(2) = y;
  frame.run();
  return frame.output(0);
}

double constant_expression(const NumberOrText& value, const std::map<std::string, double>& parameters) {
  ExpressionGraph graph({});
  return graph.data(graph.parse_value(value, parameters)).value;  // nothing varies, so it has been folded
}

void evaluate(const SpaceExpression& expression, double t, Field& u, int species) {
  const Decomposition& d = u.decomposition();
  const Grid& grid = d.grid();
  for (int j = 0; j < u.n_y(); ++j) {
    const double y = grid.dimension == 2 ? grid.position(1, d.offset_y() + j) : 0.0;
    for (int i = 0; i < u.n_x(); ++i) u.at(species, i, j) = expression(t, grid.position(0, d.offset_x() + i), y);
  }
}

}  // namespace stiffront
