// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <concepts>
#include <cstdint>
#include <string>
#include <vector>

#include "stiffront/core/dual.hpp"
#include "stiffront/core/simd.hpp"
#include "stiffront/mesh/decomposition.hpp"
#include "stiffront/mesh/grid.hpp"
#include "stiffront/model/conserved_sums.hpp"

namespace stiffront {

/// Where and when rates are evaluated. Time is a number per lane too: cells integrated together have inner steps of their own.
template <class T>
struct Place {
  T t;
  T x;
  T y;  ///< 0 in one dimension
};

/// The place of the pack of n cells that starts at point (i, j) of the grid. Positions are computed from global indices, lane by lane; the
/// lanes beyond the n-th repeat the last cell's, as Pack::load_partial does, so that no lane is evaluated at made-up places.
inline Place<Pack> place_of_cells(const Grid& grid, double t, std::int64_t i, std::int64_t j, int n = pack_size) {
  Pack index(static_cast<double>(i));
  for (int l = 0; l < pack_size; ++l) index.set(l, index[l] + (l < n ? l : n - 1));
  if (grid.has_sub_cells(0)) {
    for (int l = 0; l < pack_size; ++l) index.set(l, grid.place(0, i + (l < n ? l : n - 1)));
  }
  return {t, Pack(grid.lower[0]) + index * Pack(grid.spacing(0)), Pack(grid.dimension == 2 ? grid.position(1, j) : 0.0)};
}

/// The same for the pack that starts at a local point (i, j).
inline Place<Pack> place_of_pack(const Decomposition& d, double t, int i, int j, int n = pack_size) {
  return place_of_cells(d.grid(), t, d.offset_x() + i, d.offset_y() + j, n);
}

/// A parameter of a model M: its name in case files and the member that holds it. The default is that of a fresh M.
template <class M>
struct Parameter {
  const char* name;
  double M::*member;
};

/// An initial state built into a model M, given point by point by global index: a discontinuity must be placed by index, since
/// comparing positions rounds differently from one build to the next.
template <class M>
struct Profile {
  const char* name;
  const char* what;
  void (*evaluate)(const M& model, const Grid& grid, std::int64_t i, std::int64_t j, double* u);
  int dimension = 1;  ///< the least dimension of a grid it makes sense on
};

/// What a model must have. Rates are templated on the scalar, so that one formula gives values on packs of cells and, through
/// duals, the exact Jacobian. T is double, Pack or a Dual over one of them; P is a Place over the plain scalar.
///
///     struct Decay {
///       static constexpr int n_species = 1;
///       static constexpr const char* name = "decay";
///       static constexpr const char* source = "textbook";
///       static constexpr std::array<const char*, 1> species{"u"};
///       static constexpr std::array<double, 1> diffusion{1.0};                          // defaults
///       static constexpr std::array<Parameter<Decay>, 1> parameters{{{"k", &Decay::k}}};
///       static constexpr std::array<Profile<Decay>, 0> profiles{};
///       double k = 1.0;
///       template <class T, class P>
///       void rates(const T* u, T* du, const P& place) const { du[0] = -k * u[0]; }
///     };
template <class M>
concept Model = std::copyable<M> && std::default_initializable<M> && requires(const M& m, const Pack* u, Pack* du, const Place<Pack>& p) {
  { M::n_species } -> std::convertible_to<int>;
  { M::name } -> std::convertible_to<std::string>;
  { M::source } -> std::convertible_to<std::string>;
  M::species[0];
  M::diffusion[0];
  M::parameters.size();
  M::profiles.size();
  m.rates(u, du, p);
};

/// A model with first derivatives in its equations (model/transport_term.hpp): a member, templated like the rates,
///
///     template <class T, class P>
///     void transport(const T* u, const T* u_x, const T* u_xx, T* du, const P& place) const;
///
/// Models without it never pay for it.
template <class M>
concept ModelWithTransport = Model<M> && requires(const M& m, const Pack* u, Pack* du, const Place<Pack>& p) {
  m.transport(u, u, u, du, p);
};

/// A model that says which part of its rates an IMEX splitting takes implicitly: stiff_rates, templated like the rates.
template <class M>
concept ModelWithStiffRates = Model<M> && requires(const M& m, const Pack* u, Pack* du, const Place<Pack>& p) {
  m.stiff_rates(u, du, p);
};

/// The same facts without the type, for case files, lists and messages.
struct ModelDescription {
  struct NamedNumber {
    std::string name;
    double value;
  };
  struct NamedProfile {
    std::string name;
    std::string what;
    int dimension = 1;  ///< the least dimension of a grid it makes sense on
  };
  std::string name;
  std::string source;
  std::vector<std::string> species;
  std::vector<NamedNumber> parameters;  ///< with their defaults
  std::vector<double> diffusion;        ///< default coefficients, one per species
  std::vector<NamedProfile> profiles;
  bool has_transport = false;             ///< first derivatives in its equations
  std::vector<ConservedSum> conserved{};  ///< what the reactions leave constant, as far as it is known (reaction networks)

  int n_species() const { return static_cast<int>(species.size()); }
};

template <Model M>
ModelDescription describe() {
  ModelDescription d;
  d.name = M::name;
  d.source = M::source;
  d.has_transport = ModelWithTransport<M>;
  const M fresh{};
  for (const char* s : M::species) d.species.emplace_back(s);
  for (double c : M::diffusion) d.diffusion.push_back(c);
  for (const Parameter<M>& p : M::parameters) d.parameters.push_back({p.name, fresh.*p.member});
  for (const Profile<M>& p : M::profiles) d.profiles.push_back({p.name, p.what, p.dimension});
  return d;
}

/// Rates and exact Jacobian of a cell or a pack of cells together: jacobian[i][j] = d rates_i / d u_j. Kernels call this one; it
/// uses duals unless the model has a member of the same name and arguments (models whose formulas are data know their derivatives).
template <class M, class T>
[[gnu::always_inline]] inline void rates_and_jacobian(const M& model, const T* u, T* du, T (*jacobian)[M::n_species],
                                                      const Place<T>& place) {
  if constexpr (requires { model.rates_and_jacobian(u, du, jacobian, place); }) {
    model.rates_and_jacobian(u, du, jacobian, place);
  } else {
    constexpr int n = M::n_species;
    using D = Dual<T, n>;
    D v[n];
    D dv[n];
    for (int i = 0; i < n; ++i) v[i] = D::variable(u[i], i);
    model.rates(v, dv, place);
    for (int i = 0; i < n; ++i) {
      du[i] = dv[i].value;
      for (int j = 0; j < n; ++j) jacobian[i][j] = dv[i].derivative[j];
    }
  }
}

/// Rates and Jacobian of one cell in plain doubles; jacobian[i*n + j] is d rates_i / d u_j.
template <Model M>
void cell_rates(const M& m, double t, double x, double y, const double* u, double* du) {
  m.rates(u, du, Place<double>{t, x, y});
}

template <Model M>
void cell_jacobian(const M& m, double t, double x, double y, const double* u, double* jacobian) {
  constexpr int n = M::n_species;
  using D = Dual<double, n>;
  D v[n];
  D dv[n];
  for (int i = 0; i < n; ++i) v[i] = D::variable(u[i], i);
  m.rates(v, dv, Place<double>{t, x, y});
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) jacobian[i * n + j] = dv[i].derivative[j];
  }
}

}  // namespace stiffront
