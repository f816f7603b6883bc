#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# The program as a user meets it: what it prints where, and its exit status. usage: program_test.sh PROGRAM MPIEXEC
set -uo pipefail
program=$1
mpiexec=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
failures=0

# expect NAME STATUS COMMAND...: runs the command, leaves its output in out and err
expect() {
  local name=$1 status=$2 got
  shift 2
  "$@" >out 2>err
  got=$?
  if [ "$got" -ne "$status" ]; then
    echo "FAILED: $name: status $got instead of $status"
    cat err
    failures=$((failures + 1))
  fi
}
claim() {
  local name=$1
  shift
  if ! "$@"; then
    echo "FAILED: $name"
    failures=$((failures + 1))
  fi
}
lines() { [ "$(wc -l <"$1")" -eq "$2" ]; }
contains() { grep -qF -- "$2" "$1"; }

expect "help" 0 "$program" --help
claim "help is on standard output" contains out "Usage: stiffront"
claim "help leaves standard error empty" lines err 0
expect "version" 0 "$program" --version
expect "help of a command" 0 "$program" run --help
expect "no command" 2 "$program"
claim "a usage error is one line" lines err 1
claim "a usage error leaves standard output empty" lines out 0
expect "unknown command" 2 "$program" rnu
claim "the command meant is named" contains err "did you mean run?"

expect "list" 0 "$program" list
claim "cases are listed" contains out "bz-1d"
expect "list cases" 0 "$program" list cases
claim "one line for each case" lines out "$(find "$3/drivers/cases" -name '*.toml' | wc -l)"
expect "case" 0 "$program" case bz-1d
claim "a case is printed byte for byte" cmp -s out "$3/drivers/cases/bz-1d.toml"
cp out my.toml
expect "unknown case" 2 "$program" case bz-9d

expect "check" 0 "$program" check my.toml time.end=0.5
claim "what to expect is on standard error" contains err "3003 unknowns"
claim "and stands behind the sign of a comment" lines <(grep -v '^# ' err) 0
cp out effective.toml
expect "check of a checked case" 0 "$program" check effective.toml
claim "a complete case is its own completion" cmp -s out effective.toml
expect "check of a built-in case" 0 "$program" check bz-1d time.end=0.5
claim "a built-in case is known by name" cmp -s out effective.toml
expect "bad input" 3 "$program" check my.toml method.tolerance=-1
claim "the message names the key" contains err "method.tolerance: expected a positive number, got -1"
expect "more memory than there is" 3 "$program" run bz-2d-spiral 'grid.points=[3000000, 3000000]' -o huge
claim "both numbers are told" grep -qE '3000000 x 3000000 points need about .* GiB of memory .* GiB are free' err
expect "bad override" 2 "$program" check my.toml method.tolerance
expect "missing file" 5 "$program" check missing.toml
expect "unreadable file" 5 "$program" check .
expect "input reference" 0 "$program" input-reference
claim "the reference is the documentation" cmp -s out "$3/docs/input.md"

expect "info on a missing file" 5 "$program" info missing.h5
expect "info on a text" 5 "$program" info my.toml
expect "plot of a missing folder" 5 "$program" plot missing

expect "closed standard output" 5 bash -c '"$0" list >&-' "$program"
expect "full standard output" 5 bash -c '"$0" list >/dev/full' "$program"

expect "version on three ranks" 0 "$mpiexec" -n 3 "$program" --version
claim "version is printed once" [ "$(grep -c '^stiffront ' out)" -eq 1 ]
expect "check on three ranks" 0 "$mpiexec" -n 3 "$program" check effective.toml
claim "a case is printed once" cmp -s out effective.toml
expect "bad input on three ranks" 3 "$mpiexec" -n 3 "$program" check my.toml method.tolerance=-1
claim "bad input is reported once" [ "$(grep -c 'expected a positive number' err)" -eq 1 ]

[ "$failures" -eq 0 ] && echo "all passed"
exit "$failures"
