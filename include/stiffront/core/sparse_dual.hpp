// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "stiffront/core/simd.hpp"
#include "stiffront/core/simd_math.hpp"
#include "stiffront/core/unroll.hpp"

namespace stiffront {

/// A number that may be known to be zero or one whatever the data.
///
/// The knowledge is an ordinary value, but depends only on how a formula is built: once everything is inlined, the
/// optimiser has folded it and with it every operation with a zero or a one. (It may not fold 0*x by itself: x might be
/// an infinity.)
template <class T>
struct Sparse {
  enum Kind : int { zero, one, any };

  T value;
  Kind kind;

  Sparse() = default;
  STIFFRONT_ALWAYS_INLINE Sparse(T x) : value(x), kind(any) {}  // NOLINT: a number is a number of any value
  STIFFRONT_ALWAYS_INLINE static Sparse known_zero() { return {T(0.0), zero}; }
  STIFFRONT_ALWAYS_INLINE static Sparse known_one() { return {T(1.0), one}; }
  STIFFRONT_ALWAYS_INLINE bool is_zero() const { return kind == zero; }

  STIFFRONT_ALWAYS_INLINE friend Sparse operator-(const Sparse& a) { return a.is_zero() ? a : Sparse(-a.value); }
  STIFFRONT_ALWAYS_INLINE friend Sparse operator+(const Sparse& a, const Sparse& b) {
    if (a.is_zero()) return b;
    if (b.is_zero()) return a;
    return a.value + b.value;
  }
  STIFFRONT_ALWAYS_INLINE friend Sparse operator-(const Sparse& a, const Sparse& b) {
    if (b.is_zero()) return a;
    if (a.is_zero()) return -b;
    return a.value - b.value;
  }
  STIFFRONT_ALWAYS_INLINE friend Sparse operator*(const Sparse& a, const Sparse& b) {
    if (a.is_zero() || b.kind == one) return a;
    if (b.is_zero() || a.kind == one) return b;
    return a.value * b.value;
  }

 private:
  STIFFRONT_ALWAYS_INLINE Sparse(T x, Kind k) : value(x), kind(k) {}
};

/// a*b + c.
template <class T>
STIFFRONT_ALWAYS_INLINE Sparse<T> mul_add(const Sparse<T>& a, const Sparse<T>& b, const Sparse<T>& c) {
  if (a.kind != Sparse<T>::any || b.kind != Sparse<T>::any || c.is_zero()) return a * b + c;
  return mul_add(a.value, b.value, c.value);
}
/// c - a*b.
template <class T>
STIFFRONT_ALWAYS_INLINE Sparse<T> neg_mul_add(const Sparse<T>& a, const Sparse<T>& b, const Sparse<T>& c) {
  if (a.kind != Sparse<T>::any || b.kind != Sparse<T>::any || c.is_zero()) return c - a * b;
  return neg_mul_add(a.value, b.value, c.value);
}
template <class M, class T>
STIFFRONT_ALWAYS_INLINE Sparse<T> select(M m, const Sparse<T>& a, const Sparse<T>& b) {
  if (a.kind == b.kind && a.kind != Sparse<T>::any) return a;
  return select(m, a.value, b.value);
}

/// A dual number (see core/dual.hpp) whose derivatives are sparse: the exact Jacobian of rates on packs at the price of
/// one written by hand. Everything must be inlined for that; where it is not, the results are the same and the branches
/// cost.
template <class T, int N>
struct SparseDual {
  T value;
  Sparse<T> derivative[N];

  SparseDual() = default;
  STIFFRONT_ALWAYS_INLINE SparseDual(T x) : value(x) {  // NOLINT: a constant is a dual with zero derivatives
    unroll<N>([&](auto i) __attribute__((always_inline)) { derivative[i] = Sparse<T>::known_zero(); });
  }
  STIFFRONT_ALWAYS_INLINE SparseDual(double x) requires(!std::same_as<T, double>) : SparseDual(T(x)) {}  // NOLINT
  STIFFRONT_ALWAYS_INLINE SparseDual(int x) : SparseDual(T(static_cast<double>(x))) {}                   // NOLINT
  /// The independent variable number i.
  STIFFRONT_ALWAYS_INLINE static SparseDual variable(T x, int i) {
    SparseDual r(x);
    r.derivative[i] = Sparse<T>::known_one();
    return r;
  }
  /// A value with derivatives f(i).
  template <class F>
  STIFFRONT_ALWAYS_INLINE static SparseDual with(T x, F&& f) {
    SparseDual r;
    r.value = x;
    unroll<N>([&](auto i) __attribute__((always_inline)) { r.derivative[i] = f(i); });
    return r;
  }

