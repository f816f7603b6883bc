// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace stiffront {

/// Most memory this process has held so far, in MiB.
double peak_memory_mib();

/// Memory that can be had on this host without swapping, in MiB, no more than what the process's control group may still take; 0 if
/// the system does not say.
double available_memory_mib();

}  // namespace stiffront
