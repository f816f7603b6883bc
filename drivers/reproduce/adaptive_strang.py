#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""The numbers of Descombes, Duarte, Dumont, Louvet & Massot, Confluentes Math. 3(3), 2011, measured with this program.

    drivers/reproduce/adaptive_strang.py [ITEM ...] [--program build/release/stiffront] [--out out/adaptive-strang]

kpp        Table 1 and Figs 1, 2: local errors, critical steps measured and predicted
bz-local   Figs 3, 4: local errors of a BZ wave, their estimates and the predicted error of Strang splitting
bz-tables  Tables 2, 3 and Figs 5, 6: steps and final errors without and with the critical step (a minute; with 1e-8, --finest, a quarter of an hour)
discharge  Figs 7, 8: ten pulses, densities, steps and errors
variants   other models, parameters and dimensions: the error at the end, measured and estimated (minutes; half an hour with 1e-8, --finest)

Every item prints its numbers, and leaves them as ITEM.json and pictures as ITEM-*.png in the folder --out. What they should be is in
docs/adaptive-strang.md. Needs numpy, h5py and matplotlib (Debian: python3-h5py python3-matplotlib).
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

import adaptive_strang_pictures as pictures

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

    def keep(self, item, numbers):
        """Leaves the numbers of an item and draws them."""
        with open(os.path.join(self.out, item + ".json"), "w") as f:
            json.dump(numbers, f, indent=1)
        for path in pictures.draw(item, numbers, self.out):
            print("drawn:", path)


def history(folder):
    with open(os.path.join(folder, "history.csv")) as f:
        return [{k: float(v) for k, v in row.items()} for row in csv.DictReader(f)]


def summary(folder):
    with open(os.path.join(folder, "summary.json")) as f:
        return json.load(f)


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


def worst_rms_over_max(u, reference):
    return max(rms_over_max(u, reference).values())


def l2_over_l2(u, reference):
    return max(np.linalg.norm(u[s] - reference[s]) / np.linalg.norm(reference[s]) for s in reference)


def kpp(program):
    predicted = 7.106871831e-2 / 3.209621819e-3  # M1/M2, tests/control/travelling_wave_test.cpp
    l2 = math.sqrt(5001 * 0.028)
    shifts = (0.05, 0.005, 0.0005)
    numbers = {"critical": [], "local": []}
    for k in (1, 10, 100):
        medium = [f"model.parameters.k={k}.0", f"model.diffusion.u={1.0 / k}"]

        def errors(dt, epsilon):
            strang = program.strang_errors("kpp-1d", "kpp", [dt], *medium)[0]
            return (strang, *program.one_step("kpp-1d", "kpp", dt, epsilon, 0.0, *medium))

        def ratio(dt, epsilon):
            strang, distance, _ = errors(dt, epsilon)
            return math.log(strang / distance)

        for epsilon in shifts:
            a = epsilon * predicted / k
            fa = ratio(a, epsilon)
            b = 1.2 * a
            for _ in range(6):  # secant in the logarithms
                fb = ratio(b, epsilon)
                if abs(fb) < 1e-4 or fb == fa:
                    break
                a, b, fa = b, b * math.exp(max(-1.0, min(1.0, -fb * math.log(b / a) / (fb - fa)))), fb
            print(f"kpp k={k} eps={epsilon}: dt* measured {b:.5g}, predicted {epsilon * predicted / k:.6g}", flush=True)
            numbers["critical"].append({"k": k, "epsilon": epsilon, "measured": b, "predicted": epsilon * predicted / k})
        for dt in (1e-3 / k, 1e-2 / k, 0.1 / k, 0.3 / k, 1.0 / k, 3.0 / k):
            strang, distances = None, {}
            for epsilon in shifts:
                strang, distances[str(epsilon)], estimate = errors(dt, epsilon)
                distances[str(epsilon)] *= l2
                print(f"kpp k={k} dt={dt:g}: L2 errors: strang {strang * l2:.5g}, estimate (eps={epsilon}) {distances[str(epsilon)]:.5g}, "
                      f"dt* estimated there {estimate:.5g}", flush=True)
            numbers["local"].append({"k": k, "dt": dt, "strang": strang * l2, "distance": distances})
    program.keep("kpp", numbers)