  STIFFRONT_ALWAYS_INLINE friend SparseDual operator+(const SparseDual& a, const SparseDual& b) {
    return with(
        a.value + b.value, [&](int i) __attribute__((always_inline)) { return a.derivative[i] + b.derivative[i]; });
  }
  STIFFRONT_ALWAYS_INLINE friend SparseDual operator-(const SparseDual& a, const SparseDual& b) {
    return with(
        a.value - b.value, [&](int i) __attribute__((always_inline)) { return a.derivative[i] - b.derivative[i]; });
  }
  STIFFRONT_ALWAYS_INLINE friend SparseDual operator-(const SparseDual& a) {
    return with(
        -a.value, [&](int i) __attribute__((always_inline)) { return -a.derivative[i]; });
  }
  STIFFRONT_ALWAYS_INLINE friend SparseDual operator+(const SparseDual& a) { return a; }
  STIFFRONT_ALWAYS_INLINE friend SparseDual operator*(const SparseDual& a, const SparseDual& b) {
    const Sparse<T> av = a.value;
    const Sparse<T> bv = b.value;
    return with(
        a.value * b.value, [&](int i) __attribute__((always_inline)) { return mul_add(a.derivative[i], bv, av * b.derivative[i]); });
  }
  STIFFRONT_ALWAYS_INLINE friend SparseDual operator/(const SparseDual& a, const SparseDual& b) {
    const Sparse<T> inverse = T(1.0) / b.value;
    const Sparse<T> quotient = a.value / b.value;
    return with(
        quotient.value, [&](int i)
                            __attribute__((always_inline)) { return neg_mul_add(quotient, b.derivative[i], a.derivative[i]) * inverse; });
  }

  STIFFRONT_ALWAYS_INLINE friend SparseDual operator+(const SparseDual& a, double b) {
    SparseDual r = a;
    r.value = r.value + T(b);
    return r;
  }
  STIFFRONT_ALWAYS_INLINE friend SparseDual operator+(double a, const SparseDual& b) { return b + a; }
  STIFFRONT_ALWAYS_INLINE friend SparseDual operator-(const SparseDual& a, double b) {
    SparseDual r = a;
    r.value = r.value - T(b);
    return r;
  }
  STIFFRONT_ALWAYS_INLINE friend SparseDual operator-(double a, const SparseDual& b) {
    SparseDual r = -b;
    r.value = T(a) - b.value;
    return r;
  }
  STIFFRONT_ALWAYS_INLINE friend SparseDual operator*(const SparseDual& a, double b) {
    const Sparse<T> bv = T(b);
    return with(
        a.value * T(b), [&](int i) __attribute__((always_inline)) { return a.derivative[i] * bv; });
  }
  STIFFRONT_ALWAYS_INLINE friend SparseDual operator*(double a, const SparseDual& b) { return b * a; }
  STIFFRONT_ALWAYS_INLINE friend SparseDual operator/(const SparseDual& a, double b) {
    const T divisor(b);
    return with(
        a.value / divisor, [&](int i) __attribute__((always_inline)) {
          const Sparse<T>& d = a.derivative[i];
          return d.is_zero() ? d : Sparse<T>(d.value / divisor);
        });
  }
  STIFFRONT_ALWAYS_INLINE friend SparseDual operator/(double a, const SparseDual& b) { return SparseDual(T(a)) / b; }
  STIFFRONT_ALWAYS_INLINE SparseDual& operator+=(const SparseDual& b) { return *this = *this + b; }
  STIFFRONT_ALWAYS_INLINE SparseDual& operator-=(const SparseDual& b) { return *this = *this - b; }
  STIFFRONT_ALWAYS_INLINE SparseDual& operator*=(const SparseDual& b) { return *this = *this * b; }
  STIFFRONT_ALWAYS_INLINE SparseDual& operator/=(const SparseDual& b) { return *this = *this / b; }

