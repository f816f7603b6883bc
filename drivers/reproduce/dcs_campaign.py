#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Whatever step or tolerance is asked of dcs, it ends near the solution or says why not: every built-in case, every tolerance, fixed steps
from far beyond the limit of stability to far below.

    drivers/reproduce/dcs_campaign.py [adaptive] [fixed] [--case NAME ...] [--program build/release/stiffront] [--out out/dcs-campaign]

adaptive  tolerances 1e-2 ... 1e-12: steps, rejections, error at the end over the tolerance and over 10 tolerance steps^(1/2)
fixed     k = 0 ... 6 corrections with steps of 1/1 ... 1/4096 of the time span: solved, refused with the limit of stability, or at fault

A run is at fault if it does not end, ends otherwise than with the solution or an error that says what to do, if an adaptive one fails at
all or misses the bound, or if a fixed one ends with an error in the solution of more than twice its size. References: cvode, 1e-13.
Cases with first derivatives are not here: dcs refuses them. Exit status 1 if one is at fault. About a quarter of an hour. Needs numpy and h5py.
"""
import argparse
import glob
import json
import math
import os
import subprocess
import sys
import tempfile

import h5py
import numpy as np

# The part of the time span that is run, and smaller grids where two dimensions would take long.
CASES = {
    "angiogenesis-1d": (0.002, []), "brusselator-1d": (1.0, []), "brusselator-sdc-1d": (1.0, []), "brusselator-2d": (0.2, ["grid.points=[32, 32]"]),
    "brusselator-stiff-1d": (0.02, []), "bz-1d": (0.05, []), "bz-1d-long": (0.01, []), "bz-2d-spiral": (0.02, ["grid.points=[40, 40]"]),
    "bz2-1d": (0.1, []), "dahlquist": (5.1, []), "discharge-1d": (2e-8, ["time.breakpoints=[1e-8]"]), "fhn-1d": (0.5, []), "flame-1d": (0.8, []),
    "gray-scott-1d": (50.0, []), "gray-scott-2d": (40.0, ["grid.points=[40, 40]"]), "ignition-1d": (0.8, []), "kpp-1d": (1.0, []),
    "lambda-omega-1d": (0.4, []), "pulse-1d": (0.7, []), "slaved-oscillator-1d": (0.3, []), "van-der-pol": (1.0, []),
}
TOLERANCES = [10.0**-n for n in range(2, 13)]
QUIET = ["output.checkpoint.every_seconds=0", "output.every=0", "output.times=[]", "limits.stall_limit_s=0", "--force", "--quiet"]


class Program:
    def __init__(self, path, out):
        self.path, self.out = path, out

    def run(self, case, method):
        """Exit status, message, final fields, accepted, rejected."""
        end, overrides = CASES[case]
        folder = os.path.join(self.out, case)
        for old in glob.glob(os.path.join(folder, "*.h5")):
            os.remove(old)
        try:
            done = subprocess.run([self.path, "run", case, f"method={method}", f"time.end={end!r}", "-o", folder, *QUIET, *overrides],
                                  capture_output=True, text=True, timeout=300, check=False)
        except subprocess.TimeoutExpired:
            return None, "no end in 300 s", None, 0, 0
        if done.returncode != 0:
            return done.returncode, done.stderr.strip(), None, 0, 0
        with open(os.path.join(folder, "summary.json")) as f:
            steps = json.load(f)["steps"]
        with h5py.File(sorted(glob.glob(os.path.join(folder, "fields-*.h5")))[-1]) as f:
            return 0, "", {s: f[s][...] for s in f if s not in ("x", "y")}, steps["accepted"], steps["rejected"]

    def reference(self, case):
        plane = "-2d" in case
        scale = 1e-3 if case == "discharge-1d" else 1e-15
        solver = "gmres" if plane or case in ("pulse-1d",) else "band"
        method = f'{{name="cvode", relative_tolerance=1e-13, absolute_tolerance={scale!r}, linear_solver="{solver}"}}'
        status, text, fields, _, _ = self.run(case, method)
        if status != 0:
            sys.exit(f"{case}: no reference: {text}")
        return fields


def error(u, reference):
    """Largest over the species of the root mean square over the largest modulus."""
    worst = 0.0
    for s, r in reference.items():
        e = math.sqrt(np.mean((u[s] - r) ** 2)) / (np.abs(r).max() or 1.0)
        worst = max(worst, e if math.isfinite(e) else math.inf)
    return worst


def adaptive(program, case, reference):
    faults = []
    for tolerance in TOLERANCES:
        status, text, u, accepted, rejected = program.run(case, f'{{name="dcs", tolerance={tolerance!r}}}')
        if status != 0:
            faults.append(f"{case} tolerance {tolerance:.0e}: {text}")
            print(f"  {tolerance:.0e}: FAILED: {text}", flush=True)
            continue
        e = error(u, reference)
        # The reference itself is good to some 1e-9.
        bound = 10 * tolerance * math.sqrt(accepted) + 1e-9
        print(f"  {tolerance:.0e}: {accepted} steps, {rejected} rejected ({100 * rejected / (accepted + rejected):.0f} %), error {e:.2g} = "
              f"{e / tolerance:.2g} tolerances{'' if e <= bound else ', ABOVE THE BOUND'}", flush=True)
        if e > bound:
            faults.append(f"{case} tolerance {tolerance:.0e}: error {e:.2g}, bound {bound:.2g}")
    return faults


def fixed(program, case, reference):
    faults = []
    end = CASES[case][0]
    for k in range(7):
        outcome = []
        for n in (1, 4, 16, 64, 256, 1024, 4096):
            status, text, u, _, _ = program.run(case, f'{{name="dcs", step={end / n!r}, iterations={k}}}')
            if status == 4 and "limit of stability" in text:
                outcome.append("refused")
            elif status == 0:
                e = error(u, reference)
                outcome.append(f"{e:.1e}")
                if not e < 2.0:
                    faults.append(f"{case} k={k} step {end / n:.3g}: error {e:.2g}")
            else:
                outcome.append("FAULT")
                faults.append(f"{case} k={k} step {end / n:.3g}: status {status}: {text}")
        print(f"  k={k}: " + " ".join(f"{o:>9}" for o in outcome), flush=True)
    return faults


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("items", nargs="*", metavar="ITEM", help="adaptive, fixed; none: both")
    parser.add_argument("--case", action="append", choices=sorted(CASES), metavar="NAME", help="only this one; may be given again")
    parser.add_argument("--program", default="build/release/stiffront")
    parser.add_argument("--out", default=os.path.join(tempfile.gettempdir(), "dcs-campaign"))
    options = parser.parse_args()
    program = Program(options.program, options.out)
    items = {"adaptive": adaptive, "fixed": fixed}
    faults = []
    for case in options.case or CASES:
        print(case, flush=True)
        reference = program.reference(case)
        for item in options.items or items:
            if item not in items:
                parser.error(f"unknown item {item}")
            faults += items[item](program, case, reference)
    print(f"{len(faults)} at fault", *faults, sep="\n  ")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
