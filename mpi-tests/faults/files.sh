#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# usage: files.sh PROGRAM MPIEXEC CASE
# Files that cannot grow, a full disk, a folder that cannot be written: status 5 within seconds on any number of ranks, and what was
# there before is whole. The disks are small tmpfs mounts; where mounting is not allowed those parts are left out and said to be.
set -eu
program=$1 mpiexec=$2 case=$3
scratch=$(mktemp -d)
disk=$scratch/disk
mkdir "$disk"
trap 'umount "$disk" 2>/dev/null || true; rm -rf "$scratch"' EXIT
cd "$scratch"
die() { echo "FAILED: $*"; cat err; exit 1; }
expect() {
  local wanted=$1 status=0 began=$SECONDS
  shift
  timeout 60 "$@" >out 2>err || status=$?
  [ $status = "$wanted" ] || die "$* ends with $status instead of $wanted"
  [ $((SECONDS - began)) -le 20 ] || die "$* took $((SECONDS - began)) s"
}
says() { grep -qiF -- "$1" err || die "no word of: $1"; }
facts() { grep -E '"(checksum|accepted)"' "$1/summary.json"; }

# No file may grow beyond 40 MiB: states fit, checkpoints with their history do not.
big=("$case" 'grid.points=[800000]' method.name=sbdf method.initial_step=1e-9 limits.max_steps=9 output.checkpoint.every_steps=2)
limited=(bash -c 'ulimit -f 40960; exec "$@"' limited)
expect 5 "${limited[@]}" "$program" run "${big[@]}" -o big --quiet
says "too large"
expect 0 "$program" info big/fields-000000.h5
[ -z "$(ls big/checkpoints)" ] || die "something is left of the checkpoint: $(ls big/checkpoints)"
expect 4 "${limited[@]}" "$program" run "${big[@]}" output.checkpoint.on_failure=continue -o more --quiet   # 4: limits.max_steps
says "warning: "
says "too large"
says "limits.max_steps"
rm -r big more

expect 5 "$mpiexec" -n 2 "$program" run "$case" -o /proc/nothing-can-be-made-here --quiet
says "cannot be created"
touch occupied
expect 5 "$program" run "$case" -o occupied --quiet
says "is a file, not a folder"

if ! mount -t tmpfs -o size=6m stiffront-test "$disk" 2>err; then
  echo "passed, without the parts that need a mount"
  exit 0
fi
long=("$case" 'grid.points=[4001]' method.name=strang method.step=1e-4 time.end=1.0)
expect 0 "$mpiexec" -n 2 "$program" run "${long[@]}" time.end=1e-3 output.checkpoint.every_steps=5 -o "$disk/run" --quiet
before=$(facts "$disk/run")
cp -r "$disk/run" undisturbed
# Full while states are written ...
expect 5 "$mpiexec" -n 3 "$program" run "${long[@]}" output.every=0.0 output.steps=1 -o "$disk/full" --quiet
says "no space left"
for state in "$disk"/full/fields-*.h5; do expect 0 "$program" info "$state"; done
[ -z "$(find "$disk/full" -name '*.tmp')" ] || die "unfinished files are left: $(find "$disk/full" -name '*.tmp')"
# ... and while a checkpoint is written.
rm -r "$disk/full"
head -c 8m /dev/zero >"$disk/ballast" 2>/dev/null || true
expect 5 "$mpiexec" -n 3 "$program" run "${long[@]}" output.checkpoint.every_steps=1 -o "$disk/run" --restart latest --quiet
says "no space left"
rm "$disk/ballast"
[ "$(facts "$disk/run")" = "$before" ] || die "the summary was damaged"
expect 0 "$program" run "${long[@]}" time.end=2e-3 -o "$disk/run" --restart latest --quiet
! grep -q warning err || die "the checkpoints were damaged"
expect 0 "$program" run "${long[@]}" time.end=2e-3 -o undisturbed --restart latest --quiet
[ "$(facts "$disk/run")" = "$(facts undisturbed)" ] || die "other bits after the disk was full: $(facts "$disk/run") $(facts undisturbed)"
# A file system that has become read-only.
mount -o remount,ro "$disk"
expect 5 "$mpiexec" -n 2 "$program" run "$case" -o "$disk/new" --quiet
says "read-only"
expect 5 "$program" run "${long[@]}" -o "$disk/run" --restart latest --quiet
says "read-only"
echo "all passed"
