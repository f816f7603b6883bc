// SPDX-License-Identifier: BSD-3-Clause
#include "expression_code.hpp"
#include "stiffront/core/simd.hpp"
#include "stiffront/core/simd_math.hpp"

namespace stiffront {

template <class T, int n>
void ExpressionProgram::run(T* registers) const {
  const double* const constants = constants_.data();
  for (const Instruction& instruction : instructions_) {
    const auto at = [&](int i, std::uint16_t number) -> T& { return registers[i * few_registers + number]; };
    const auto a = [&](int i) { return at(i, instruction.a); };
    const auto b = [&](int i) { return at(i, instruction.b); };
    const auto c = [&](int i) { return at(i, instruction.c); };
    const auto d = [&](int i) { return at(i, instruction.k); };
    const auto k = [&] { return T(constants[instruction.k]); };
    const auto l = [&] { return T(constants[instruction.l]); };
    // The result may be one of the operands: place i is written after it has been read.
    const auto each = [&](auto value) {
      for (int i = 0; i < n; ++i) at(i, instruction.result) = value(i);
    };
    const auto truth = [](auto condition) { return stiffront::select(condition, T(1.0), T(0.0)); };
    switch (instruction.code) {
      case Code::constant:
        each([&](int) { return k(); });
        break;
      case Code::add:
        each([&](int i) { return a(i) + b(i); });
        break;
      case Code::add_k:
        each([&](int i) { return a(i) + k(); });
        break;
      case Code::subtract:
        each([&](int i) { return a(i) - b(i); });
        break;
      case Code::k_minus:
        each([&](int i) { return k() - a(i); });
        break;
      case Code::multiply:
        each([&](int i) { return a(i) * b(i); });
        break;
      case Code::scale:
        each([&](int i) { return k() * a(i); });
        break;
      case Code::divide:
        each([&](int i) { return a(i) / b(i); });
        break;
      case Code::k_over:
        each([&](int i) { return k() / a(i); });
        break;
      case Code::negate:
        each([&](int i) { return -a(i); });
        break;

      case Code::fma:
        each([&](int i) { return mul_add(a(i), b(i), c(i)); });
        break;
      case Code::fma_k:
        each([&](int i) { return mul_add(k(), a(i), c(i)); });
        break;
      case Code::fma_to_k:
        each([&](int i) { return mul_add(a(i), b(i), k()); });
        break;
      case Code::fma_k_to_l:
        each([&](int i) { return mul_add(k(), a(i), l()); });
        break;
      case Code::fms:
        each([&](int i) { return mul_add(a(i), b(i), -c(i)); });
        break;
      case Code::fms_k:
        each([&](int i) { return mul_add(k(), a(i), -c(i)); });
        break;
      case Code::fnma:
        each([&](int i) { return neg_mul_add(a(i), b(i), c(i)); });
        break;
      case Code::fnma_to_k:
        each([&](int i) { return neg_mul_add(a(i), b(i), k()); });
        break;

      case Code::add_add:
        each([&](int i) { return (a(i) + b(i)) + c(i); });
        break;
      case Code::add_subtract:
        each([&](int i) { return (a(i) + b(i)) - c(i); });
        break;
      case Code::subtract_add:
        each([&](int i) { return (a(i) - b(i)) + c(i); });
        break;
      case Code::subtract_subtract:
        each([&](int i) { return (a(i) - b(i)) - c(i); });
        break;
      case Code::minus_sum:
        each([&](int i) { return c(i) - (a(i) + b(i)); });
        break;
      case Code::minus_difference:
        each([&](int i) { return c(i) - (a(i) - b(i)); });
        break;
      case Code::k_minus_add:
        each([&](int i) { return (k() - a(i)) + b(i); });
        break;
      case Code::k_minus_subtract:
        each([&](int i) { return (k() - a(i)) - b(i); });
        break;

      case Code::scale_sum:
        each([&](int i) { return k() * (a(i) + b(i)); });
        break;
      case Code::scale_difference:
        each([&](int i) { return k() * (a(i) - b(i)); });
        break;
      case Code::scale_k_minus:
        each([&](int i) { return k() * (l() - a(i)); });
        break;
      case Code::scale_k_plus:
        each([&](int i) { return k() * (l() + a(i)); });
        break;
      case Code::scale_product:
        each([&](int i) { return k() * (a(i) * b(i)); });
        break;
      case Code::scale_fma:
        each([&](int i) { return k() * mul_add(a(i), b(i), c(i)); });
        break;
      case Code::multiply_sum:
        each([&](int i) { return (a(i) + b(i)) * c(i); });
        break;
      case Code::multiply_difference:
        each([&](int i) { return (a(i) - b(i)) * c(i); });
        break;
      case Code::multiply_k_minus:
        each([&](int i) { return (k() - a(i)) * b(i); });
        break;
      case Code::multiply_k_plus:
        each([&](int i) { return (k() + a(i)) * b(i); });
        break;
      case Code::multiply_multiply:
        each([&](int i) { return (a(i) * b(i)) * c(i); });
        break;
      case Code::over_k_plus:
        each([&](int i) { return a(i) / (b(i) + k()); });
        break;
      case Code::k_over_l_plus:
        each([&](int i) { return k() / (a(i) + l()); });
        break;

      case Code::power:
        each([&](int i) { return pow(a(i), b(i)); });
        break;
      case Code::minimum:
        each([&](int i) { return min(a(i), b(i)); });
        break;
      case Code::maximum:
        each([&](int i) { return max(a(i), b(i)); });
        break;
      case Code::absolute:
        each([&](int i) { return abs(a(i)); });
        break;
      case Code::square_root:
        each([&](int i) { return sqrt(a(i)); });
        break;
      case Code::exponential:
        each([&](int i) { return exp(a(i)); });
        break;
      case Code::logarithm:
        each([&](int i) { return log(a(i)); });
        break;
      case Code::logarithm10:
        each([&](int i) { return log10(a(i)); });
        break;
      case Code::sine:
        each([&](int i) { return sin(a(i)); });
        break;
      case Code::cosine:
        each([&](int i) { return cos(a(i)); });
        break;
      case Code::tangent:
        each([&](int i) { return tan(a(i)); });
        break;
      case Code::arc_sine:
        each([&](int i) { return asin(a(i)); });
        break;
      case Code::arc_cosine:
        each([&](int i) { return acos(a(i)); });
        break;
      case Code::arc_tangent:
        each([&](int i) { return atan(a(i)); });
        break;
      case Code::hyperbolic_sine:
        each([&](int i) { return sinh(a(i)); });
        break;
      case Code::hyperbolic_cosine:
        each([&](int i) { return cosh(a(i)); });
        break;
      case Code::hyperbolic_tangent:
        each([&](int i) { return tanh(a(i)); });
        break;

      case Code::less:
        each([&](int i) { return truth(a(i) < b(i)); });
        break;
      case Code::less_equal:
        each([&](int i) { return truth(a(i) <= b(i)); });
        break;
      case Code::equal:
        each([&](int i) { return truth(a(i) == b(i)); });
        break;
      case Code::not_equal:
        each([&](int i) { return truth(a(i) != b(i)); });
        break;
      case Code::select:
        each([&](int i) { return stiffront::select(a(i) != T(0.0), b(i), c(i)); });
        break;
      case Code::select_if_less:
        each([&](int i) { return stiffront::select(a(i) < b(i), c(i), d(i)); });
        break;
      case Code::select_if_less_equal:
        each([&](int i) { return stiffront::select(a(i) <= b(i), c(i), d(i)); });
        break;
      case Code::select_if_equal:
        each([&](int i) { return stiffront::select(a(i) == b(i), c(i), d(i)); });
        break;
      case Code::select_if_not_equal:
        each([&](int i) { return stiffront::select(a(i) != b(i), c(i), d(i)); });
        break;
    }
  }
}

template void ExpressionProgram::run<double, 1>(double*) const;
template void ExpressionProgram::run<Pack, 1>(Pack*) const;
template void ExpressionProgram::run<Pack, 3>(Pack*) const;
template void ExpressionProgram::run<Pack, 8>(Pack*) const;

}  // namespace stiffront
