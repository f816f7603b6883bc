// SPDX-License-Identifier: BSD-3-Clause
// The whole of Stiffront with one more model: what a user writes whose rates are not among the built-in ones.
#include <array>

#include "stiffront/app/program.hpp"

namespace {

/// Nagumo's equation, a bistable front: du/dt = D d2u/dx2 + k u (1 - u) (u - a).
struct Nagumo {
  static constexpr int n_species = 1;
  static constexpr const char* name = "nagumo";
  static constexpr const char* source = "Nagumo, Arimoto & Yoshizawa, Proc. IRE 50, 1962";
  static constexpr std::array<const char*, 1> species{"u"};
  static constexpr std::array<double, 1> diffusion{1e-3};
  static const std::array<stiffront::Parameter<Nagumo>, 2> parameters;
  static const std::array<stiffront::Profile<Nagumo>, 0> profiles;

  double k = 20.0;
  double a = 0.25;

  // One formula for numbers, for packs of cells and, through dual numbers, for the Jacobian.
  template <class T, class P>
  void rates(const T* u, T* du, const P&) const {
    du[0] = k * u[0] * (1.0 - u[0]) * (u[0] - a);
  }
};

inline constexpr std::array<stiffront::Parameter<Nagumo>, 2> Nagumo::parameters{{{"k", &Nagumo::k}, {"a", &Nagumo::a}}};
inline constexpr std::array<stiffront::Profile<Nagumo>, 0> Nagumo::profiles{};

}  // namespace

int main(int argc, char** argv) {
  stiffront::ModelRegistry models;
  stiffront::register_builtin_models(models);
  models.add<Nagumo>();
  return stiffront::app::run(argc, argv, models);
}
