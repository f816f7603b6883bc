// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cmath>

#include "stiffront/model/model.hpp"

namespace stiffront {

/// A front u that drags a fast damped oscillator (v, z) behind it: with p = v - u^2,
///
///     du/dt = 2 u (1 - u),  dv/dt = -damping p - omega z,  dz/dt = omega p - damping z
///
/// A test of methods at eigenvalues -damping +- i omega near the imaginary axis: backward differentiation of order k is stable there
/// only within its angle, 90, 86, 73 and 51 degrees for k = 2 .. 5. The oscillator does not diffuse.
struct SlavedOscillator {
  static constexpr int n_species = 3;
  static constexpr const char* name = "slaved-oscillator";
  static constexpr const char* source = "a logistic front with a slaved stiff oscillator, our own test of stability angles";
  static constexpr std::array<const char*, 3> species{"u", "v", "z"};
  static constexpr std::array<double, 3> diffusion{0.1, 0.0, 0.0};
  static const std::array<Parameter<SlavedOscillator>, 2> parameters;
  static const std::array<Profile<SlavedOscillator>, 1> profiles;

  double damping = 20.0;
  double omega = 200.0;

  template <class T, class P>
  void rates(const T* u, T* du, const P&) const {
    const T p = u[1] - u[0] * u[0];
    du[0] = 2.0 * u[0] * (1.0 - u[0]);
    du[1] = -damping * p - omega * u[2];
    du[2] = omega * p - damping * u[2];
  }

  static void front(const SlavedOscillator&, const Grid& grid, std::int64_t i, std::int64_t, double* u) {
    u[0] = 0.5 - 0.5 * std::tanh(2.0 * (grid.position(0, i) - 5.0));
    u[1] = u[0] * u[0];
    u[2] = 0.0;
  }
};

inline constexpr std::array<Parameter<SlavedOscillator>, 2> SlavedOscillator::parameters{
    {{"damping", &SlavedOscillator::damping}, {"omega", &SlavedOscillator::omega}}};
inline constexpr std::array<Profile<SlavedOscillator>, 1> SlavedOscillator::profiles{
    {{"slaved-oscillator-front", "a front at x = 5 with the oscillator in balance", &SlavedOscillator::front}}};

}  // namespace stiffront
