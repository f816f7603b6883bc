#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# usage: restart.sh PROGRAM MPIEXEC CASE EVERY [KEY=VALUE ...]
# A run stopped by USR2, and one restarted from a checkpoint in its midst on another number of ranks, must end with the bits of an
# undisturbed run.
set -eu
program=$1 mpiexec=$2 case=$3 every=$4
shift 4
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
facts() { grep -E '"(checksum|accepted|rejected)"' "$1/summary.json"; cut -d, -f1-10 "$1/history.csv" | cksum; }

"$program" run "$case" "$@" -o "$scratch/whole" --quiet
whole=$(facts "$scratch/whole")

# Where nothing is there yet the restart is an error too: a misspelt directory must not begin the run anew.
status=0
"$mpiexec" -n 2 "$program" run "$case" "$@" -o "$scratch/nowhere" --restart latest --quiet 2>/dev/null || status=$?
[ $status = 5 ] || { echo "a restart without results exits with $status"; exit 1; }

"$mpiexec" -n 2 "$program" run "$case" "$@" output.checkpoint.every_steps="$every" -o "$scratch/again" --quiet
[ "$(facts "$scratch/again")" = "$whole" ] || { echo "checkpoints change the run"; facts "$scratch/again"; exit 1; }
"$mpiexec" -n 3 "$program" run "$case" "$@" -o "$scratch/again" --restart latest --quiet
[ "$(facts "$scratch/again")" = "$whole" ] || { printf 'undisturbed:\n%s\nrestarted:\n' "$whole"; facts "$scratch/again"; exit 1; }

# A damaged newest checkpoint is passed over; without any the restart is an error, never a silent new start.
newest=$(ls "$scratch/again/checkpoints" | tail -1)
printf 'x' | dd of="$scratch/again/checkpoints/$newest/manifest.json" bs=1 seek=20 conv=notrunc status=none
"$program" run "$case" "$@" -o "$scratch/again" --restart latest --quiet 2>"$scratch/warning"
grep -q "$newest" "$scratch/warning" || { echo "the damaged checkpoint is not named"; exit 1; }
[ "$(facts "$scratch/again")" = "$whole" ] || { echo "restart from the older checkpoint differs"; exit 1; }
rm -r "$scratch/again/checkpoints"
status=0
"$program" run "$case" "$@" -o "$scratch/again" --restart latest --quiet 2>/dev/null || status=$?
[ $status = 5 ] || { echo "a restart without a checkpoint exits with $status"; exit 1; }

# Asked to stop, the program leaves a checkpoint and exits with 75.
"$program" run "$case" "$@" time.end=1e3 -o "$scratch/stopped" --quiet 2>/dev/null &
pid=$!
for _ in $(seq 100); do [ -f "$scratch/stopped/history.csv" ] && break; sleep 0.1; done
sleep 0.3
kill -USR2 $pid
status=0
wait $pid || status=$?
[ $status = 75 ] || { echo "USR2 ends the run with $status"; exit 1; }
[ -n "$(ls "$scratch/stopped/checkpoints")" ] || { echo "no checkpoint after USR2"; exit 1; }
printf 'undisturbed = restarted:\n%s\n' "$whole"
