#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# usage: counts.sh PROGRAM MPIEXEC
# What summary.json says of communication: at most one reduction per attempt at a step and per step tried by ROCK4, and exchanges of halos that
# fall by their depth. The output between the initial and the final state has agreements of its own, so there is none.
set -eu
program=$1 mpiexec=$2
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
for depth in 1 4; do
  for method in '{ name = "adaptive-strang", tolerance = 1e-3 }' '{ name = "strang", step = 1e-3 }'; do
    "$mpiexec" -n 4 "$program" run bz-2d-spiral "grid.points=[64, 64]" "method=$method" time.end=4e-3 output.every=0 \
      diffusion_solver.halo_depth=$depth -o "$scratch/run" --force --quiet >"$scratch/log" 2>&1 || { cat "$scratch/log"; exit 1; }
    python3 - "$scratch/run/summary.json" $depth "$method" <<'PYTHON'
import json, math, sys
s, depth, method = json.load(open(sys.argv[1])), int(sys.argv[2]), sys.argv[3]
work = s["work"]
attempts = s["steps"]["accepted"] + s["steps"]["rejected"]
diffusion = work["diffusion_steps"] + work["diffusion_rejections"]
# Whatever the number of steps: the size of the first, the state of the run before and after it, the end of the output.
beside = 10
print(method, depth, attempts, diffusion, work)
assert attempts >= 4 and diffusion >= attempts
assert attempts + diffusion <= work["allreduces"] <= attempts + diffusion + beside, "one reduction per attempt"
assert work["diffusion_stages"] <= depth * work["halo_exchanges"] <= work["diffusion_stages"] + (depth - 1) * diffusion + depth * 4
# Four ranks as 2 x 2: two neighbours each, and one across the corner where several stages share an exchange.
assert 2 * 4 * work["halo_exchanges"] <= work["halo_messages"] <= 3 * 4 * work["halo_exchanges"]
assert work["halo_bytes"] > 0 and s["balance"]["imbalance_after"] > 0
PYTHON
  done
done
