// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "stiffront/core/spelling.hpp"
#include "stiffront/model/reaction_network.hpp"

namespace stiffront {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }

constexpr std::size_t max_length = 10'000;
constexpr int max_digits = 9;

class EquationParser {
 public:
  EquationParser(const std::string& text, const std::vector<std::string>& species) : text_(text), species_(species) {}

  ReactionEquation parse() {
    if (text_.size() > max_length) fail_at(0, fmt::format("the equation has more than {} characters", max_length));
    ReactionEquation equation;
    equation.left = side();
    arrow(equation);
    equation.right = side();
    if (!at_end()) fail("expected +, or the end of the equation");
    return equation;
  }

 private:
  [[noreturn]] void fail(const std::string& message) const { fail_at(at_, message); }
  [[noreturn]] void fail_at(std::size_t at, const std::string& message) const { throw ExpressionError(text_, at, message); }

  bool at_end() {
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t' || text_[at_] == '\n' || text_[at_] == '\r')) ++at_;
    return at_ >= text_.size();
  }
  bool take(std::string_view token) {
    if (at_end() || text_.compare(at_, token.size(), token) != 0) return false;
    at_ += token.size();
    return true;
  }

  void arrow(ReactionEquation& equation) {
    if (at_end()) fail("an arrow is missing: -> or <->");
    equation.reversible = take("<->");
    if (equation.reversible || take("->")) return;
    fail(is_letter(text_[at_]) || is_digit(text_[at_]) ? "expected + or an arrow, -> or <->"
                                                       : "expected an arrow: -> for one direction, <-> for both");
  }

  std::vector<Rational> side() {
    std::vector<Rational> coefficients(species_.size());
    if (at_end() || !(is_digit(text_[at_]) || text_[at_] == '.' || is_letter(text_[at_]))) return coefficients;
    do {
      term(coefficients);
    } while (take("+"));
    return coefficients;
  }

  void term(std::vector<Rational>& coefficients) {
    if (at_end()) fail("a species is missing");
    Rational coefficient(1);
    const std::size_t start = at_;
    if (is_digit(text_[at_]) || text_[at_] == '.') {
      coefficient = number();
      const bool star = take("*");
      if (!star && coefficient == Rational(0)) return;  // "0": nothing
      if (coefficient == Rational(0)) fail_at(start, "a coefficient must be positive");
    }
    if (at_end() || !is_letter(text_[at_])) fail("a species is missing");
    const std::size_t name_start = at_;
    while (at_ < text_.size() && (is_letter(text_[at_]) || is_digit(text_[at_]))) ++at_;
    const std::string name = text_.substr(name_start, at_ - name_start);
    const auto found = std::find(species_.begin(), species_.end(), name);
    if (found == species_.end()) {
      fail_at(name_start, fmt::format("unknown species \"{}\"{}", name, with_allowed(suggestion(name, species_), "", species_)));
    }
    Rational& entry = coefficients[static_cast<std::size_t>(found - species_.begin())];
    entry = entry + coefficient;
  }

  /// An integer or a decimal fraction, exactly.
  Rational number() {
    const std::size_t start = at_;
    std::int64_t digits = 0;
    std::int64_t scale = 1;
    int count = 0;
    bool fraction = false;
    for (; at_ < text_.size() && (is_digit(text_[at_]) || (text_[at_] == '.' && !fraction)); ++at_) {
      if (text_[at_] == '.') {
        fraction = true;
        continue;
      }
      if (++count > max_digits) fail_at(start, fmt::format("a coefficient has at most {} digits", max_digits));
      digits = 10 * digits + (text_[at_] - '0');
      if (fraction) scale *= 10;
    }
    if (count == 0) fail_at(start, "a coefficient needs a digit");
    return {digits, scale};
  }

  const std::string& text_;
  const std::vector<std::string>& species_;
  std::size_t at_ = 0;
};

}  // namespace

ReactionEquation parse_reaction_equation(const std::string& text, const std::vector<std::string>& species) {
  return EquationParser(text, species).parse();
}

}  // namespace stiffront
