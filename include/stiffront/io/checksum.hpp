// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>

#include "stiffront/mesh/field.hpp"

namespace stiffront {

/// One hash of a state, 16 hexadecimal digits: the same for every number and layout of ranks, and for two states only if they agree in
/// every bit (-0 counts as 0).
///
/// With mix(z) the finaliser of splitmix64 (Steele, Lea & Flood, OOPSLA 2014), point i (x fastest) of species s of n contributes
/// mix(bits + mix(i n + s + 1)); the hash is mix of the sum of all contributions modulo 2^64.
/// @mpi collective on u.comm().
std::string checksum(const Field& u);

}  // namespace stiffront
