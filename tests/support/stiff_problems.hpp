// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>

/// Problems of the stiff test sets of Geneva and Bari with their published end values.
/// @see Hairer & Wanner, Solving Ordinary Differential Equations II, 2nd ed., IV.10; Mazzia & Magherini, Test Set for Initial
///      Value Problem Solvers, release 2.4
namespace stiffront::testing {

struct Robertson {
  static constexpr int n_species = 3;
  static constexpr const char* name = "Robertson";
  static constexpr std::array<double, 3> start{1.0, 0.0, 0.0};
  static constexpr std::array<double, 3> scale{1e-6, 1e-12, 1.0};  ///< of absolute tolerances
  static constexpr double end = 1e11;
  static constexpr double first_step = 1e-6;
  static constexpr std::array<double, 3> solution{0.2083340149701255e-7, 0.8333360770334713e-13, 0.9999999791665050};

  template <class T, class P>
  void rates(const T* u, T* du, const P&) const {
    const T r1 = 0.04 * u[0];
    const T r2 = 1e4 * u[1] * u[2];
    const T r3 = 3e7 * u[1] * u[1];
    du[0] = r2 - r1;
    du[1] = r1 - r2 - r3;
    du[2] = r3;
  }
};

struct Hires {
  static constexpr int n_species = 8;
  static constexpr const char* name = "HIRES";
  static constexpr std::array<double, 8> start{1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0057};
  static constexpr std::array<double, 8> scale{1e-3, 1e-3, 1e-3, 1e-3, 1e-3, 1e-3, 1e-3, 1e-3};
  static constexpr double end = 321.8122;
  static constexpr double first_step = 1e-4;
  static constexpr std::array<double, 8> solution{0.7371312573325668e-3, 0.1442485726316185e-3, 0.5888729740967575e-4,
                                                  0.1175651343283149e-2, 0.2386356198831331e-2, 0.6238968252742796e-2,
                                                  0.2849998395185769e-2, 0.2850001604814231e-2};

  template <class T, class P>
  void rates(const T* u, T* du, const P&) const {
    du[0] = -1.71 * u[0] + 0.43 * u[1] + 8.32 * u[2] + 0.0007;
    du[1] = 1.71 * u[0] - 8.75 * u[1];
    du[2] = -10.03 * u[2] + 0.43 * u[3] + 0.035 * u[4];
    du[3] = 8.32 * u[1] + 1.71 * u[2] - 1.12 * u[3];
    du[4] = -1.745 * u[4] + 0.43 * u[5] + 0.43 * u[6];
    du[5] = -280.0 * u[5] * u[7] + 0.69 * u[3] + 1.71 * u[4] - 0.43 * u[5] + 0.69 * u[6];
    du[6] = 280.0 * u[5] * u[7] - 1.81 * u[6];
    du[7] = -280.0 * u[5] * u[7] + 1.81 * u[6];
  }
};

struct Oregonator {
  static constexpr int n_species = 3;
  static constexpr const char* name = "Oregonator";
  static constexpr std::array<double, 3> start{1.0, 2.0, 3.0};
  static constexpr std::array<double, 3> scale{1.0, 1.0, 1.0};
  static constexpr double end = 360.0;
  static constexpr double first_step = 1e-5;
  static constexpr std::array<double, 3> solution{0.1000814870318523e1, 0.1228178521549917e4, 0.1320554942846706e3};

  template <class T, class P>
  void rates(const T* u, T* du, const P&) const {
    du[0] = 77.27 * (u[1] + u[0] * (1.0 - 8.375e-6 * u[0] - u[1]));
    du[1] = (u[2] - (1.0 + u[0]) * u[1]) / 77.27;
    du[2] = 0.161 * (u[0] - u[2]);
  }
};

struct E5 {
  static constexpr int n_species = 4;
  static constexpr const char* name = "E5";
  static constexpr std::array<double, 4> start{1.76e-3, 0.0, 0.0, 0.0};
  static constexpr std::array<double, 4> scale{1e-20, 1e-20, 1e-20, 1e-20};
  static constexpr double end = 1e13;
  static constexpr double first_step = 1e-3;
  static constexpr std::array<double, 4> solution{0.1152903278711829e-290, 0.8867655517642120e-22, 0.8854814626268838e-22, 0.0};

  template <class T, class P>
  void rates(const T* u, T* du, const P&) const {
    const T r1 = 7.89e-10 * u[0];
    const T r2 = 1.1e7 * u[0] * u[2];
    const T r3 = 1.13e9 * u[1] * u[2];
    const T r4 = 1.13e3 * u[3];
    du[0] = -r1 - r2;
    du[1] = r1 - r3;
    du[3] = r2 - r4;
    du[2] = du[1] - du[3];
  }
};

struct VanDerPol {
  static constexpr int n_species = 2;
  static constexpr const char* name = "VanDerPol";
  static constexpr std::array<double, 2> start{2.0, 0.0};
  static constexpr std::array<double, 2> scale{1.0, 1.0};
  static constexpr double end = 2.0;
  static constexpr double first_step = 1e-6;
  static constexpr std::array<double, 2> solution{0.1706167732170483e1, -0.8928097010247975};

  template <class T, class P>
  void rates(const T* u, T* du, const P&) const {
    du[0] = u[1];
    du[1] = ((1.0 - u[0] * u[0]) * u[1] - u[0]) * 1e6;
  }
};

}  // namespace stiffront::testing
