#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# usage: numerics.sh PROGRAM MPIEXEC
# A solution that blows up in one cell, rates that have no value and negative concentrations: the same report on any number of ranks,
# status 4, the last good state, and a case file in which the cell fails alone.
set -eu
program=$1 mpiexec=$2
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cd "$scratch"
die() { echo "FAILED: $*"; cat err; exit 1; }
# expect STATUS COMMAND...
expect() {
  local wanted=$1 status=0
  shift
  timeout 60 "$@" >out 2>err || status=$?
  [ $status = "$wanted" ] || die "$* ends with $status instead of $wanted"
}
says() { grep -qF -- "$1" err || die "no word of: $1"; }

cat >blow-up.toml <<'END'
[grid]
points = [65]
[model]
name = "custom"
species = ["u", "v"]
diffusion = { u = 1e-4, v = 1e-4 }
[model.reaction]
u = "u^2"
v = "-0.5*v"
[initial]
u = "0.3 + 2*exp(-100*(x - 0.5)^2)"
v = 1
[time]
end = 1.0
[method]
name = "strang"
step = 0.02
END

expect 4 "$program" run blow-up.toml -o one --quiet
says "cell (32, 0) at x = 0.5, y = 0, t = 0.437"
says "the inner step size has become too small"
says "u = "
says "v = 0.80"
says "stiffront run one/failed-cell.toml runs this cell alone"
cp err one.err
expect 4 "$mpiexec" -n 3 "$program" run blow-up.toml -o three --quiet
[ "$(grep -o 'cell (32.*runs' err | sed s/three/one/)" = "$(grep -o 'cell (32.*runs' one.err)" ] || die "three ranks tell another story"
expect 0 "$program" info one/failed-0*.h5
grep -q '"status": "failed"' one/summary.json || die "the summary does not say so"
expect 4 "$program" run one/failed-cell.toml --quiet
says "the inner step size has become too small"
says "at x = 0.5, y = 0, t = 0.437"
for method in 'name = "adaptive-strang"' 'name = "dcs", tolerance = 1e-4' 'name = "sbdf"' 'name = "lie", step = 0.01'; do
  expect 4 "$program" run blow-up.toml "method={ $method }" -o many --quiet --force
  says "the step size underflowed at t = 0.4"
done

# Rates without a value where u has grown beyond 1.
sed 's/u^2/sqrt(1 - u)/' blow-up.toml >root.toml
expect 4 "$program" run root.toml 'initial.u="0.9 + 0.05*x"' -o root --quiet
says "the rates are not finite"

# Negative values: counted, or refused.
sed 's/u = "u^2"/u = "-1"/' blow-up.toml >sink.toml
for method in 'name = "strang", step = 0.02' 'name = "adaptive-strang"' 'name = "dcs", tolerance = 1e-4' 'name = "sbdf"'; do
  expect 0 "$program" run sink.toml "method={ $method }" -o sink --quiet --force
  grep -q '"negatives": 0' sink/summary.json && die "negative states are not counted with $method"
  expect 4 "$program" run sink.toml "method={ $method }" reaction_solver.positivity=reject-step -o sink --quiet --force
  says "the new state is negative somewhere"
  says "species u: it becomes -"
  grep -q '"negatives": 0' sink/summary.json || die "a negative state was accepted with $method"
done
# What a smaller step cures is cured: loose tolerances overshoot.
cured() {
  expect 0 "$program" run sink.toml "$@" -o loose --quiet --force
  grep -q '"negatives": 0' loose/summary.json && die "nothing is negative to begin with: $*"
  expect 0 "$program" run sink.toml "$@" reaction_solver.positivity=reject-step -o cured --quiet --force
  grep -q '"negatives": 0' cured/summary.json || die "negative states were accepted: $*"
  ! grep -q '"rejected": 0' cured/summary.json || die "no step was rejected: $*"
}
cured model.reaction.u=-u 'initial.u=if(abs(x - 0.5) < 0.01, 1, 0)' model.diffusion.u=1e-2 method.step=0.1 diffusion_solver.tolerance=0.3
cured model.reaction.u=-50*u 'method={ name = "sbdf", relative_tolerance = 0.1, absolute_tolerance = 0.1 }' time.end=2.0
echo "all passed"
