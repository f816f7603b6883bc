// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cmath>

#include "stiffront/core/simd_exp_log.hpp"
#include "stiffront/core/simd_hyperbolic.hpp"
#include "stiffront/core/simd_trigonometric.hpp"

/// Elementary functions under one name for packs, written here, and for doubles, from the C library.
///
/// The two need not agree in the last bits (each is within 3 ulp). Whatever must be reproducible is therefore always computed
/// with packs, single cells too: a lane's bits depend on that lane's argument alone.
namespace stiffront {

using std::acos;
using std::asin;
using std::atan;
using std::cos;
using std::cosh;
using std::exp;
using std::expm1;
using std::log;
using std::log10;
using std::log1p;
using std::pow;
using std::sin;
using std::sinh;
using std::tan;
using std::tanh;

}  // namespace stiffront
