// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <vector>

#include "stiffront/core/mpi.hpp"
#include "stiffront/mesh/boundary.hpp"
#include "stiffront/mesh/field.hpp"
#include "stiffront/splitting/composition.hpp"

namespace stiffront {

/// Sizes below which errors of species are not judged, so that a species that is not there at t can be judged at all: it grows like a
/// power of the time, every first step makes an error as large as the species itself, and an error relative to that never gets small.
///
/// Where a species' largest modulus is below 1e-12 of the largest of all species, a coarse Lie splitting, steps growing by four from
/// `first`, looks a hundredth of the interval ahead: the floor is a hundredth of the largest modulus it finds. The floor so has the
/// species' own unit; a fraction of another species has not.
/// @param work the splitting's work is added
/// @return one floor a species: 0 for those that are there, or do not appear.
/// @mpi collective. @cost nothing but a pass over u if all species are there.
std::vector<double> floors_of_absent_species(const SplitFlows& flows, double t, double t_end, double first, Field& u,
                                             const Communicator& comm, Work& work);

}  // namespace stiffront