  // Comparisons look at the value only.
  STIFFRONT_ALWAYS_INLINE friend auto operator<(const SparseDual& a, const SparseDual& b) { return a.value < b.value; }
  STIFFRONT_ALWAYS_INLINE friend auto operator<=(const SparseDual& a, const SparseDual& b) { return a.value <= b.value; }
  STIFFRONT_ALWAYS_INLINE friend auto operator>(const SparseDual& a, const SparseDual& b) { return a.value > b.value; }
  STIFFRONT_ALWAYS_INLINE friend auto operator>=(const SparseDual& a, const SparseDual& b) { return a.value >= b.value; }
  STIFFRONT_ALWAYS_INLINE friend auto operator==(const SparseDual& a, const SparseDual& b) { return a.value == b.value; }
  STIFFRONT_ALWAYS_INLINE friend auto operator!=(const SparseDual& a, const SparseDual& b) { return a.value != b.value; }
};

namespace detail {

/// f(a) with its derivative df(a): the chain rule.
template <class T, int N>
STIFFRONT_ALWAYS_INLINE SparseDual<T, N> chain(const SparseDual<T, N>& a, T f, T df) {
  const Sparse<T> slope = df;
  return SparseDual<T, N>::with(
      f, [&](int i) __attribute__((always_inline)) { return slope * a.derivative[i]; });
}

}  // namespace detail

template <class M, class T, int N>
STIFFRONT_ALWAYS_INLINE SparseDual<T, N> select(M m, const SparseDual<T, N>& a, const SparseDual<T, N>& b) {
  return SparseDual<T, N>::with(
      select(m, a.value, b.value), [&](int i) __attribute__((always_inline)) { return select(m, a.derivative[i], b.derivative[i]); });
}
template <class T, int N>
STIFFRONT_ALWAYS_INLINE SparseDual<T, N> min(const SparseDual<T, N>& a, const SparseDual<T, N>& b) {
  return select(a.value < b.value, a, b);
}
template <class T, int N>
STIFFRONT_ALWAYS_INLINE SparseDual<T, N> max(const SparseDual<T, N>& a, const SparseDual<T, N>& b) {
  return select(a.value > b.value, a, b);
}
template <class T, int N>
STIFFRONT_ALWAYS_INLINE SparseDual<T, N> abs(const SparseDual<T, N>& a) {
  return select(a.value < T(0.0), -a, a);
}
template <class T, int N>
STIFFRONT_ALWAYS_INLINE SparseDual<T, N> sqrt(const SparseDual<T, N>& a) {
  const T s = sqrt(a.value);
  return detail::chain(a, s, T(0.5) / s);
}
template <class T, int N>
STIFFRONT_ALWAYS_INLINE SparseDual<T, N> exp(const SparseDual<T, N>& a) {
  const T e = exp(a.value);
  return detail::chain(a, e, e);
}
template <class T, int N>
STIFFRONT_ALWAYS_INLINE SparseDual<T, N> log(const SparseDual<T, N>& a) {
  return detail::chain(a, log(a.value), T(1.0) / a.value);
}
template <class T, int N>
STIFFRONT_ALWAYS_INLINE SparseDual<T, N> log10(const SparseDual<T, N>& a) {
  return detail::chain(a, log10(a.value), T(0.43429448190325182765) / a.value);
}
template <class T, int N>
STIFFRONT_ALWAYS_INLINE SparseDual<T, N> sin(const SparseDual<T, N>& a) {
  return detail::chain(a, sin(a.value), cos(a.value));
}
template <class T, int N>
STIFFRONT_ALWAYS_INLINE SparseDual<T, N> cos(const SparseDual<T, N>& a) {
  return detail::chain(a, cos(a.value), -sin(a.value));
}
template <class T, int N>
STIFFRONT_ALWAYS_INLINE SparseDual<T, N> tan(const SparseDual<T, N>& a) {
  const T t = tan(a.value);
  return detail::chain(a, t, T(1.0) + t * t);
}
template <class T, int N>
STIFFRONT_ALWAYS_INLINE SparseDual<T, N> asin(const SparseDual<T, N>& a) {
  return detail::chain(a, asin(a.value), T(1.0) / sqrt(T(1.0) - a.value * a.value));
}
template <class T, int N>
STIFFRONT_ALWAYS_INLINE SparseDual<T, N> acos(const SparseDual<T, N>& a) {
  return detail::chain(a, acos(a.value), T(-1.0) / sqrt(T(1.0) - a.value * a.value));
}
template <class T, int N>
STIFFRONT_ALWAYS_INLINE SparseDual<T, N> atan(const SparseDual<T, N>& a) {
  return detail::chain(a, atan(a.value), T(1.0) / (T(1.0) + a.value * a.value));
}
template <class T, int N>
STIFFRONT_ALWAYS_INLINE SparseDual<T, N> sinh(const SparseDual<T, N>& a) {
  return detail::chain(a, sinh(a.value), cosh(a.value));
}
template <class T, int N>
STIFFRONT_ALWAYS_INLINE SparseDual<T, N> cosh(const SparseDual<T, N>& a) {
  return detail::chain(a, cosh(a.value), sinh(a.value));
}
template <class T, int N>
STIFFRONT_ALWAYS_INLINE SparseDual<T, N> tanh(const SparseDual<T, N>& a) {
  const T t = tanh(a.value);
  return detail::chain(a, t, T(1.0) - t * t);
}
/// a^p with a constant exponent; the derivative at a = 0 is that of the limit for p >= 1.
template <class T, int N>
STIFFRONT_ALWAYS_INLINE SparseDual<T, N> pow(const SparseDual<T, N>& a, double p) {
  return detail::chain(a, pow(a.value, T(p)), T(p) * pow(a.value, T(p - 1.0)));
}
/// a^b with a constant base a > 0.
template <class T, int N>
STIFFRONT_ALWAYS_INLINE SparseDual<T, N> pow(double a, const SparseDual<T, N>& b) {
  const T r = pow(T(a), b.value);
  return detail::chain(b, r, r * T(std::log(a)));
}
template <class T, int N>
STIFFRONT_ALWAYS_INLINE SparseDual<T, N> pow(const SparseDual<T, N>& a, const SparseDual<T, N>& b) {
  const T value = pow(a.value, b.value);
  const Sparse<T> da = b.value * pow(a.value, b.value - T(1.0));
  const auto positive = a.value > T(0.0);
  const Sparse<T> db = select(positive, value * log(select(positive, a.value, T(1.0))), T(0.0));
  return SparseDual<T, N>::with(
      value, [&](int i) __attribute__((always_inline)) { return mul_add(da, a.derivative[i], db * b.derivative[i]); });
}

template <class T, int N>
STIFFRONT_ALWAYS_INLINE T value_of(const SparseDual<T, N>& x) {
  return x.value;
}

}  // namespace stiffront
