// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <string>
#include <vector>

#include "stiffront/app/options.hpp"

/// The words a case file uses for the enumerations of options.hpp, in the order of their values.
namespace stiffront::app {

template <typename E>
inline constexpr std::array<const char*, 0> choice_words{};

template <>
inline constexpr std::array choice_words<BoundaryKind>{"neumann", "periodic", "dirichlet"};
template <>
inline constexpr std::array choice_words<SplittingOrder>{"reaction-last", "diffusion-last"};
template <>
inline constexpr std::array choice_words<Splitting>{"lie", "strang"};
template <>
inline constexpr std::array choice_words<StepRule>{"k", "kmax", "min"};
template <>
inline constexpr std::array choice_words<StepExponent>{"observed", "published"};
template <>
inline constexpr std::array choice_words<NodeFamily>{"gauss-legendre", "gauss-lobatto", "gauss-radau"};
template <>
inline constexpr std::array choice_words<SdcSplitting>{"preconditioned", "imex", "lie", "strang", "diagonal"};
template <>
inline constexpr std::array choice_words<SdcImplicit>{"diffusion", "reaction"};
template <>
inline constexpr std::array choice_words<SdcSolver>{"auto", "cell-local", "block-tridiagonal", "multigrid"};
template <>
inline constexpr std::array choice_words<SdcCorrection>{"standard", "alternative"};
template <>
inline constexpr std::array choice_words<SdcFinalUpdate>{"auto", "last-node", "quadrature", "extrapolation"};
template <>
inline constexpr std::array choice_words<LinearSolver>{"band", "gmres"};
template <>
inline constexpr std::array choice_words<DiffusionSolver>{"rock4", "crank-nicolson"};
template <>
inline constexpr std::array choice_words<ReactionSolver>{"radau5", "cvode", "trapezoidal"};
template <>
inline constexpr std::array choice_words<Balance>{"auto", "off"};
template <>
inline constexpr std::array choice_words<Positivity>{"report", "reject-step"};
template <>
inline constexpr std::array choice_words<OutputMode>{"interpolate", "land"};
template <>
inline constexpr std::array choice_words<OnFailure>{"stop", "continue"};
template <>
inline constexpr std::array choice_words<ConvergenceKind>{"global", "local"};

template <typename E>
std::string choice_word(E value) {
  return choice_words<E>[static_cast<std::size_t>(value)];
}

template <typename E>
std::vector<std::string> choice_list() {
  return {choice_words<E>.begin(), choice_words<E>.end()};
}

}  // namespace stiffront::app
