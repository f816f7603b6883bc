#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# What is too long for every change: run it at night, from any folder. usage: mpi-tests/nightly.sh [PART ...]
#
#   sanitizers  address and undefined-behaviour sanitizers on every unit test and every MPI test on two ranks
#   threads     the watchdog's thread under the thread sanitizer
#   valgrind    memcheck on five MPI tests on two ranks
#   delays      MPI tests on three ranks with random delays before the calls, twenty seeds
#   fuzz        twenty times the mutations of the tests, under the sanitizers; then, where clang is, a minute of libFuzzer on each
#               of tests/fuzz, begun from the built-in cases, tests/corpus and what a run leaves behind
#   bits        the same bits on 1 to 9 ranks, all methods, layouts, depths of halos, with and without balance
#   kills       fifty random kills with each of sbdf, adaptive-strang, dcs and sdc, and with sbdf in two dimensions
#
# Without arguments all of them. The status is the number of parts that failed; each part says how it went.
set -uo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.." || exit 70
# shellcheck source=cmake/packages.sh
. cmake/packages.sh
use_compiler_cache
set_mpi_environment
export OMPI_MCA_pml=ob1 OMPI_MCA_btl_vader_single_copy_mechanism=none
mpiexec=$(command -v mpiexec)
# Open MPI keeps memory for good; what is ours is checked by the ledger of the MPI tests.
export ASAN_OPTIONS=detect_leaks=0 UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1

build_release() { cmake --preset release >/dev/null && cmake --build --preset release; }
build_asan() { cmake --preset asan >/dev/null && cmake --build --preset asan; }

part_sanitizers() { build_asan && ctest --preset asan --parallel 2 --timeout 1200 -R '^unit\.|\.on_2$'; }

part_threads() {
  # Open MPI itself is not built for the sanitizer: the job's own thread is what is looked at, on one process.
  cmake -S . -B build/tsan -G Ninja -D CMAKE_BUILD_TYPE=Debug -D CMAKE_CXX_FLAGS_DEBUG="-g1 -O1" -D STIFFRONT_SANITIZE=thread >/dev/null &&
    cmake --build build/tsan --target stiffront_program || return 1
  local out
  out=$(mktemp -d)
  TSAN_OPTIONS="halt_on_error=1 suppressions=$PWD/mpi-tests/support/tsan.supp" build/tsan/stiffront run bz-1d method.name=strang method.step=1e-3 \
    time.end=0.05 limits.stall_limit_s=30 -o "$out/run" --quiet
  local status=$?
  rm -rf "$out"
  return $status
}

part_valgrind() {
  # valgrind knows nothing of AVX-512.
  cmake -S . -B build/valgrind -G Ninja -D CMAKE_BUILD_TYPE=Debug -D CMAKE_CXX_FLAGS_DEBUG="-g1 -O1" -D STIFFRONT_NATIVE=OFF >/dev/null || return 1
  local test failed=0 tests=(agree checkpoint decomposition halo io)
  cmake --build build/valgrind --target "${tests[@]/%/_mpi_test}" || return 1
  for test in "${tests[@]}"; do
    "$mpiexec" -n 2 valgrind --quiet --error-exitcode=9 --suppressions=/usr/share/openmpi/openmpi-valgrind.supp \
      --suppressions=mpi-tests/support/valgrind.supp \
      "build/valgrind/mpi-tests/${test}_mpi_test" || failed=1
  done
  return $failed
}

part_delays() {
  build_release || return 1
  local seed test failed=0
  for seed in $(seq 20); do
    for test in agree decomposition halo space checkpoint rock4 reaction_balance; do
      STIFFRONT_DELAY_SEED=$seed "$mpiexec" -n 3 "build/release/mpi-tests/${test}_mpi_test" >/dev/null || {
        echo "STIFFRONT_DELAY_SEED=$seed: ${test}_mpi_test fails"
        failed=1
      }
    done
  done
  return $failed
}

part_fuzz() {
  build_asan || return 1
  local area failed=0
  for area in app io model; do
    STIFFRONT_FUZZ_ROUNDS=20 "build/asan/tests/${area}_tests" --gtest_filter='*Mutation*' || failed=1
  done
  if command -v clang++ >/dev/null; then coverage_guided || failed=1; fi
  return $failed
}

coverage_guided() {
  build_release && cmake --preset fuzz && cmake --build --preset fuzz || return 1
  local corpus target line n=0 failed=0
  corpus=$(mktemp -d)
  mkdir "$corpus"/{case_file,expression,manifest,state_file}
  cp drivers/cases/*.toml "$corpus/case_file"
  while IFS= read -r line; do
    n=$((n + 1))
    printf '%s' "$line" >"$corpus/expression/$n"
  done <tests/corpus/expressions.txt
  build/release/stiffront run bz-1d time.end=1e-4 'output.checkpoint={ every_steps = 5 }' -o "$corpus/run" --quiet || return 1
  cp "$corpus"/run/checkpoints/*5/manifest.json "$corpus/manifest/"
  cp "$corpus"/run/fields-000000.h5 "$corpus/state_file/"
  for target in case_file expression manifest state_file; do
    ASAN_OPTIONS=detect_leaks=0:allocator_may_return_null=1 "build/fuzz/tests/fuzz/fuzz_$target" -max_total_time=60 -timeout=10 \
      -max_len=65536 -artifact_prefix="$PWD/build/fuzz/$target-" "$corpus/$target" 2>&1 | tail -3
    [ "${PIPESTATUS[0]}" -eq 0 ] || failed=1
  done
  rm -rf "$corpus"
  return $failed
}

part_kills() {
  build_release || return 1
  local method failed=0
  for method in 'method={ name = "sbdf" }' 'method={ name = "adaptive-strang", tolerance = 1e-4 }' 'method={ name = "dcs", tolerance = 1e-5 }' \
    'method={ name = "sdc", tolerance = 1e-5 }'; do
    bash mpi-tests/faults/kills.sh "$PWD/build/release/stiffront" "$mpiexec" drivers/cases/bz-1d.toml 50 "$method" time.end=0.02 || failed=1
  done
  bash mpi-tests/faults/kills.sh "$PWD/build/release/stiffront" "$mpiexec" drivers/cases/bz-2d-spiral.toml 50 'method={ name = "sbdf" }' \
    time.end=0.003 'grid.points=[128,128]' || failed=1
  return $failed
}

part_bits() { build_release && bash mpi-tests/same_bits_matrix.sh "$PWD/build/release/stiffront" "$mpiexec"; }

parts=("$@")
[ $# -gt 0 ] || parts=(sanitizers threads valgrind delays fuzz bits kills)
failures=0
for part in "${parts[@]}"; do
  say "nightly: $part"
  if "part_$part"; then
    say "nightly: $part passed"
  else
    say "nightly: $part FAILED"
    failures=$((failures + 1))
  fi
done
exit $failures