def bz_start(program, time):
    """A pair of waves, by the coupled solver."""
    cvode = 'method={name="cvode", relative_tolerance=1e-11, absolute_tolerance=1e-13, linear_solver="band"}'
    folder = program.run("bz-1d-long", f"bz-start-{time}", cvode, f"time.end={time}")
    return states(folder)[-1][2]


def bz_local(program):
    start = ["initial={file=\"" + bz_start(program, 0.4) + "\"}", "time.start=0.4", "time.end=0.5"]
    numbers = []
    for dt in (1e-6, 1e-5, 1e-4, 2e-4, 5e-4, 1e-3):
        strang = program.strang_errors("bz-1d-long", "bz-local", [dt], *start)[0]
        distance, critical = program.one_step("bz-1d-long", "bz-local", dt, 0.05, 0.4, start[0])
        c_eps = distance / (0.05 * dt * dt)
        predicted = 0.05 * c_eps / critical * dt**3
        print(f"bz dt={dt:g}: strang {strang:.4g}, estimate {distance:.4g}, C0 {strang / dt**3:.4g}, Ceps {c_eps:.4g}, "
              f"predicted strang/true {predicted / strang:.4g}, dt* {critical:.4g}", flush=True)
        numbers.append({"dt": dt, "strang": strang, "distance": distance, "c0": strang / dt**3, "c_epsilon": c_eps,
                        "predicted": predicted, "critical": critical})
    program.keep("bz-local", numbers)


