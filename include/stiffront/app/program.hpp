// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "stiffront/solvers/model_registry.hpp"

namespace stiffront::app {

/// The whole program: obeys the command line and returns the exit status (see ErrorKind; 0: done). Never throws.
///
/// Commands that need no other rank do not initialise MPI; under mpirun the first process alone prints. A command that
/// does initialises and finalises it here. If one rank fails and the others do not follow within five seconds, the job
/// is aborted.
///
/// A program with a model of its own:
///
///     int main(int argc, char** argv) {
///       stiffront::ModelRegistry models;
///       stiffront::register_builtin_models(models);
///       models.add<MyModel>();
///       return stiffront::app::run(argc, argv, models);
///     }
int run(int argc, char** argv, const ModelRegistry& models);

/// With the built-in models alone.
int run(int argc, char** argv);

}  // namespace stiffront::app
