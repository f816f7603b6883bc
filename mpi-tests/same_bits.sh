#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# usage: same_bits.sh PROGRAM MPIEXEC CASE LAYOUTS [--rejections] [KEY=VALUE ...]
# Runs a case on every layout of LAYOUTS ("1x1 2x1 3x1 2x2 ...") and fails unless final state, steps and counts are the same; with
# --rejections also if no step was rejected.
set -eu
program=$1 mpiexec=$2 case=$3 layouts=$4
shift 4
rejections=no
if [ "${1:-}" = --rejections ]; then rejections=yes; shift; fi
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
reference=
for layout in $layouts; do
  px=${layout%x*} py=${layout#*x}
  processes="[$px]"
  grep -Eq '^ *points *= *\[ *[0-9]+ *, ' "$case" && processes="[$px, $py]"
  out=$scratch/$layout
  if ! "$mpiexec" -n $((px * py)) "$program" run "$case" "$@" "grid.processes=$processes" -o "$out" --quiet >"$scratch/log" 2>&1; then
    echo "FAILED on $layout:"; cat "$scratch/log"; exit 1
  fi
  # What must agree: checksum, time, steps, and the step sizes of the history.
  facts=$(grep -E '"(checksum|time|accepted|rejected)"' "$out/summary.json"; cut -d, -f1-10 "$out/history.csv" | cksum)
  if [ $rejections = yes ] && grep -q '"rejected": 0' "$out/summary.json"; then
    echo "no step was rejected on $layout"; exit 1
  fi
  if [ -z "$reference" ]; then
    reference=$facts
  elif [ "$facts" != "$reference" ]; then
    printf 'On %s:\n%s\nbut on %s:\n%s\n' "${layouts%% *}" "$reference" "$layout" "$facts"
    exit 1
  fi
done
printf 'the same on %s:\n%s\n' "$layouts" "$reference"
