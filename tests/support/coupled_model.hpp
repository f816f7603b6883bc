// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>

#include "stiffront/model/model.hpp"

namespace stiffront::testing {

/// Two species, one of which grows, with rates that are not linear.
struct Coupled {
  static constexpr int n_species = 2;
  static constexpr const char* name = "coupled";
  static constexpr const char* source = "test";
  static constexpr std::array<const char*, 2> species{"u", "v"};
  static constexpr std::array<double, 2> diffusion{1.0, 1.0};
  static constexpr std::array<Parameter<Coupled>, 0> parameters{};
  static constexpr std::array<Profile<Coupled>, 0> profiles{};

  template <class T, class P>
  void rates(const T* u, T* du, const P&) const {
    du[0] = u[0] * u[0] * 3.0 + u[1] * 20.0 - u[0];
    du[1] = u[0] * 50.0 - u[1] * u[1] * 4000.0;
  }
};

}  // namespace stiffront::testing
