// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cmath>
#include <concepts>
#include <cstdint>
#include <cstring>
#include <utility>

#if defined(__SSE2__)
#include <immintrin.h>
#endif

/// A pack of doubles as wide as the target's vector registers, and masks to go with it.
///
/// Every operation acts on each lane alone and is correctly rounded, or written out as a fixed sequence of such operations,
/// so a cell's result never depends on the lane it falls in. Scalars take part through the same names: code templated on
/// the scalar compiles for double as well as for Pack.
namespace stiffront {

// The width is part of the names, so that objects compiled for different targets fail to link instead of mixing layouts.
#if defined(__AVX512F__) && defined(__AVX512DQ__)
inline namespace pack8 {
inline constexpr int pack_size = 8;
#elif defined(__AVX__)
inline namespace pack4 {
inline constexpr int pack_size = 4;
#else
inline namespace pack2 {
inline constexpr int pack_size = 2;
#endif

struct Mask;

struct Pack {
  typedef double Vector __attribute__((vector_size(pack_size * sizeof(double))));  // NOLINT: an alias loses the attribute
  static constexpr int size = pack_size;

  Vector v;

  Pack() = default;
  Pack(double x) : v(x - Vector{}) {}            // NOLINT: a number is a pack of equal lanes
  Pack(int x) : Pack(static_cast<double>(x)) {}  // NOLINT
  explicit Pack(Vector x) : v(x) {}

  /// Reads pack_size consecutive doubles, no alignment required.
  static Pack load(const double* p) {
    Pack r;
    std::memcpy(&r.v, p, sizeof(Vector));
    return r;
  }
  /// Reads the first n doubles and repeats the last of them in the other lanes, so that no lane holds made-up data.
  static Pack load_partial(const double* p, int n) {
    Pack r;
    for (int l = 0; l < pack_size; ++l) r.v[l] = p[l < n ? l : n - 1];
    return r;
  }
  void store(double* p) const { std::memcpy(p, &v, sizeof(Vector)); }
  /// Writes the first n lanes only.
  void store_partial(double* p, int n) const {
    for (int l = 0; l < n && l < pack_size; ++l) p[l] = v[l];
  }
  /// Writes the first n lanes, rounded to single precision.
  void store_as_float(float* p, int n) const {
    typedef float Narrow __attribute__((vector_size(pack_size * sizeof(float))));  // NOLINT
    const Narrow narrow = __builtin_convertvector(v, Narrow);
    if (n == pack_size) {
      std::memcpy(p, &narrow, sizeof narrow);
    } else {
      for (int l = 0; l < n; ++l) p[l] = narrow[l];
    }
  }
  double operator[](int lane) const { return v[lane]; }
  void set(int lane, double x) { v[lane] = x; }

  friend Pack operator+(Pack a, Pack b) { return Pack(a.v + b.v); }
  friend Pack operator-(Pack a, Pack b) { return Pack(a.v - b.v); }
  friend Pack operator*(Pack a, Pack b) { return Pack(a.v * b.v); }
  friend Pack operator/(Pack a, Pack b) { return Pack(a.v / b.v); }
  friend Pack operator-(Pack a) { return Pack(-a.v); }
  friend Pack operator+(Pack a) { return a; }
  Pack& operator+=(Pack b) {
    v += b.v;
    return *this;
  }
  Pack& operator-=(Pack b) {
    v -= b.v;
    return *this;
  }
  Pack& operator*=(Pack b) {
    v *= b.v;
    return *this;
  }
  Pack& operator/=(Pack b) {
    v /= b.v;
    return *this;
  }
};

struct Mask {
  typedef std::int64_t Vector __attribute__((vector_size(pack_size * sizeof(std::int64_t))));  // NOLINT
  Vector v;                                                                                    // 0 or -1 in each lane

  Mask() = default;
  Mask(bool b) : v((b ? -1 : 0) - Vector{}) {}  // NOLINT
  explicit Mask(Vector x) : v(x) {}
  /// The first n lanes set.
  static Mask first(int n) {
    Mask m;
    for (int l = 0; l < pack_size; ++l) m.v[l] = l < n ? -1 : 0;
    return m;
  }

  bool operator[](int lane) const { return v[lane] != 0; }
  void set(int lane, bool b) { v[lane] = b ? -1 : 0; }
  friend Mask operator&(Mask a, Mask b) { return Mask(a.v & b.v); }
  friend Mask operator|(Mask a, Mask b) { return Mask(a.v | b.v); }
  friend Mask operator&&(Mask a, Mask b) { return a & b; }
  friend Mask operator||(Mask a, Mask b) { return a | b; }
  friend Mask operator!(Mask a) { return Mask(~a.v); }
  Mask& operator&=(Mask b) {
    v &= b.v;
    return *this;
  }
  Mask& operator|=(Mask b) {
    v |= b.v;
    return *this;
  }
};

#if defined(__AVX__) || !defined(__SSE2__)
inline Mask operator<(Pack a, Pack b) { return Mask(a.v < b.v); }
inline Mask operator<=(Pack a, Pack b) { return Mask(a.v <= b.v); }
inline Mask operator>(Pack a, Pack b) { return Mask(a.v > b.v); }
inline Mask operator>=(Pack a, Pack b) { return Mask(a.v >= b.v); }
inline Mask operator==(Pack a, Pack b) { return Mask(a.v == b.v); }
inline Mask operator!=(Pack a, Pack b) { return Mask(a.v != b.v); }
#else
// Where the target does not compare 64-bit integers, g++ 12 can fail with an internal error on conditions of vectors: neither
// comparisons nor select() are written as such there.
inline Mask operator<(Pack a, Pack b) { return Mask(reinterpret_cast<Mask::Vector>(_mm_cmplt_pd(a.v, b.v))); }
inline Mask operator<=(Pack a, Pack b) { return Mask(reinterpret_cast<Mask::Vector>(_mm_cmple_pd(a.v, b.v))); }
inline Mask operator>(Pack a, Pack b) { return Mask(reinterpret_cast<Mask::Vector>(_mm_cmpgt_pd(a.v, b.v))); }
inline Mask operator>=(Pack a, Pack b) { return Mask(reinterpret_cast<Mask::Vector>(_mm_cmpge_pd(a.v, b.v))); }
inline Mask operator==(Pack a, Pack b) { return Mask(reinterpret_cast<Mask::Vector>(_mm_cmpeq_pd(a.v, b.v))); }
inline Mask operator!=(Pack a, Pack b) { return Mask(reinterpret_cast<Mask::Vector>(_mm_cmpneq_pd(a.v, b.v))); }
#endif

/// Lane l of the result is bit l.
inline unsigned bits(Mask m) {
#if defined(__AVX512F__) && defined(__AVX512DQ__)
  return static_cast<unsigned>(_mm512_movepi64_mask(reinterpret_cast<__m512i>(m.v)));
#elif defined(__AVX__)
  return static_cast<unsigned>(_mm256_movemask_pd(reinterpret_cast<__m256d>(m.v)));
#else
  unsigned r = 0;
  for (int l = 0; l < pack_size; ++l) r |= static_cast<unsigned>(m.v[l] != 0) << l;
  return r;
#endif
}
inline bool any(Mask m) { return bits(m) != 0; }
inline bool all(Mask m) { return bits(m) == (1U << pack_size) - 1U; }
inline bool none(Mask m) { return bits(m) == 0; }

/// m ? a : b in each lane.
inline Pack select(Mask m, Pack a, Pack b) {
#if defined(__AVX__) || !defined(__SSE2__)
  return Pack(m.v ? a.v : b.v);
#else
  const __m128d where = reinterpret_cast<__m128d>(m.v);
  return Pack(static_cast<Pack::Vector>(_mm_or_pd(_mm_and_pd(where, a.v), _mm_andnot_pd(where, b.v))));
#endif
}

/// Writes the lanes of the mask only.
inline void store_lanes(Pack x, double* p, Mask m) {
#if defined(__AVX512F__) && defined(__AVX512DQ__)
  _mm512_mask_storeu_pd(p, static_cast<__mmask8>(bits(m)), x.v);
#else
  for (int l = 0; l < pack_size; ++l) {
    if (m[l]) p[l] = x[l];
  }
#endif
}

/// The pack that begins n lanes after the beginning of lo, where hi is what follows lo in memory: an unaligned load without the load.
template <int n>
Pack straddle(Pack lo, Pack hi) {
  static_assert(0 < n && n < pack_size);
  return [&]<int... lane>(std::integer_sequence<int, lane...>) {
    return Pack(static_cast<Pack::Vector>(__builtin_shufflevector(lo.v, hi.v, (n + lane)...)));
  }
  (std::make_integer_sequence<int, pack_size>());
}

/// a*b + c, rounded once where the target can fuse it, twice elsewhere: the same in every lane and at every call of one build.
inline Pack mul_add(Pack a, Pack b, Pack c) {
#if defined(__AVX512F__) && defined(__AVX512DQ__)
  return Pack(static_cast<Pack::Vector>(_mm512_fmadd_pd(a.v, b.v, c.v)));
#elif defined(__FMA__)
  return Pack(static_cast<Pack::Vector>(_mm256_fmadd_pd(a.v, b.v, c.v)));
#else
  return a * b + c;
#endif
}
/// c - a*b.
inline Pack neg_mul_add(Pack a, Pack b, Pack c) {
#if defined(__AVX512F__) && defined(__AVX512DQ__)
  return Pack(static_cast<Pack::Vector>(_mm512_fnmadd_pd(a.v, b.v, c.v)));
#elif defined(__FMA__)
  return Pack(static_cast<Pack::Vector>(_mm256_fnmadd_pd(a.v, b.v, c.v)));
#else
  return c - a * b;
#endif
}

inline Pack min(Pack a, Pack b) { return select(a < b, a, b); }
inline Pack max(Pack a, Pack b) { return select(a > b, a, b); }
inline Pack abs(Pack a) {
  Mask::Vector sign_off;
  std::memcpy(&sign_off, &a.v, sizeof a.v);
  sign_off &= std::int64_t{0x7fffffffffffffff} - Mask::Vector{};
  Pack r;
  std::memcpy(&r.v, &sign_off, sizeof a.v);
  return r;
}
inline Pack sqrt(Pack a) {
  // The unmasked intrinsic of g++ 12 draws warnings about its own undefined operand; the instruction is the same.
#if defined(__AVX512F__) && defined(__AVX512DQ__)
  return Pack(static_cast<Pack::Vector>(_mm512_maskz_sqrt_pd(0xff, a.v)));
#elif defined(__AVX__)
  return Pack(static_cast<Pack::Vector>(_mm256_sqrt_pd(a.v)));
#else
  Pack r;
  for (int l = 0; l < pack_size; ++l) r.v[l] = std::sqrt(a.v[l]);
  return r;
#endif
}
inline Mask is_finite(Pack a) { return abs(a) <= Pack(1.7976931348623157e308); }

/// Largest and smallest lane; exact, so their order of evaluation is free.
inline double max_lane(Pack a) {
  double r = a[0];
  for (int l = 1; l < pack_size; ++l) r = a[l] > r ? a[l] : r;
  return r;
}
inline double min_lane(Pack a) {
  double r = a[0];
  for (int l = 1; l < pack_size; ++l) r = a[l] < r ? a[l] : r;
  return r;
}

}  // inline namespace

// The same names for one double, so that one template serves both. A scalar "mask" is bool.
inline unsigned bits(bool b) { return b ? 1U : 0U; }
inline bool any(bool b) { return b; }
inline bool all(bool b) { return b; }
inline bool none(bool b) { return !b; }
inline double select(bool m, double a, double b) { return m ? a : b; }
inline double mul_add(double a, double b, double c) {
#if defined(__FMA__)
  return std::fma(a, b, c);
#else
  return a * b + c;
#endif
}
inline double neg_mul_add(double a, double b, double c) { return mul_add(-a, b, c); }
inline double min(double a, double b) { return a < b ? a : b; }
inline double max(double a, double b) { return a > b ? a : b; }
inline double abs(double a) { return std::abs(a); }
inline double sqrt(double a) { return std::sqrt(a); }
inline bool is_finite(double a) { return std::abs(a) <= 1.7976931348623157e308; }
inline double max_lane(double a) { return a; }
inline double min_lane(double a) { return a; }

/// What a scalar type of the cell kernels offers besides arithmetic: its width, loads and stores, its mask.
template <class T>
struct ScalarTraits;

template <>
struct ScalarTraits<double> {
  using MaskType = bool;
  static constexpr int size = 1;
  static double load(const double* p) { return *p; }
  static double load_partial(const double* p, int) { return *p; }
  static void store(double x, double* p) { *p = x; }
  static void store_partial(double x, double* p, int) { *p = x; }
  static void store_as_float(double x, float* p, int) { *p = static_cast<float>(x); }
  static double lane(double x, int) { return x; }
  static void set_lane(double& x, int, double y) { x = y; }
  static void set_lane(bool& m, int, bool b) { m = b; }
  static bool first(int n) { return n > 0; }
};

template <>
struct ScalarTraits<Pack> {
  using MaskType = Mask;
  static constexpr int size = pack_size;
  static Pack load(const double* p) { return Pack::load(p); }
  static Pack load_partial(const double* p, int n) { return Pack::load_partial(p, n); }
  static void store(Pack x, double* p) { x.store(p); }
  static void store_partial(Pack x, double* p, int n) { x.store_partial(p, n); }
  static void store_as_float(Pack x, float* p, int n) { x.store_as_float(p, n); }
  static double lane(Pack x, int l) { return x[l]; }
  static void set_lane(Pack& x, int l, double y) { x.set(l, y); }
  static void set_lane(Mask& m, int l, bool b) { m.set(l, b); }
  static Mask first(int n) { return Mask::first(n); }
};

}  // namespace stiffront
