#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# usage: same_bits_matrix.sh PROGRAM MPIEXEC [short]
# Fields, steps and counts are the same on 1 to 9 ranks, every layout, balance on and off, every depth of halos, all methods, one and two
# dimensions. Up to eight ranks share memory, nine send messages, unless there are so many processors. `short` takes a sample. What must agree: checksum, steps, work but for communication, step sizes of the history.
set -eu
program=$1 mpiexec=$2 extent=${3:-long}
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
runs=0

facts() { # of the run in $scratch/run
  python3 - "$scratch/run/summary.json" <<'PYTHON'
import json, sys
s = json.load(open(sys.argv[1]))
communication = {"halo_exchanges", "halo_messages", "halo_bytes", "allreduces"}
print(s["checksum"], s["steps"], {k: v for k, v in s["work"].items() if k not in communication})
PYTHON
  cut -d, -f1-10 "$scratch/run/history.csv" | cksum
}

# case DIMENSION CASE KEY=VALUE ...
check() {
  local dimension=$1 name=$2 reference= found layout px py variant
  shift 2
  for layout in $([ "$dimension" = 1 ] && echo "$lines" || echo "$boxes"); do
    px=${layout%x*} py=${layout#*x}
    while read -r variant; do
      # shellcheck disable=SC2086
      "$mpiexec" -n $((px * py)) "$program" run "$name" "$@" $variant "grid.processes=$([ "$dimension" = 1 ] && echo "[$px]" || echo "[$px,$py]")" \
        -o "$scratch/run" --force --quiet >"$scratch/log" 2>&1 </dev/null || {
        echo "FAILED: $name $* $variant on $layout:"
        cat "$scratch/log"
        exit 1
      }
      found=$(facts)
      runs=$((runs + 1))
      [ -n "$reference" ] || reference=$found
      if [ "$found" != "$reference" ]; then
        printf '%s %s\n%s on %s:\n%s\nbut at first:\n%s\n' "$name" "$*" "$variant" "$layout" "$found" "$reference"
        exit 1
      fi
    done <<<"$([ $((px * py)) = 1 ] && head -1 <<<"$variants" || echo "$variants")"
  done
  echo "the same: $name $*"
}

balanced="reaction_solver.balance=auto diffusion_solver.halo_depth=1"
if [ "$extent" = short ]; then
  lines="1x1 5x1" boxes="1x1 3x2"
  variants="$balanced
reaction_solver.balance=off diffusion_solver.halo_depth=3"
  check 2 bz-2d-spiral "grid.points=[67, 61]" method.name=adaptive-strang method.tolerance=1e-3 time.end=2e-3 space.order=4
  check 1 bz-1d method.name=strang method.step=1e-3 time.end=5e-3
  exit 0
fi

lines="1x1 2x1 3x1 4x1 5x1 6x1 7x1 8x1 9x1" boxes="1x1 2x1 1x2 3x1 1x3 4x1 2x2 1x4 5x1 6x1 3x2 2x3 7x1 8x1 4x2 2x4 1x8 3x3"
variants="$balanced
reaction_solver.balance=off diffusion_solver.halo_depth=1
reaction_solver.balance=auto diffusion_solver.halo_depth=2
reaction_solver.balance=off diffusion_solver.halo_depth=5
reaction_solver.balance=auto diffusion_solver.halo_depth=0"
for order in 2 4; do
  check 1 bz-1d space.order=$order method.name=lie method.step=1e-3 time.end=5e-3
  check 1 bz-1d space.order=$order method.name=strang method.step=1e-3 time.end=5e-3
  check 1 bz-1d space.order=$order method.name=adaptive-strang method.tolerance=1e-4 time.end=3e-3
  check 1 bz-1d space.order=$order method.name=dcs method.tolerance=1e-5 time.end=5e-4
  check 2 bz-2d-spiral "grid.points=[67, 61]" space.order=$order method.name=strang method.step=1e-3 time.end=3e-3
  check 2 bz-2d-spiral "grid.points=[67, 61]" space.order=$order method.name=adaptive-strang method.tolerance=1e-3 time.end=3e-3
  check 2 bz-2d-spiral "grid.points=[67, 61]" space.order=$order method.name=dcs method.tolerance=1e-4 time.end=1e-3
done
variants=""
check 1 bz-1d method.name=sbdf method.relative_tolerance=1e-4 time.end=1e-2
check 2 bz-2d-spiral "grid.points=[67, 61]" method.name=sbdf method.relative_tolerance=1e-4 time.end=1e-2
check 1 bz-1d method.name=sdc method.step=5e-4 time.end=2e-3
check 1 bz-1d method.name=cvode time.end=2e-3
check 2 bz-2d-spiral "grid.points=[67, 61]" method.name=cvode time.end=2e-3
echo "$runs runs"
