// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace stiffront {

/// A place where a test may have the process killed: STIFFRONT_FAILPOINT=NAME kills it there (SIGKILL) at the first passage,
/// STIFFRONT_FAILPOINT=NAME:N at the N-th. Otherwise nothing happens.
void fail_point(const char* name);

}  // namespace stiffront
