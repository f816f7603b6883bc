// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "stiffront/core/simd.hpp"
#include "stiffront/core/simd_math.hpp"

namespace stiffront {

/// A value with its first derivatives with respect to N variables (forward-mode differentiation), over double or Pack.
///
/// Evaluating a model's rates on Dual gives its exact Jacobian with the arithmetic of the rates themselves.
template <class T, int N>
struct Dual {
  T value;
  T derivative[N];

  Dual() = default;
  Dual(T x) : value(x) {  // NOLINT: a constant is a dual with zero derivatives
    for (T& d : derivative) d = T(0.0);
  }
  Dual(double x) requires(!std::same_as<T, double>) : Dual(T(x)) {}  // NOLINT
  Dual(int x) : Dual(T(static_cast<double>(x))) {}                   // NOLINT
  /// The independent variable number i.
  static Dual variable(T x, int i) {
    Dual r(x);
    r.derivative[i] = T(1.0);
    return r;
  }

  friend Dual operator+(const Dual& a, const Dual& b) {
    Dual r;
    r.value = a.value + b.value;
    for (int i = 0; i < N; ++i) r.derivative[i] = a.derivative[i] + b.derivative[i];
    return r;
  }
  friend Dual operator-(const Dual& a, const Dual& b) {
    Dual r;
    r.value = a.value - b.value;
    for (int i = 0; i < N; ++i) r.derivative[i] = a.derivative[i] - b.derivative[i];
    return r;
  }
  friend Dual operator-(const Dual& a) {
    Dual r;
    r.value = -a.value;
    for (int i = 0; i < N; ++i) r.derivative[i] = -a.derivative[i];
    return r;
  }
  friend Dual operator+(const Dual& a) { return a; }
  friend Dual operator*(const Dual& a, const Dual& b) {
    Dual r;
    r.value = a.value * b.value;
    for (int i = 0; i < N; ++i) r.derivative[i] = mul_add(a.derivative[i], b.value, a.value * b.derivative[i]);
    return r;
  }
  friend Dual operator/(const Dual& a, const Dual& b) {
    Dual r;
    const T inverse = T(1.0) / b.value;
    r.value = a.value / b.value;
    for (int i = 0; i < N; ++i) r.derivative[i] = neg_mul_add(r.value, b.derivative[i], a.derivative[i]) * inverse;
    return r;
  }

  // A plain number has no derivative: these spare the work with zeros.
  friend Dual operator+(const Dual& a, double b) {
    Dual r = a;
    r.value = r.value + T(b);
    return r;
  }
  friend Dual operator+(double a, const Dual& b) { return b + a; }
  friend Dual operator-(const Dual& a, double b) {
    Dual r = a;
    r.value = r.value - T(b);
    return r;
  }
  friend Dual operator-(double a, const Dual& b) {
    Dual r = -b;
    r.value = T(a) - b.value;
    return r;
  }
  friend Dual operator*(const Dual& a, double b) {
    Dual r;
    r.value = a.value * T(b);
    for (int i = 0; i < N; ++i) r.derivative[i] = a.derivative[i] * T(b);
    return r;
  }
  friend Dual operator*(double a, const Dual& b) { return b * a; }
  friend Dual operator/(const Dual& a, double b) {
    Dual r;
    r.value = a.value / T(b);
    for (int i = 0; i < N; ++i) r.derivative[i] = a.derivative[i] / T(b);
    return r;
  }
  friend Dual operator/(double a, const Dual& b) { return Dual(T(a)) / b; }
  Dual& operator+=(const Dual& b) { return *this = *this + b; }
  Dual& operator-=(const Dual& b) { return *this = *this - b; }
  Dual& operator*=(const Dual& b) { return *this = *this * b; }
  Dual& operator/=(const Dual& b) { return *this = *this / b; }

