#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The numbers of Descombes, Duarte, Dumont, Louvet & Massot, Confluentes Math. 3(3), 2011, measured with this program.

    drivers/reproduce/adaptive_strang.py [kpp] [bz-local] [bz-tables] [discharge] [--program build/stiffront] [--out out/adaptive-strang]

kpp        Table 1 and Figs 1, 2: local errors, critical steps measured and predicted
bz-local   Figs 3, 4: local errors of a BZ wave, their estimates and the predicted error of Strang splitting
bz-tables  Tables 2, 3 and Figs 5, 6: final errors without and with the critical step (minutes; 1e-8 takes an hour: --finest)
discharge  Figs 7, 8: ten pulses, steps and errors

What the numbers should be is in docs/adaptive-strang.md. Needs numpy and h5py.
"""
import argparse
import csv
import glob
import json
import math
import os
import subprocess

import h5py
import numpy as np

TIGHT = ["reaction_solver.tolerance=1e-13", "diffusion_solver.tolerance=1e-13"]
QUIET = ["output.checkpoint.every_seconds=0", "output.every=0", "limits.stall_limit_s=0"]


class Program:
    def __init__(self, path, out):
        self.path, self.out = path, out

    def call(self, command, case, name, *overrides):
        folder = os.path.join(self.out, name)
        force = ["--force"] if command == "run" else []
        subprocess.run([self.path, command, case, "-o", folder, "--quiet", *force, *overrides], check=True)
        return folder

    def run(self, case, name, *overrides):
        return self.call("run", case, name, *QUIET, *overrides)

    def strang_errors(self, case, name, steps, *overrides):
        """Local errors of Strang splitting against a coupled solver, root mean square over maximum."""
        study = f'converge={{steps={steps}, kind="local", reference={{method="cvode", tolerance=1e-13}}}}'
        strang = f'method={{name="strang", step={steps[0]}}}'
        folder = self.call("converge", case, name, strang, study, *QUIET, *TIGHT, *overrides)
        with open(os.path.join(folder, "converge.json")) as f:
            return [row["error"] for row in json.load(f)["rows"]]

    def one_step(self, case, name, dt, epsilon, start, *overrides):
        """Estimated error of one step, and the estimate of the critical step, without its safety factor."""
        method = (f'method={{name="adaptive-strang", tolerance=1e9, epsilon={epsilon}, critical_safety=1.0, '
                  f'initial_step={dt}}}')
        end = [f"time.start={start}", f"time.end={start + dt!r}", "limits.max_steps=1"]
        folder = os.path.join(self.out, name)
        # One attempt is all we want; whether the step is accepted does not matter.
        subprocess.run([self.path, "run", case, "-o", folder, "--quiet", "--force", method, *end, *QUIET, *TIGHT, *overrides],
                       check=False, stderr=subprocess.DEVNULL)
        row = history(folder)[0]
        return row["error"], row["critical_dt"]


def history(folder):
    with open(os.path.join(folder, "history.csv")) as f:
        return [{k: float(v) for k, v in row.items()} for row in csv.DictReader(f)]


def states(folder):
    """Time and fields of every state of a run, in order."""
    result = []
    for path in sorted(glob.glob(os.path.join(folder, "fields-*.h5"))):
        with h5py.File(path) as f:
            names = [s for s in f if s not in ("x", "y")]
            result.append((float(np.ravel(f.attrs["time"])[0]), {s: f[s][...] for s in names}, path))
    return result


def rms_over_max(u, reference):
    return {s: math.sqrt(np.mean((u[s] - reference[s]) ** 2)) / np.abs(reference[s]).max() for s in reference}


def l2_over_l2(u, reference):
    return max(np.linalg.norm(u[s] - reference[s]) / np.linalg.norm(reference[s]) for s in reference)


def kpp(program):
    predicted = 7.106871831e-2 / 3.209621819e-3  # M1/M2, tests/control/travelling_wave_test.cpp
    for k in (1, 10, 100):
        medium = [f"model.parameters.k={k}.0", f"model.diffusion.u={1.0 / k}"]

        def ratio(dt, epsilon):
            strang = program.strang_errors("kpp-1d", "kpp", [dt], *medium)[0]
            distance, estimate = program.one_step("kpp-1d", "kpp", dt, epsilon, 0.0, *medium)
            return math.log(strang / distance), strang, distance, estimate

        for epsilon in (0.05, 0.005, 0.0005):
            a = epsilon * predicted / k
            fa = ratio(a, epsilon)[0]
            b = 1.2 * a
            for _ in range(6):  # secant in the logarithms
                fb = ratio(b, epsilon)[0]
                if abs(fb) < 1e-4 or fb == fa:
                    break
                a, b, fa = b, b * math.exp(max(-1.0, min(1.0, -fb * math.log(b / a) / (fb - fa)))), fb
            print(f"kpp k={k} eps={epsilon}: dt* measured {b:.5g}, predicted {epsilon * predicted / k:.6g}", flush=True)
        l2 = math.sqrt(5001 * 0.028)
        for dt in (0.01 / k, 0.1 / k, 1.0 / k):
            _, strang, distance, estimate = ratio(dt, 0.05)
            print(f"kpp k={k} dt={dt:g}: L2 errors: strang {strang * l2:.5g}, estimate (eps=0.05) {distance * l2:.5g}, "
                  f"dt* estimated there {estimate:.5g}", flush=True)


def bz_start(program, time):
    """A pair of waves, by the coupled solver."""
    cvode = 'method={name="cvode", relative_tolerance=1e-11, absolute_tolerance=1e-13, linear_solver="band"}'
    folder = program.run("bz-1d-long", f"bz-start-{time}", cvode, f"time.end={time}")
    return states(folder)[-1][2]


def bz_local(program):
    start = ["initial={file=\"" + bz_start(program, 0.4) + "\"}", "time.start=0.4", "time.end=0.5"]
    for dt in (1e-6, 1e-5, 1e-4, 2e-4, 5e-4, 1e-3):
        strang = program.strang_errors("bz-1d-long", "bz-local", [dt], *start)[0]
        distance, critical = program.one_step("bz-1d-long", "bz-local", dt, 0.05, 0.4, start[0])
        c_eps = distance / (0.05 * dt * dt)
        predicted = 0.05 * c_eps / critical * dt**3
        print(f"bz dt={dt:g}: strang {strang:.4g}, estimate {distance:.4g}, C0 {strang / dt**3:.4g}, Ceps {c_eps:.4g}, "
              f"predicted strang/true {predicted / strang:.4g}, dt* {critical:.4g}", flush=True)


def bz_tables(program, finest):
    start = ["initial={file=\"" + bz_start(program, 0.2) + "\"}", "time.start=0.2", "time.end=2.2"]
    cvode = 'method={name="cvode", relative_tolerance=1e-11, absolute_tolerance=1e-13, linear_solver="band"}'
    reference = states(program.run("bz-1d-long", "bz-reference", cvode, *start))[-1][1]
    for eta in ("1e-4", "1e-6") + (("1e-8",) if finest else ()):
        for critical in ("false", "true"):
            method = f'method={{name="adaptive-strang", tolerance={eta}, critical_step={critical}}}'
            folder = program.run("bz-1d-long", "bz-run", method, *start)
            errors = rms_over_max(states(folder)[-1][1], reference)
            rows = [r for r in history(folder) if r["accepted"] == 1]
            text = " ".join(f"{errors[s]:.3g}" for s in "abc")
            print(f"bz eta={eta} critical step {critical}: final errors {text}, {len(rows)} steps, last dt {rows[-2]['dt']:.3g}, "
                  f"epsilon {rows[-1]['epsilon']:.4g}, dt* {rows[-1]['critical_dt']:.3g}", flush=True)


def discharge(program):
    cvode = 'method={name="cvode", relative_tolerance=1e-10, absolute_tolerance=1e-2, linear_solver="band"}'
    reference = states(program.run("discharge-1d", "discharge-reference", cvode))
    for t, u, _ in reference:
        print(f"discharge t={t:.3g}: max ne {u['ne'].max():.8g}, np {u['np'].max():.8g}, nn {u['nn'].max():.8g}", flush=True)
    for eta in ("1e-2", "1e-3", "1e-4"):
        for critical in ("false", "true"):
            method = f'method={{name="adaptive-strang", tolerance={eta}, critical_step={critical}, initial_step=1e-10}}'
            folder = program.run("discharge-1d", f"discharge-{eta}-{critical}", method)
            errors = [l2_over_l2(u, r) for (_, u, _), (_, r, _) in zip(states(folder)[1:], reference[1:])]
            print(f"discharge eta={eta} critical step {critical}: errors L2/L2", " ".join(f"{e:.2g}" for e in errors), flush=True)
            rows = history(folder)
            for k in range(10):
                for phase, begin, end in (("pulse", 0.0, 1e-8), ("post", 1e-8, 1e-6)):
                    here = [r for r in rows if k * 1e-6 + begin - 1e-12 < r["time"] < k * 1e-6 + end - 1e-12]
                    taken = [r["dt"] for r in here if r["accepted"] == 1]
                    print(f"  period {k} {phase}: {len(taken)} steps, {len(here) - len(taken)} rejected, dt {min(taken):.2g} .. "
                          f"{max(taken):.2g}, epsilon {here[-1]['epsilon']:.3g}, dt* {here[-1]['critical_dt']:.3g}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("items", nargs="*", metavar="ITEM", help="kpp, bz-local, bz-tables, discharge; none: all")
    parser.add_argument("--program", default="build/stiffront")
    parser.add_argument("--out", default="out/adaptive-strang")
    parser.add_argument("--finest", action="store_true", help="bz-tables: also 1e-8")
    options = parser.parse_args()
    program = Program(options.program, options.out)
    items = {"kpp": lambda: kpp(program), "bz-local": lambda: bz_local(program),
             "bz-tables": lambda: bz_tables(program, options.finest), "discharge": lambda: discharge(program)}
    for item in options.items or items:
        if item not in items:
            parser.error(f"unknown item {item}")
        items[item]()


if __name__ == "__main__":
    main()