def bz_tables(program, finest):
    start = ["initial={file=\"" + bz_start(program, 0.2) + "\"}", "time.start=0.2", "time.end=2.2"]
    references = []
    for tolerance in ("1e-12", "1e-11"):
        cvode = f'method={{name="cvode", relative_tolerance={tolerance}, absolute_tolerance=1e-14, linear_solver="band"}}'
        references.append(states(program.run("bz-1d-long", "bz-reference", cvode, *start))[-1][1])
    print(f"bz: two references are {worst_rms_over_max(references[1], references[0]):.2g} apart", flush=True)
    kinds = {"Table 2": "critical_step=false", "Table 3": "final_error=0", "default": "critical_step=true"}
    numbers = []
    for eta in ("1e-4", "1e-6") + (("1e-8",) if finest else ()):
        for kind, key in kinds.items():
            method = f'method={{name="adaptive-strang", tolerance={eta}, {key}}}'
            folder = program.run("bz-1d-long", "bz-run", method, *start)
            errors = rms_over_max(states(folder)[-1][1], references[0])
            rows = history(folder)
            taken = [r for r in rows if r["accepted"] == 1]
            text = " ".join(f"{errors[s]:.3g}" for s in "abc")
            estimate = summary(folder).get("final_error")
            print(f"bz eta={eta} {kind}: final errors {text}, estimated {estimate}, {len(taken)} steps, "
                  f"{len(rows) - len(taken)} rejected, last dt {taken[-2]['dt']:.3g}, epsilon {taken[-1]['epsilon']:.4g}, "
                  f"dt* {taken[-1]['critical_dt']:.3g}", flush=True)
            every = max(1, len(taken) // 1000)
            numbers.append({"eta": float(eta), "kind": kind, "errors": errors, "estimate": estimate,
                            "steps": len(taken), "rejected": len(rows) - len(taken), "epsilon": taken[-1]["epsilon"],
                            "history": [{k: r[k] for k in ("time", "dt", "error", "critical_dt")} for r in taken[:50] + taken[50:-1:every]]})
    program.keep("bz-tables", numbers)


def discharge(program):
    cvode = 'method={name="cvode", relative_tolerance=1e-10, absolute_tolerance=1e-2, linear_solver="band"}'
    reference = states(program.run("discharge-1d", "discharge-reference", cvode))
    numbers = {"reference": [], "runs": []}
    for t, u, path in reference:
        largest = {s: float(u[s].max()) for s in ("ne", "np", "nn")}
        print(f"discharge t={t:.3g}: max " + ", ".join(f"{s} {v:.8g}" for s, v in largest.items()), flush=True)
        with h5py.File(path) as f:
            x = np.ravel(f["x"][...])
        numbers["reference"].append({"time": t, "largest": largest, "x": x[:120].tolist(), "ne": np.ravel(u["ne"])[:120].tolist()})
    for eta in ("1e-2", "1e-3", "1e-4"):
        for kind, key in (("eps = 0.05", "critical_step=false"), ("full strategy", "final_error=0"), ("default", "critical_step=true")):
            method = f'method={{name="adaptive-strang", tolerance={eta}, initial_step=1e-10, {key}}}'
            folder = program.run("discharge-1d", "discharge-run", method)
            errors = [l2_over_l2(u, r) for (_, u, _), (_, r, _) in zip(states(folder)[1:], reference[1:])]
            rows = history(folder)
            print(f"discharge eta={eta} {kind}: {len(rows)} attempts, errors L2/L2", " ".join(f"{e:.2g}" for e in errors), flush=True)
            periods = []
            for k in range(10):
                for phase, begin, end in (("pulse", 0.0, 1e-8), ("post", 1e-8, 1e-6)):
                    here = [r for r in rows if k * 1e-6 + begin - 1e-12 < r["time"] < k * 1e-6 + end - 1e-12]
                    taken = [r["dt"] for r in here if r["accepted"] == 1]
                    print(f"  period {k} {phase}: {len(taken)} steps, {len(here) - len(taken)} rejected, dt {min(taken):.2g} .. "
                          f"{max(taken):.2g}, epsilon {here[-1]['epsilon']:.3g}, dt* {here[-1]['critical_dt']:.3g}")
                    periods.append({"period": k, "phase": phase, "steps": len(taken), "rejected": len(here) - len(taken),
                                    "least": min(taken), "largest": max(taken)})
            numbers["runs"].append({"eta": float(eta), "kind": kind, "errors": errors, "periods": periods,
                                    "history": [{k: r[k] for k in ("time", "dt", "error", "critical_dt", "accepted")} for r in rows]})
    program.keep("discharge", numbers)


def custom(rates, diffusion, initial, lower, upper, points, end, dimension=1):
    """The text of a case: rates, diffusion and initial by the name of the species."""
    def lines(entries):
        return "\n".join(f'{name} = "{value}"' for name, value in entries.items())

    return f"""[grid]
points = {[points] * dimension}
lower = {[lower] * dimension}
upper = {[upper] * dimension}
[model]
name = "custom"
species = {json.dumps(list(rates))}
[model.diffusion]
{lines(diffusion)}
[model.reaction]
{lines(rates)}
[initial]
{lines(initial)}
[time]
end = {end}
[method]
name = "adaptive-strang"
"""


def front(rate, diffusion, initial, half_width, points, end, dimension=1):
    return custom({"u": rate}, {"u": diffusion}, {"u": initial}, -half_width, half_width, points, end, dimension)


def discharge_of(field, pulse, period, start=0.0, periods=2, electrode=0.01):
    """Some periods, with states after every pulse and at the end."""
    end = periods * period
    jumps = [float(f"{k * period + phase:.12g}") for k in range(periods) for phase in (0.0, pulse)]
    jumps = [t for t in jumps if start < t < end]
    return "discharge-1d", [f"model.parameters={{field={field}, period={period}, pulse={pulse}, electrode={electrode}}}",
                            f"time.start={start}", f"time.end={end}", f"time.breakpoints={jumps}",
                            f"time.restart_step={{period={period}, step={pulse}}}",
                            f"output.times={[t for t in jumps if t % period > 0.5 * pulse] + [end]}"]


VARIANTS = {  # a case, or the text of one, and what is changed
    "KPP, k = 0.5": ("kpp-1d", ["model.parameters.k=0.5", "model.diffusion.u=2.0", "grid.points=[2001]"]),
    "KPP, k = 3": ("kpp-1d", ["model.parameters.k=3.0", "grid.points=[2001]", "time.end=15.0"]),
    "KPP, k = 10": ("kpp-1d", ["model.parameters.k=10.0", "model.diffusion.u=0.1"]),
    "KPP, k = 30": ("kpp-1d", ["model.parameters.k=30.0", "model.diffusion.u=0.0333333333333", "grid.lower=[-20.0]", "grid.upper=[20.0]",
                               "time.end=5.0"]),
    "10 u (1 - u)(u - 1/4)": (front("10*u*(1-u)*(u-0.25)", 1.0, "1/(1+exp(sqrt(5)*(x+10)))", 30, 1501, 20), []),
    "10 u (1 - u)": (front("10*u*(1-u)", 0.1, "1/(1+exp(10/sqrt(6)*(x+10)))^2", 30, 1501, 10), []),
    "5 u^3 (1 - u)": (front("5*u^3*(1-u)", 1.0, "1/(1+exp(x+20))", 40, 1601, 30), []),
    "30 u (1 - u) exp(5 u - 5)": (front("30*u*(1-u)*exp(-5*(1-u))", 0.5, "1/(1+exp(4*(x+10)))", 20, 1601, 10), []),
    "BZ, f = 1.6": ("bz-1d", []),
    "BZ, f = 2": ("bz-1d", ["model.parameters.f=2.0", "time.end=0.6"]),
    "BZ, f = 1.8, q = 1e-3": ("bz-1d", ["model.parameters.f=1.8", "model.parameters.q=1e-3", "time.end=0.6"]),
    "BZ in two variables": ("bz2-1d", []),
    "BZ in two variables, f = 2.5, q = 1e-3": ("bz2-1d", ["model.parameters.f=2.5", "model.parameters.q=1e-3"]),
    "BZ spiral in 2-D": ("bz-2d-spiral", ["grid.points=[48,48]", "time.end=0.2"]),
    "FitzHugh-Nagumo": ("fhn-1d", []),
    "FitzHugh-Nagumo, a = 0.2": ("fhn-1d", ["model.parameters.a=0.2", "time.end=3.0"]),
    "Brusselator": ("brusselator-1d", []),
    "Brusselator, B = 3.4": ("brusselator-1d", ["model.parameters.B=3.4"]),
    "Brusselator, stiff": ("brusselator-stiff-1d", []),
    "Brusselator in 2-D": ("brusselator-2d", ["grid.points=[48,48]"]),
    "flame": ("flame-1d", []),
    "thermal explosion": ("ignition-1d", []),
    "lambda-omega": ("lambda-omega-1d", []),
    "switched source": ("pulse-1d", []),
    "switched source, other times": ("pulse-1d", ["model.parameters.on=0.17", "model.parameters.off=0.41", "time.breakpoints=[0.17,0.41]"]),
    "angiogenesis": ("angiogenesis-1d", []),
    "KPP in 2-D": (front("10*u^2*(1-u)", 0.1, "1/(1+exp(10*(sqrt(x^2+y^2)-3)/sqrt(2)))", 8, 96, 2, dimension=2), []),
    "discharge": discharge_of(4e4, 1e-8, 1e-6),
    "discharge, 30 kV/cm": discharge_of(3e4, 1e-8, 1e-6),
    "discharge, 35 kV/cm": discharge_of(3.5e4, 1e-8, 1e-6),
    "discharge, 50 kV/cm": discharge_of(5e4, 1e-8, 1e-6),
    "discharge, 40 kV/cm for 4 ns every 0.37 us": discharge_of(4e4, 4e-9, 3.7e-7),
    "discharge, 30 kV/cm for 25 ns every 2.3 us": discharge_of(3e4, 2.5e-8, 2.3e-6),
    "Gray-Scott pulses": ("gray-scott-1d", ["time.end=200.0"]),
    # None of these had a part in how the limit on the step was chosen.
    "KPP, k = 100": ("kpp-1d", ["model.parameters.k=100.0", "model.diffusion.u=0.01", "grid.lower=[-5.0]", "grid.upper=[5.0]", "grid.points=[3001]",
                                "time.end=2.0"]),
    "20 u (1 - u^2)": (front("20*u*(1-u^2)", 0.2, "1/(1+exp(5*(x+15)))", 20, 1601, 6), []),
    "40 u^2 (1 - u)^2": (front("40*u^2*(1-u)^2", 0.5, "1/(1+exp(3*(x+20)))", 30, 2001, 10), []),
    "60 u (1 - u)(u - 2/5)": (front("60*u*(1-u)*(u-0.4)", 0.5, "1/(1+exp(7*(x+5)))", 15, 1501, 10), []),
    "40 u (1 - u)(u - 1/5) in 2-D": (front("40*u*(1-u)*(u-0.2)", 0.05, "1/(1+exp(15*(sqrt(x^2+2*y^2)-2)))", 5, 80, 1.5, dimension=2), []),
    "BZ, f = 1.4": ("bz-1d", ["model.parameters.f=1.4"]),
    "BZ, f = 2.5, q = 1e-3": ("bz-1d", ["model.parameters.f=2.5", "model.parameters.q=1e-3", "time.end=0.6"]),
    "BZ in two variables, f = 1.4, q = 1e-3": ("bz2-1d", ["model.parameters.f=1.4", "model.parameters.q=1e-3"]),
    "BZ in two variables, f = 3, q = 2e-4": ("bz2-1d", ["model.parameters.f=3.0", "model.parameters.q=2e-4", "time.end=0.6"]),
    "BZ in two variables, spiral in 2-D": ("bz-2d-spiral", ['model={name="bz2", parameters={epsilon=1e-2, f=1.6, q=2e-3}, diffusion={b=2.5e-3, c=1.5e-3}}',
                                                              'initial.profile="bz2-spiral"', "grid.points=[48,48]", "time.end=0.3"]),
    "FitzHugh-Nagumo, gamma = 2": ("fhn-1d", ["model.parameters.gamma=2.0", "time.end=4.0"]),
    "FitzHugh-Nagumo, epsilon = 0.02, a = 0.05": ("fhn-1d", ["model.parameters.epsilon=0.02", "model.parameters.a=0.05"]),
    "predators after prey": (custom({"u": "10*u*(1-u)-12*u*v/(0.3+u)", "v": "8*u*v/(0.3+u)-3*v"}, {"u": 0.01, "v": 0.02},
                                    {"u": "1-0.5*exp(-40*(x-1)^2)", "v": "0.2*exp(-20*(x-1)^2)"}, 0.0, 6.0, 601, 4.0), []),
    "Schnakenberg": (custom({"u": "20*(0.1-u+u^2*v)", "v": "20*(0.9-u^2*v)"}, {"u": 1e-3, "v": 4e-2},
                            {"u": "1+0.1*cos(2*pi*x)", "v": "0.9+0.05*cos(4*pi*x)"}, 0.0, 1.0, 201, 2.0), []),
    "Gray-Scott in 2-D": ("gray-scott-2d", ["grid.points=[64,64]", "grid.upper=[0.625,0.625]", "model.parameters={F=0.035, k=0.062}", "time.end=200.0"]),
    "lambda-omega to t = 30": ("lambda-omega-1d", ["time.end=30.0"]),
    "discharge, 45 kV/cm": discharge_of(4.5e4, 1e-8, 1e-6),
    "discharge, 25 kV/cm for 50 ns every 5 us": discharge_of(2.5e4, 5e-8, 5e-6),
    "discharge, 36 kV/cm for 2 ns every 0.1 us": discharge_of(3.6e4, 2e-9, 1e-7),
    "discharge, first pulse 0.57 us after the start": discharge_of(4e4, 1e-8, 1e-6, start=4.3e-7),
    "discharge, 38 kV/cm over 3 mm, begun within a pulse": discharge_of(3.8e4, 2e-8, 7e-7, start=5e-9, electrode=0.03),
}


def variants(program, only, finest):
    numbers = []
    for name, (case, changes) in VARIANTS.items():
        if only and only not in name:
            continue
        if "\n" in case:
            path = os.path.join(program.out, "variant.toml")
            with open(path, "w") as f:
                f.write(case)
            case = path
        solver = "gmres" if "2-D" in name else "band"
        absolute = "1e-2" if "discharge" in name else "1e-14"
        cvode = f'method={{name="cvode", relative_tolerance=1e-12, absolute_tolerance={absolute}, linear_solver="{solver}"}}'
        reference = [u for _, u, _ in states(program.run(case, "variant-reference", cvode, *changes))[1:]]
        for eta in (1e-4, 1e-5, 1e-6) + ((1e-8,) if finest else ()):
            row = {"variant": name, "eta": eta}
            for kind, key in (("kept", ""), ("free", ", final_error=0")):
                folder = program.run(case, "variant", f'method={{name="adaptive-strang", tolerance={eta}{key}}}', *changes)
                end = summary(folder)
                # The worst of all states written, the last among them.
                errors = [worst_rms_over_max(u, r) / eta for (_, u, _), r in zip(states(folder)[1:], reference, strict=True)]
                row[kind], row[kind + "_last"] = max(errors), errors[-1]
                row[kind + "_steps"] = end["steps"]["accepted"]
                # What the estimated errors of all steps would add up to: err is larger than that of Strang splitting by dt*/(zeta dt).
                row[kind + "_sum"] = sum(r["error"] * min(1.0, 0.9 * r["dt"] / r["critical_dt"]) for r in history(folder) if r["accepted"] == 1) / eta
                if kind == "kept":
                    row["estimate"] = end["final_error"] / eta if "final_error" in end else None
            print(f"{name}, eta {eta:g}: error {row['kept']:.2f} eta (last {row['kept_last']:.2f}, estimated {row['estimate']:.2f}), "
                  f"{row['kept_steps']} steps; final_error=0: {row['free']:.2f} eta, {row['free_steps']} steps, local errors add up to "
                  f"{row['free_sum']:.3g} eta", flush=True)
            numbers.append(row)
    program.keep("variants", numbers)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("items", nargs="*", metavar="ITEM", help="kpp, bz-local, bz-tables, discharge, variants; none: all")
    parser.add_argument("--program", default="build/release/stiffront")
    parser.add_argument("--out", default="out/adaptive-strang")
    parser.add_argument("--finest", action="store_true", help="bz-tables, variants: also 1e-8")
    parser.add_argument("--only", default="", help="variants: those with this in their name")
    options = parser.parse_args()
    os.makedirs(options.out, exist_ok=True)
    program = Program(options.program, options.out)
    items = {"kpp": lambda: kpp(program), "bz-local": lambda: bz_local(program),
             "bz-tables": lambda: bz_tables(program, options.finest), "discharge": lambda: discharge(program),
             "variants": lambda: variants(program, options.only, options.finest)}
    for item in options.items or items:
        if item not in items:
            parser.error(f"unknown item {item}")
        items[item]()


if __name__ == "__main__":
    main()
