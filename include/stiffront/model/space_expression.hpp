// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <map>
#include <memory>
#include <string>

#include "stiffront/mesh/field.hpp"
#include "stiffront/model/expression_program.hpp"

namespace stiffront {

/// A function of time and place written as an expression in t, x, y and parameters: initial and boundary data. It converts to
/// std::function<double(double t, double x, double y)>.
///
/// Operations are carried out as written, each rounded once, in double precision, so that x < 0.5 means the same here as anywhere
/// else; the same on every rank.
class SpaceExpression {
 public:
  /// @throws ExpressionError
  SpaceExpression(const NumberOrText& value, const std::map<std::string, double>& parameters);

  double operator()(double t, double x, double y) const;
  bool depends_on_time() const { return program_->uses_input(0); }

 private:
  std::shared_ptr<const ExpressionProgram> program_;
};

/// The value of an expression of parameters alone. @throws ExpressionError
double constant_expression(const NumberOrText& value, const std::map<std::string, double>& parameters);

/// Sets the interior of one species to the expression at time t, at the grid's own coordinates (Grid::position).
void evaluate(const SpaceExpression& expression, double t, Field& u, int species);

}  // namespace stiffront
