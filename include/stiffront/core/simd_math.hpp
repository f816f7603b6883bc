// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cmath>

#include "stiffront/core/simd.hpp"

/// Elementary functions on packs, lane by lane through the C library: the same bits in every lane.
namespace stiffront {

using std::acos;
using std::asin;
using std::atan;
using std::cos;
using std::cosh;
using std::exp;
using std::log;
using std::log10;
using std::pow;
using std::sin;
using std::sinh;
using std::tan;
using std::tanh;

namespace detail {

template <class F>
Pack per_lane(F f, Pack a) {
  Pack r;
  for (int l = 0; l < pack_size; ++l) r.set(l, f(a[l]));
  return r;
}

}  // namespace detail

inline Pack exp(Pack a) { return detail::per_lane([](double x) { return std::exp(x); }, a); }
inline Pack log(Pack a) { return detail::per_lane([](double x) { return std::log(x); }, a); }
inline Pack log10(Pack a) { return detail::per_lane([](double x) { return std::log10(x); }, a); }
inline Pack sin(Pack a) { return detail::per_lane([](double x) { return std::sin(x); }, a); }
inline Pack cos(Pack a) { return detail::per_lane([](double x) { return std::cos(x); }, a); }
inline Pack tan(Pack a) { return detail::per_lane([](double x) { return std::tan(x); }, a); }
inline Pack asin(Pack a) { return detail::per_lane([](double x) { return std::asin(x); }, a); }
inline Pack acos(Pack a) { return detail::per_lane([](double x) { return std::acos(x); }, a); }
inline Pack atan(Pack a) { return detail::per_lane([](double x) { return std::atan(x); }, a); }
inline Pack sinh(Pack a) { return detail::per_lane([](double x) { return std::sinh(x); }, a); }
inline Pack cosh(Pack a) { return detail::per_lane([](double x) { return std::cosh(x); }, a); }
inline Pack tanh(Pack a) { return detail::per_lane([](double x) { return std::tanh(x); }, a); }
inline Pack pow(Pack a, Pack b) {
  Pack r;
  for (int l = 0; l < pack_size; ++l) r.set(l, std::pow(a[l], b[l]));
  return r;
}

}  // namespace stiffront
