// SPDX-License-Identifier: BSD-3-Clause
// The models a peer can be given: those of the program's own list, and those of the cases in ../kept_aside.
#include <stdexcept>

#include "kept_aside_models.hpp"
#include "model_problem.hpp"
#include "stiffront/model/builtin/angiogenesis.hpp"
#include "stiffront/model/builtin/brusselator.hpp"
#include "stiffront/model/builtin/bz.hpp"
#include "stiffront/model/builtin/fitzhugh_nagumo.hpp"
#include "stiffront/model/builtin/flame.hpp"
#include "stiffront/model/builtin/gray_scott.hpp"
#include "stiffront/model/builtin/ignition.hpp"
#include "stiffront/model/builtin/lambda_omega.hpp"
#include "stiffront/model/builtin/pulse.hpp"
#include "stiffront/model/builtin/slaved_oscillator.hpp"

namespace peers {

namespace {

template <class... Models>
std::unique_ptr<Problem> find(const Setup& setup) {
  std::unique_ptr<Problem> problem;
  ((setup.model == Models::name ? void(problem = problem_of<Models>(setup)) : void()), ...);
  if (!problem) throw std::runtime_error("no model " + setup.model);
  return problem;
}

}  // namespace

std::unique_ptr<Problem> make_problem(const Setup& setup) {
  using namespace stiffront;
  return find<Bz, Brusselator, GrayScott, Flame, FitzhughNagumo, Angiogenesis, Ignition, LambdaOmega, Pulse, SlavedOscillator, Excitable,
              GiererMeinhardt, ChainFlame, EightSpecies, ForcedExcitable, Diurnal>(setup);
}

}  // namespace peers
