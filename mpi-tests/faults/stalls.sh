#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# usage: stalls.sh PROGRAM MPIEXEC CASE
# One stopped rank (SIGSTOP) ends the job within limits.stall_limit_s and a few seconds; a job that is suspended as a whole goes on
# afterwards as if nothing had been.
set -eu
program=$1 mpiexec=$2 case=$3
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
die() { echo "FAILED: $*"; cat "$scratch/log"; exit 1; }
start() {
  "$mpiexec" -n 3 "$program" run "$case" method.name=strang method.step=1e-4 time.end=1e3 limits.stall_limit_s=3 output.checkpoint.every_seconds=0 \
    -o "$scratch/$1" --quiet >"$scratch/log" 2>&1 &
  job=$!
  for _ in $(seq 200); do [ -s "$scratch/$1/history.csv" ] && break; sleep 0.1; done
  sleep 0.5
  mapfile -t ranks < <(pgrep -P $job)
  [ ${#ranks[@]} = 3 ] || die "there are ${#ranks[@]} ranks"
}

start stopped
kill -STOP "${ranks[1]}"
began=$SECONDS
status=0
wait $job 2>/dev/null || status=$?
took=$((SECONDS - began))
kill -KILL "${ranks[1]}" 2>/dev/null || true
[ $status -gt 128 ] || die "a stopped rank ends the job with $status"
[ $took -le 9 ] || die "a stopped rank ends the job after $took s"
grep -Eq "on .*] nothing was completed for .* s \(limits.stall_limit_s = 3\), (in a step|writing output): the job is ended" "$scratch/log" || die "no word of why"

start suspended
kill -STOP "${ranks[@]}"
sleep 7
kill -CONT "${ranks[@]}"
sleep 2
kill -USR2 $job
status=0
wait $job 2>/dev/null || status=$?
[ $status = 75 ] || die "a suspended job ends with $status instead of 75"
echo "a stopped rank ended the job after $took s; a suspended job went on"
