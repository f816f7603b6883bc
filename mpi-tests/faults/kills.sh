#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# usage: kills.sh PROGRAM MPIEXEC CASE KILLS [KEY=VALUE ...]
# A run is killed with SIGKILL, over and over: a rank or mpirun at a random moment, or every rank at a point inside the writing of a
# checkpoint. Each time it is started again with --restart latest on another number of ranks. Claims: a killed job is gone within ten
# seconds, no kill leaves a checkpoint that has to be passed over, and every run that gets to its end has the bits of an undisturbed one.
# STIFFRONT_SEED repeats a campaign, but for the timing of the machine.
set -eu
program=$1 mpiexec=$2 case=$3 kills=$4
shift 4
seed=${STIFFRONT_SEED:-$RANDOM}
echo "STIFFRONT_SEED=$seed"
RANDOM=$seed
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
out=$scratch/out
facts() { grep -E '"(checksum|accepted|rejected)"' "$1/summary.json"; cut -d, -f1-10 "$1/history.csv" | cksum; }
die() { echo "FAILED at kill $done_: $*"; cat "$scratch/log"; exit 1; }
moment() { printf '%d.%03d' $(($1 / 1000)) $(($1 % 1000)); }

done_=0
began=$(date +%s%N)
"$program" run "$case" "$@" -o "$scratch/whole" --quiet >"$scratch/log" 2>&1 || die "the undisturbed run"
length=$((($(date +%s%N) - began) / 1000000))  # ms
whole=$(facts "$scratch/whole")
points=(checkpoint.after_shard checkpoint.before_manifest checkpoint.before_rename checkpoint.before_prune)

ends=0
# Starts or continues the run on a random number of ranks; leaves its pid in job.
start() {
  local how=(--force)  # where no checkpoint was finished yet
  [ -z "$(find "$out/checkpoints" -mindepth 1 -maxdepth 1 -not -name '*.tmp' 2>/dev/null)" ] || how=(--restart latest)
  "$@" "$mpiexec" -n $((1 + RANDOM % 4)) "$program" run "$case" "${overrides[@]}" -o "$out" "${how[@]}" --quiet >"$scratch/log" 2>&1 &
  job=$!
}
check_end() {
  [ "$(facts "$out")" = "$whole" ] || die "not the bits of the undisturbed run: $(facts "$out") instead of $whole"
  ! grep -q "cannot be used" "$scratch/log" || die "a checkpoint was broken"
  ends=$((ends + 1))
  rm -rf "$out"
}
overrides=("$@" output.checkpoint.every_steps=3)
while [ "$done_" -lt "$kills" ]; do
  kind=$((RANDOM % 3))
  if [ $kind = 2 ]; then
    start env STIFFRONT_FAILPOINT="${points[RANDOM % 4]}:$((1 + RANDOM % 9))"
  else
    start
    sleep "$(moment $((100 + RANDOM % (length + 400))))"
    mapfile -t ranks < <(pgrep -P $job || true)
    if [ $kind = 1 ]; then
      kill -9 $job 2>/dev/null || true
    elif [ ${#ranks[@]} -gt 0 ]; then
      kill -9 "${ranks[RANDOM % ${#ranks[@]}]}" 2>/dev/null || true
    fi
    # Nothing may go on in the folder once the next run begins.
    for ((i = 0; i < 100; ++i)); do
      alive=0
      for pid in "${ranks[@]}"; do kill -0 "$pid" 2>/dev/null && alive=1; done
      [ $alive = 1 ] || break
      sleep 0.1
    done
    [ $alive = 0 ] || die "ranks live on ten seconds after the kill"
  fi
  status=0
  wait $job 2>/dev/null || status=$?
  if [ $status = 0 ]; then
    check_end
  else
    [ $status -gt 128 ] || die "the killed job ends with $status"
    ! grep -q "cannot be used" "$scratch/log" || die "a checkpoint was broken"
    done_=$((done_ + 1))
  fi
done
start
wait $job || die "the last restart"
check_end
echo "$done_ kills, $ends runs to the end, all with the bits of the undisturbed run"
