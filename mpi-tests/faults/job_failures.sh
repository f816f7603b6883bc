#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# However a rank fails, the job ends soon, with the status of the failure and one message. usage: job_failures.sh PROGRAM MPIEXEC
set -uo pipefail
program=$1
mpiexec=$2
failures=0

# expect HOW STATUS MESSAGE
expect() {
  local output status times
  output=$(timeout 30 "$mpiexec" -n 3 "$program" "$1" 2>&1)
  status=$?
  times=0
  [ -n "$3" ] && times=$(grep -cF -- "$3" <<<"$output")
  if [ "$status" -ne "$2" ] || { [ -n "$3" ] && [ "$times" -ne 1 ]; }; then
    echo "FAILED: $1: status $status instead of $2, message $times times"
    echo "$output"
    failures=$((failures + 1))
  fi
}

expect none 0 ""
expect error-on-all 4 "stiffront: the step size fell below its limit"
expect stopped-on-all 75 "stiffront: stopped on request"
expect error-on-one 3 "stiffront: [rank 2] seen by one rank alone"
expect exception-on-one 70 "stiffront: [rank 2] a bug of the program: nobody expected this"
expect memory-on-one 70 "stiffront: [rank 2] out of memory"
expect unknown-on-one 70 "stiffront: [rank 2] a bug of the program: an exception of unknown type"
expect mpi-on-one 6 "stiffront: [rank 2] MPI_Bcast failed"

[ "$failures" -eq 0 ] && echo "all passed"
exit "$failures"
