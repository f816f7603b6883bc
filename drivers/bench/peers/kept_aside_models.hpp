// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <numbers>

#include "stiffront/model/model.hpp"

/// The models of the case files in ../kept_aside, written in C++ for the peers; the program itself reads the case files.
namespace peers {

using stiffront::Parameter;
using stiffront::select;

/// Excitable medium with a cubic nullcline (FitzHugh, Biophys. J. 1, 1961). Not Barkley's, whose waves of many widths leave u = 1 by a
/// delay that rounding decides.
struct Excitable {
  static constexpr int n_species = 2;
  static constexpr const char* name = "excitable";
  static const std::array<Parameter<Excitable>, 3> parameters;
  double epsilon = 0.005, beta = 0.7, gamma = 0.5;

  template <class T, class P>
  void rates(const T* u, T* du, const P&) const {
    du[0] = (u[0] - u[0] * u[0] * u[0] * (1.0 / 3.0) - u[1]) * (1.0 / epsilon);
    du[1] = u[0] + beta - gamma * u[1];
  }
};
inline constexpr std::array<Parameter<Excitable>, 3> Excitable::parameters{
    {{"epsilon", &Excitable::epsilon}, {"beta", &Excitable::beta}, {"gamma", &Excitable::gamma}}};

/// The same, excited again and again by short pulses near x = 0.
struct ForcedExcitable {
  static constexpr int n_species = 2;
  static constexpr const char* name = "forced-excitable";
  static const std::array<Parameter<ForcedExcitable>, 6> parameters;
  double epsilon = 0.02, beta = 0.7, gamma = 0.5, force = 150.0, period = 1.5, sharpness = 100.0;

  template <class T, class P>
  void rates(const T* u, T* du, const P& p) const {
    const auto pulse = force * exp(sharpness * (cos(p.t * (2.0 * std::numbers::pi / period)) - 1.0)) * exp(p.x * p.x * -0.25);
    du[0] = (u[0] - u[0] * u[0] * u[0] * (1.0 / 3.0) - u[1]) * (1.0 / epsilon) + T(pulse);
    du[1] = u[0] + beta - gamma * u[1];
  }
};
inline constexpr std::array<Parameter<ForcedExcitable>, 6> ForcedExcitable::parameters{{{"epsilon", &ForcedExcitable::epsilon},
                                                                                        {"beta", &ForcedExcitable::beta},
                                                                                        {"gamma", &ForcedExcitable::gamma},
                                                                                        {"force", &ForcedExcitable::force},
                                                                                        {"period", &ForcedExcitable::period},
                                                                                        {"sharpness", &ForcedExcitable::sharpness}}};

/// Activator and inhibitor (Gierer & Meinhardt, Kybernetik 12, 1972).
struct GiererMeinhardt {
  static constexpr int n_species = 2;
  static constexpr const char* name = "gierer-meinhardt";
  static const std::array<Parameter<GiererMeinhardt>, 3> parameters;
  double mu = 1.0, nu = 2.0, sigma = 0.01;

  template <class T, class P>
  void rates(const T* u, T* du, const P&) const {
    const T aa = u[0] * u[0];
    du[0] = aa / u[1] - mu * u[0] + sigma;
    du[1] = aa - nu * u[1];
  }
};
inline constexpr std::array<Parameter<GiererMeinhardt>, 3> GiererMeinhardt::parameters{
    {{"mu", &GiererMeinhardt::mu}, {"nu", &GiererMeinhardt::nu}, {"sigma", &GiererMeinhardt::sigma}}};

/// A flame of two steps, branching with a high activation energy and recombination without (Zeldovich 1948, Linan 1971):
/// fuel + radical -> 2 radical, radical -> product + heat.
struct ChainFlame {
  static constexpr int n_species = 3;
  static constexpr const char* name = "chain-flame";
  static const std::array<Parameter<ChainFlame>, 3> parameters;
  double k = 200.0, beta = 15.0, alpha = 0.8;

  template <class T, class P>
  void rates(const T* u, T* du, const P&) const {
    const T below = 1.0 - u[2];
    const T branching = k * u[0] * u[1] * exp(-beta * below / (1.0 - alpha * below));
    du[0] = -branching;
    du[1] = branching - u[1];
    du[2] = u[1];
  }
};
inline constexpr std::array<Parameter<ChainFlame>, 3> ChainFlame::parameters{
    {{"k", &ChainFlame::k}, {"beta", &ChainFlame::beta}, {"alpha", &ChainFlame::alpha}}};

/// Robertson's three species feeding an enzymatic chain of five.
struct EightSpecies {
  static constexpr int n_species = 8;
  static constexpr const char* name = "eight-species";
  static const std::array<Parameter<EightSpecies>, 7> parameters;
  double k1 = 0.4, k2 = 3e7, k3 = 1e4, k4 = 100.0, k5 = 1e3, k6 = 50.0, k7 = 1.0;

  template <class T, class P>
  void rates(const T* u, T* du, const P&) const {
    const T r1 = k1 * u[0], r2 = k2 * u[1] * u[1], r3 = k3 * u[1] * u[2];
    const T r4 = k4 * u[2] * u[3], r5 = k5 * u[4], r6 = k6 * u[5] * u[6], r7 = k7 * u[7];
    du[0] = r3 - r1;
    du[1] = r1 - r2 - r3;
    du[2] = r2 - r4 + r5;
    du[3] = r7 - r4;
    du[4] = r4 - r5;
    du[5] = r5 - r6;
    du[6] = r7 - r6;
    du[7] = r6 - r7;
  }
};
inline constexpr std::array<Parameter<EightSpecies>, 7> EightSpecies::parameters{{{"k1", &EightSpecies::k1},
                                                                                  {"k2", &EightSpecies::k2},
                                                                                  {"k3", &EightSpecies::k3},
                                                                                  {"k4", &EightSpecies::k4},
                                                                                  {"k5", &EightSpecies::k5},
                                                                                  {"k6", &EightSpecies::k6},
                                                                                  {"k7", &EightSpecies::k7}}};

/// Ozone and oxygen atoms in sunlight that comes and goes (the diurnal kinetics of Byrne & Hindmarsh), without advection; in
/// units of 1e8 and 1e12 per cubic centimetre.
struct Diurnal {
  static constexpr int n_species = 2;
  static constexpr const char* name = "diurnal";
  static const std::array<Parameter<Diurnal>, 4> parameters;
  double q1c3 = 6.031, q2 = 4.66e-16, a3 = 22.62, a4 = 7.601;

  template <class T, class P>
  void rates(const T* u, T* du, const P& p) const {
    const auto height = sin(p.t * (std::numbers::pi / 43200.0));
    const auto day = height > decltype(height)(1e-3);
    const auto safe = select(day, height, decltype(height)(1.0));
    const auto q3 = select(day, exp(-a3 / safe), decltype(height)(0.0));
    const auto q4 = select(day, exp(-a4 / safe), decltype(height)(0.0));
    const T pairing = u[0] * u[1];
    du[0] = -q1c3 * u[0] - (q2 * 1e12) * pairing + T(q3) * 7.4e8 + T(q4) * 1e4 * u[1];
    du[1] = (q1c3 * 1e-4) * u[0] - (q2 * 1e8) * pairing - T(q4) * u[1];
  }
};
inline constexpr std::array<Parameter<Diurnal>, 4> Diurnal::parameters{
    {{"q1c3", &Diurnal::q1c3}, {"q2", &Diurnal::q2}, {"a3", &Diurnal::a3}, {"a4", &Diurnal::a4}}};

}  // namespace peers