  // Comparisons look at the value only.
  friend auto operator<(const Dual& a, const Dual& b) { return a.value < b.value; }
  friend auto operator<=(const Dual& a, const Dual& b) { return a.value <= b.value; }
  friend auto operator>(const Dual& a, const Dual& b) { return a.value > b.value; }
  friend auto operator>=(const Dual& a, const Dual& b) { return a.value >= b.value; }
  friend auto operator==(const Dual& a, const Dual& b) { return a.value == b.value; }
  friend auto operator!=(const Dual& a, const Dual& b) { return a.value != b.value; }
};

namespace detail {

/// f(a) with its derivative df(a): the chain rule.
template <class T, int N>
Dual<T, N> chain(const Dual<T, N>& a, T f, T df) {
  Dual<T, N> r;
  r.value = f;
  for (int i = 0; i < N; ++i) r.derivative[i] = df * a.derivative[i];
  return r;
}

}  // namespace detail

template <class M, class T, int N>
Dual<T, N> select(M m, const Dual<T, N>& a, const Dual<T, N>& b) {
  Dual<T, N> r;
  r.value = select(m, a.value, b.value);
  for (int i = 0; i < N; ++i) r.derivative[i] = select(m, a.derivative[i], b.derivative[i]);
  return r;
}
template <class T, int N>
Dual<T, N> min(const Dual<T, N>& a, const Dual<T, N>& b) {
  return select(a.value < b.value, a, b);
}
template <class T, int N>
Dual<T, N> max(const Dual<T, N>& a, const Dual<T, N>& b) {
  return select(a.value > b.value, a, b);
}
template <class T, int N>
Dual<T, N> min(const Dual<T, N>& a, double b) {
  return min(a, Dual<T, N>(T(b)));
}
template <class T, int N>
Dual<T, N> max(const Dual<T, N>& a, double b) {
  return max(a, Dual<T, N>(T(b)));
}
template <class T, int N>
Dual<T, N> abs(const Dual<T, N>& a) {
  return select(a.value < T(0.0), -a, a);
}
template <class T, int N>
Dual<T, N> sqrt(const Dual<T, N>& a) {
  const T s = sqrt(a.value);
  return detail::chain(a, s, T(0.5) / s);
}
template <class T, int N>
Dual<T, N> exp(const Dual<T, N>& a) {
  const T e = exp(a.value);
  return detail::chain(a, e, e);
}
template <class T, int N>
Dual<T, N> expm1(const Dual<T, N>& a) {
  return detail::chain(a, expm1(a.value), exp(a.value));
}
template <class T, int N>
Dual<T, N> log1p(const Dual<T, N>& a) {
  return detail::chain(a, log1p(a.value), T(1.0) / (T(1.0) + a.value));
}
template <class T, int N>
Dual<T, N> log(const Dual<T, N>& a) {
  return detail::chain(a, log(a.value), T(1.0) / a.value);
}
template <class T, int N>
Dual<T, N> log10(const Dual<T, N>& a) {
  return detail::chain(a, log10(a.value), T(0.43429448190325182765) / a.value);
}
template <class T, int N>
Dual<T, N> sin(const Dual<T, N>& a) {
  return detail::chain(a, sin(a.value), cos(a.value));
}
template <class T, int N>
Dual<T, N> cos(const Dual<T, N>& a) {
  return detail::chain(a, cos(a.value), -sin(a.value));
}
template <class T, int N>
Dual<T, N> tan(const Dual<T, N>& a) {
  const T t = tan(a.value);
  return detail::chain(a, t, T(1.0) + t * t);
}
template <class T, int N>
Dual<T, N> asin(const Dual<T, N>& a) {
  return detail::chain(a, asin(a.value), T(1.0) / sqrt(T(1.0) - a.value * a.value));
}
template <class T, int N>
Dual<T, N> acos(const Dual<T, N>& a) {
  return detail::chain(a, acos(a.value), T(-1.0) / sqrt(T(1.0) - a.value * a.value));
}
template <class T, int N>
Dual<T, N> atan(const Dual<T, N>& a) {
  return detail::chain(a, atan(a.value), T(1.0) / (T(1.0) + a.value * a.value));
}
template <class T, int N>
Dual<T, N> sinh(const Dual<T, N>& a) {
  return detail::chain(a, sinh(a.value), cosh(a.value));
}
template <class T, int N>
Dual<T, N> cosh(const Dual<T, N>& a) {
  return detail::chain(a, cosh(a.value), sinh(a.value));
}
template <class T, int N>
Dual<T, N> tanh(const Dual<T, N>& a) {
  const T t = tanh(a.value);
  return detail::chain(a, t, T(1.0) - t * t);
}
/// a^p with a constant exponent; the derivative at a = 0 is that of the limit for p >= 1.
template <class T, int N>
Dual<T, N> pow(const Dual<T, N>& a, double p) {
  return detail::chain(a, pow(a.value, T(p)), T(p) * pow(a.value, T(p - 1.0)));
}
/// a^b with a positive constant base.
template <class T, int N>
Dual<T, N> pow(double a, const Dual<T, N>& b) {
  const T r = pow(T(a), b.value);
  return detail::chain(b, r, r * T(std::log(a)));
}
template <class T, int N>
Dual<T, N> pow(const Dual<T, N>& a, const Dual<T, N>& b) {
  Dual<T, N> r;
  r.value = pow(a.value, b.value);
  const T da = b.value * pow(a.value, b.value - T(1.0));
  const auto positive = a.value > T(0.0);
  const T db = select(positive, r.value * log(select(positive, a.value, T(1.0))), T(0.0));
  for (int i = 0; i < N; ++i) r.derivative[i] = mul_add(da, a.derivative[i], db * b.derivative[i]);
  return r;
}

/// The plain value behind a scalar that may be a dual.
inline double value_of(double x) { return x; }
inline Pack value_of(Pack x) { return x; }
template <class T, int N>
T value_of(const Dual<T, N>& x) {
  return x.value;
}

}  // namespace stiffront
