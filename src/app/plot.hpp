// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "stiffront/app/command_line.hpp"

namespace stiffront::app {

/// Becomes the script that draws (python3 with h5py and matplotlib), which is looked for beside the installed program and in
/// the source tree. @throws Error(io) if there is no script or no python3; otherwise does not return
void plot(const PlotCommand& command);
/// The same with the script that writes reports.
void report(const ReportCommand& command);

}  // namespace stiffront::app
