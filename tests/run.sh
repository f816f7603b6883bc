#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Builds everything in build/release and runs every test. Arguments go to ctest, e.g. -R Rock4 or -L mpi.
# STIFFRONT_WERROR=ON in the environment makes warnings errors.
set -euo pipefail
# shellcheck source=cmake/packages.sh
. "$(dirname "${BASH_SOURCE[0]}")/../cmake/packages.sh"
cd "$stiffront_root"

require_packages
use_compiler_cache
set_mpi_environment

cmake --preset release -D STIFFRONT_WERROR="${STIFFRONT_WERROR:-OFF}"
cmake --build --preset release
ctest --preset release --parallel 2 "$@"
