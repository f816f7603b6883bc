// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <numbers>
#include <string_view>
#include <utility>

#include "stiffront/core/spelling.hpp"
#include "stiffront/model/expression.hpp"

namespace stiffront {
namespace {

using Node = ExpressionGraph::Node;

struct Function {
  const char* name;
  int arguments;
  Operation operation;
};

constexpr Function functions[] = {
    {"if", 3, Operation::select},
    {"min", 2, Operation::minimum},
    {"max", 2, Operation::maximum},
    {"pow", 2, Operation::power},
    {"abs", 1, Operation::absolute},
    {"sqrt", 1, Operation::square_root},
    {"exp", 1, Operation::exponential},
    {"log", 1, Operation::logarithm},
    {"log10", 1, Operation::logarithm10},
    {"sin", 1, Operation::sine},
    {"cos", 1, Operation::cosine},
    {"tan", 1, Operation::tangent},
    {"asin", 1, Operation::arc_sine},
    {"acos", 1, Operation::arc_cosine},
    {"atan", 1, Operation::arc_tangent},
    {"sinh", 1, Operation::hyperbolic_sine},
    {"cosh", 1, Operation::hyperbolic_cosine},
    {"tanh", 1, Operation::hyperbolic_tangent},
};
constexpr const char* arrhenius_name = "arrhenius";
constexpr double gas_constant = 8.31446261815324;  // J/(mol K), exact in the SI of 2019

constexpr std::size_t max_length = 100'000;

// The character class functions of the C library depend on the locale.
bool is_space(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool continues_character(char c) { return (static_cast<unsigned char>(c) & 0xc0U) == 0x80U; }  // UTF-8

/// Recursive descent over one expression.
class Parser {
 public:
  Parser(ExpressionGraph& graph, const std::string& text, const std::map<std::string, double>& constants)
      : graph_(graph), text_(text), constants_(constants) {}

  Node parse() {
    if (text_.size() > max_length) fail_at(0, fmt::format("the expression has more than {} characters", max_length));
    const Node n = disjunction();
    if (!at_end()) {
      const bool product = is_letter(text_[at_]) || is_digit(text_[at_]) || text_[at_] == '(';
      fail(fmt::format("unexpected {}; expected an operator or the end of the expression{}", character(),
                       product ? "; a product is written with *" : ""));
    }
    refuse_nonsense(n);
    return n;
  }

 private:
  // Deep nesting must not exhaust the stack.
  static constexpr int max_depth = 200;

  struct Deeper {
    explicit Deeper(Parser& p) : parser(p) {
      if (p.depth_ >= max_depth) p.fail("the expression is nested too deeply");
      ++p.depth_;
    }
    ~Deeper() { --parser.depth_; }
    Deeper(const Deeper&) = delete;
    Deeper& operator=(const Deeper&) = delete;
    Parser& parser;
  };

  [[noreturn]] void fail(const std::string& message) const { fail_at(at_, message); }
  [[noreturn]] void fail_at(std::size_t at, const std::string& message) const { throw ExpressionError(text_, at, message); }

  /// The character here, whole and printable.
  std::string character() const {
    std::size_t end = at_ + 1;
    while (end < text_.size() && continues_character(text_[end])) ++end;
    const auto first = static_cast<unsigned char>(text_[at_]);
    if (first < 0x20 || first == 0x7f || continues_character(text_[at_])) return fmt::format("character of code {}", first);
    return fmt::format("\"{}\"", text_.substr(at_, end - at_));
  }

  /// Skips space.
  bool at_end() {
    while (at_ < text_.size() && is_space(text_[at_])) ++at_;
    return at_ >= text_.size();
  }
  bool take(std::string_view token) {
    if (at_end() || text_.compare(at_, token.size(), token) != 0) return false;
    at_ += token.size();
    return true;
  }

  /// Makes a node, and remembers where it came from if it can have no finite value: that is a mistake only if the node is needed
  /// in the end, which a branch of an if with a constant condition is not.
  Node make(std::size_t at, Operation operation, Node a, Node b = -1, Node c = -1) {
    const Node n = graph_.make(operation, a, b, c);
    if (operation == Operation::divide && graph_.is_constant(b, 0.0)) {
      suspects_.try_emplace(n, at, "division by zero");
    } else {
      note(at, n, "this has no finite value");
    }
    return n;
  }
  void note(std::size_t at, Node n, const std::string& message) {
    if (graph_.is_constant(n) && !std::isfinite(graph_.data(n).value)) suspects_.try_emplace(n, at, message);
  }
  void refuse_nonsense(Node root) const {
    const std::pair<std::size_t, std::string>* first = nullptr;
    for (Node n : graph_.reachable({root})) {
      const auto suspect = suspects_.find(n);
      if (suspect != suspects_.end() && (first == nullptr || suspect->second.first < first->first)) first = &suspect->second;
    }
    if (first != nullptr) fail_at(first->first, first->second);
  }

  /// 1 or 0: whether a is not 0.
  Node truth(std::size_t at, Node a) {
    const Operation operation = graph_.data(a).operation;
    const bool is_truth = operation >= Operation::less && operation <= Operation::not_equal;
    return is_truth ? a : make(at, Operation::not_equal, a, graph_.constant(0.0));
  }

  Node disjunction() {
    const Deeper deeper(*this);
    Node a = conjunction();
    while (take("||")) {
      const std::size_t at = at_ - 2;
      const Node b = truth(at, conjunction());
      a = make(at, Operation::maximum, truth(at, a), b);
    }
    return a;
  }

  Node conjunction() {
    Node a = comparison();
    while (take("&&")) {
      const std::size_t at = at_ - 2;
      const Node b = truth(at, comparison());
      a = make(at, Operation::minimum, truth(at, a), b);
    }
    return a;
  }

  Node comparison() {
    const Node a = sum();
    if (at_end()) return a;
    static constexpr std::pair<std::string_view, Operation> operators[] = {{"<=", Operation::less_equal}, {">=", Operation::greater_equal},
                                                                           {"==", Operation::equal},      {"!=", Operation::not_equal},
                                                                           {"<", Operation::less},        {">", Operation::greater}};
    const auto find = [&] {
      return std::find_if(std::begin(operators), std::end(operators),
                          [&](const auto& entry) { return text_.compare(at_, entry.first.size(), entry.first) == 0; });
    };
    const auto* found = find();
    if (found == std::end(operators)) {
      if (text_[at_] == '=') fail("\"=\" is no operator; equality is \"==\"");
      return a;
    }
    const std::size_t at = at_;
    at_ += found->first.size();
    const Node result = make(at, found->second, a, sum());
    if (!at_end() && find() != std::end(operators)) fail("comparisons cannot be chained; write a < b && b < c");
    return result;
  }

  Node sum() {
    Node a = term();
    while (!at_end()) {
      const std::size_t at = at_;
      if (take("+")) {
        a = make(at, Operation::add, a, term());
      } else if (take("-")) {
        a = make(at, Operation::subtract, a, term());
      } else {
        break;
      }
    }
    return a;
  }

  Node term() {
    Node a = factor();
    while (!at_end()) {
      const std::size_t at = at_;
      if (take("**")) fail_at(at, "\"**\" is no operator; a power is written with ^");
      if (take("*")) {
        a = make(at, Operation::multiply, a, factor());
      } else if (take("/")) {
        a = make(at, Operation::divide, a, factor());
      } else {
        break;
      }
    }
    return a;
  }

  Node factor() {
    const Deeper deeper(*this);
    at_end();
    const std::size_t start = at_;
    if (take("-")) return make(start, Operation::negate, factor());
    if (take("+")) return factor();
    if (take("!")) return make(start, Operation::equal, factor(), graph_.constant(0.0));
    const Node base = atom();
    if (at_end()) return base;
    const std::size_t at = at_;
    if (take("^")) return make(at, Operation::power, base, factor());
    return base;
  }

  Node atom() {
    if (at_end()) fail("the expression ends where a number, a name or ( is expected");
    const char c = text_[at_];
    if (take("(")) {
      const Node n = disjunction();
      if (!take(")")) fail("\")\" is missing");
      return n;
    }
    if (is_digit(c) || c == '.') return number();
    if (is_letter(c)) return name();
    fail(fmt::format("unexpected {}; expected a number, a name or (", character()));
  }

  Node number() {
    double value = 0.0;
    const auto [end, status] = std::from_chars(text_.data() + at_, text_.data() + text_.size(), value);
    if (status == std::errc::invalid_argument) fail("a number needs a digit");
    if (status != std::errc()) fail("this number is outside the range of double precision");
    at_ = static_cast<std::size_t>(end - text_.data());
    return graph_.constant(value);
  }

  Node name() {
    const std::size_t start = at_;
    while (at_ < text_.size() && (is_letter(text_[at_]) || is_digit(text_[at_]))) ++at_;
    const std::string word = text_.substr(start, at_ - start);
    const bool called = !at_end() && text_[at_] == '(';
    const std::vector<std::string>& variables = graph_.variables();
    const auto variable = std::find(variables.begin(), variables.end(), word);
    const auto given = constants_.find(word);
    if (called) {
      if (is_function(word)) return call(word, start);
      if (variable != variables.end() || given != constants_.end()) {
        fail_at(start, fmt::format("\"{}\" is no function; a product is written with *", word));
      }
      fail_at(start,
              fmt::format("unknown function \"{}\"{}", word, with_allowed(suggestion(word, function_names()), "", function_names())));
    }
    if (variable != variables.end()) return graph_.variable(static_cast<int>(variable - variables.begin()));
    if (given != constants_.end()) {
      const Node n = graph_.constant(given->second);
      note(start, n, fmt::format("\"{}\" is not a finite number", word));
      return n;
    }
    if (word == "pi") return graph_.constant(std::numbers::pi);
    if (word == "e") return graph_.constant(std::numbers::e);
    if (is_function(word)) fail_at(start, fmt::format("\"{0}\" is a function; it is written {0}(...)", word));
    std::vector<std::string> known = variables;
    for (const auto& [constant, value] : constants_) known.push_back(constant);
    known.insert(known.end(), {"pi", "e"});
    fail_at(start, fmt::format("unknown name \"{}\"{}", word, with_allowed(suggestion(word, known), "", known)));
  }

  static const Function* find_function(const std::string& word) {
    const auto* f = std::find_if(std::begin(functions), std::end(functions), [&](const Function& g) { return word == g.name; });
    return f == std::end(functions) ? nullptr : f;
  }
  static bool is_function(const std::string& word) { return word == arrhenius_name || find_function(word) != nullptr; }
  static std::vector<std::string> function_names() {
    std::vector<std::string> names;
    for (const Function& f : functions) names.emplace_back(f.name);
    names.emplace_back(arrhenius_name);
    return names;
  }

  /// The arguments from "(" to ")"; as many as there are.
  std::vector<Node> arguments() {
    take("(");
    std::vector<Node> list;
    if (take(")")) return list;
    do {
      list.push_back(disjunction());
    } while (take(","));
    if (!take(")")) fail("\",\" or \")\" is missing");
    return list;
  }

  Node call(const std::string& word, std::size_t start) {
    const std::vector<Node> list = arguments();
    const auto count = static_cast<int>(list.size());
    if (word == arrhenius_name) {
      if (count != 3 && count != 4) {
        fail_at(start, fmt::format("arrhenius takes (A, Ea, T) or (A, b, Ea, T), got {} argument{}", count, count == 1 ? "" : "s"));
      }
      return arrhenius(start, list);
    }
    const Function& f = *find_function(word);
    if (count != f.arguments) {
      fail_at(start, fmt::format("{} takes {} argument{}, got {}", word, f.arguments, f.arguments == 1 ? "" : "s", count));
    }
    return make(start, f.operation, list[0], count > 1 ? list[1] : -1, count > 2 ? list[2] : -1);
  }

  /// A T^b exp(-Ea / (R T))
  Node arrhenius(std::size_t start, const std::vector<Node>& list) {
    const Node temperature = list.back();
    const Node activation = make(start, Operation::divide, list[list.size() - 2], graph_.constant(gas_constant));
    const Node exponent = make(start, Operation::negate, make(start, Operation::divide, activation, temperature));
    Node factor = list[0];
    if (list.size() == 4) factor = make(start, Operation::multiply, factor, make(start, Operation::power, temperature, list[1]));
    return make(start, Operation::multiply, factor, make(start, Operation::exponential, exponent));
  }

  ExpressionGraph& graph_;
  const std::string& text_;
  const std::map<std::string, double>& constants_;
  std::map<Node, std::pair<std::size_t, std::string>> suspects_;
  std::size_t at_ = 0;
  int depth_ = 0;
};

}  // namespace

Node ExpressionGraph::parse(const std::string& text, const std::map<std::string, double>& constants) {
  return Parser(*this, text, constants).parse();
}

}  // namespace stiffront
