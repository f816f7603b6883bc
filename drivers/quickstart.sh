#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# From a bare Debian 12 to the first picture: packages, build, a travelling wave on two ranks, a plot.
set -euo pipefail
# shellcheck source=cmake/packages.sh
. "$(dirname "${BASH_SOURCE[0]}")/../cmake/packages.sh"
cd "$stiffront_root"

require_packages
use_compiler_cache
set_mpi_environment

say "building build/release/stiffront"
cmake --preset release
cmake --build --preset release --target stiffront_program

out=out/quickstart
say "a Belousov-Zhabotinsky wave on two ranks: drivers/cases/bz-1d.toml -> $out"
mpirun -n 2 build/release/stiffront run drivers/cases/bz-1d.toml -o "$out" --force

say "drawing"
if build/release/stiffront plot "$out" -o "$out/plot.png" >/dev/null; then
  say "the picture: $stiffront_root/$out/plot.png"
else
  say "no picture was drawn; the results are in $stiffront_root/$out"
  exit 1
fi
