#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The figures of Duarte & Emmett, "High order schemes based on operator splitting and deferred corrections for stiff time dependent
PDEs", 2016 (hal-01016684), measured with this program: numbers on the terminal, pictures in the output folder.

    drivers/reproduce/dcs.py [fig1 ... fig7] [window] [rules] [variations] [--program build/release/stiffront] [--out out/dcs]

fig1        the wave at t = 0, 0.1, ..., 1, its speed and largest values
fig2        Lie: local errors from t = 0.5 and global errors over [0.5, 0.6], k = 0 ... 5
fig3        Strang: the same
fig4        local errors beside their estimates (43) and the steps dt_max,k
fig5        adaptive steps, corrections and rejections at t = 0.5 for tolerances 1e-4 ... 1e-12; steps over time for 1e-7
fig6        errors in space on 501 ... 8001 points; errors in space and time on 1001
fig7        local errors with differences of order four, and of order four in the quadrature only
window      error at the end of [0, 1] for tolerances 1e-4 ... 1e-12, and rejections
rules       what is paid for a tolerance with the exponents the errors have and with those of the paper, on the built-in lines
variations  global errors of other kinetics, parameters and dimensions, and how far two references are apart

What the numbers should be is in docs/dcs.md. All of it takes twenty minutes. Needs numpy, h5py and matplotlib.
"""
import argparse
import csv
import glob
import json
import math
import os
import statistics
import subprocess

import h5py
import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (the backend must be chosen first)

QUIET = ["output.checkpoint.every_seconds=0", "output.every=0", "output.times=[]", "limits.stall_limit_s=0"]
COLORS = plt.get_cmap("viridis")(np.linspace(0.0, 0.85, 6))
MARKERS = "osD^v<"
CVODE = 'method={name="cvode", relative_tolerance=1e-13, absolute_tolerance=1e-15, linear_solver="band"}'


class Program:
    def __init__(self, path, out):
        self.path, self.out = path, out
        os.makedirs(out, exist_ok=True)

    def call(self, command, case, name, *overrides):
        folder = os.path.join(self.out, name)
        for old in glob.glob(os.path.join(folder, "fields-*.h5")):
            os.remove(old)
        force = ["--force"] if command == "run" else []
        subprocess.run([self.path, command, case, "-o", folder, "--quiet", *force, *QUIET, *overrides], check=True)
        return folder

    def run(self, case, name, *overrides):
        return self.call("run", case, name, *overrides)

    def start(self):
        """The wave at t = 0.5, by the coupled solver."""
        path = os.path.join(self.out, "start.h5")
        if not os.path.exists(path):
            os.replace(last_file(self.run("bz-1d", "start", CVODE, "time.end=0.5")), path)
        return [f'initial={{file="{path}"}}', "time.start=0.5"]

    def study(self, name, kind, steps, iterations, splitting, *overrides):
        """Rows of an order study of the wave, by step and k."""
        reference = '{method="sdc", step=5e-6}' if kind == "local" else '{method="cvode", tolerance=1e-12}'
        inner = "1e-13" if kind == "local" else "1e-8"
        folder = self.call("converge", "bz-1d", name, *self.start(), "time.end=0.6", f'method={{name="dcs", splitting="{splitting}"}}',
                           f'converge={{kind="{kind}", steps={steps}, iterations={iterations}, reference={reference}}}',
                           f"reaction_solver.tolerance={inner}", f"diffusion_solver.tolerance={inner}", *overrides)
        with open(os.path.join(folder, "converge.json")) as f:
            rows = json.load(f)["rows"]
        return {(row["step"], int(row["variant"][2:])): row for row in rows}

    def picture(self, figure, name):
        path = os.path.join(self.out, name + ".png")
        figure.savefig(path, dpi=150)
        plt.close(figure)
        print(path, flush=True)


def last_file(folder):
    return sorted(glob.glob(os.path.join(folder, "fields-*.h5")))[-1]


def fields(path):
    with h5py.File(path) as f:
        return {s: f[s][...] for s in f if s not in ("x", "y")}, f["x"][...], float(np.ravel(f.attrs["time"])[0])


def history(folder):
    with open(os.path.join(folder, "history.csv")) as f:
        return [{k: float(v) for k, v in row.items()} for row in csv.DictReader(f)]


def number(x):
    return float(x) if isinstance(x, (int, float)) else math.nan


def by_max_of_a(u, reference):
    """Root of the mean over the grid of the squares of all species, over the largest a: the paper's norm."""
    return math.sqrt(sum(np.mean((u[s] - reference[s]) ** 2) for s in reference)) / np.abs(reference["a"]).max()


def rms_over_max(u, reference):
    return max(math.sqrt(np.mean((u[s] - reference[s]) ** 2)) / np.abs(reference[s]).max() for s in reference)


def table(title, rows, steps, iterations, key="error"):
    print(title)
    print("      step" + "".join(f"        k={k}" for k in iterations))
    for step in steps:
        values = [number(rows[step, k].get(key)) for k in iterations]
        print(f"  {step:8.2e}" + "".join("          -" if math.isnan(v) else f" {v:10.3e}" for v in values), flush=True)


def orders(rows, steps, iterations, floor):
    """Between the two smallest steps whose errors are above those of the reference."""
    seen = []
    for k in iterations:
        pair = sorted(step for step in steps if number(rows[step, k]["error"]) > floor)[:2]
        seen.append(math.log(rows[pair[1], k]["error"] / rows[pair[0], k]["error"]) / math.log(pair[1] / pair[0]) if len(pair) == 2 else math.nan)
    print("     order" + "".join("          -" if math.isnan(o) else f" {o:10.2f}" for o in seen), flush=True)


def draw_errors(axes, rows, steps, iterations, key="error", **style):
    for k in iterations:
        values = [number(rows[step, k].get(key)) for step in steps]
        style = {"marker": MARKERS[k], "markersize": 4, "linewidth": 1.1, **style}
        axes.plot(steps, values, color=COLORS[k], label=f"k = {k}" if key == "error" else None, **style)


def logarithmic(axes, x, y, title):
    axes.set(xscale="log", yscale="log", xlabel=x, ylabel=y)
    axes.set_title(title, fontsize="small")
    axes.grid(True, color="#DDDDDD", linewidth=0.6)


def slopes(axes, rows, at, claimed):
    """Dotted lines of the claimed slopes through the errors of the step `at`."""
    low, high = axes.get_xlim()
    for k, order in enumerate(claimed):
        value = number(rows[at, k]["error"])
        axes.plot([low, high], [value * (low / at) ** order, value * (high / at) ** order], color=COLORS[k], linestyle=":", linewidth=0.8, zorder=0)
    axes.set_xlim(low, high)


def fig1(program):
    folder = os.path.join(program.out, "fig1")
    for old in glob.glob(os.path.join(folder, "fields-*.h5")):
        os.remove(old)
    subprocess.run([program.path, "run", "bz-1d", "-o", folder, "--quiet", "--force", CVODE, "time.end=1.0", "output.every=0.1",
                    "output.checkpoint.every_seconds=0"], check=True)
    figure, panels = plt.subplots(3, 1, figsize=(7, 7), sharex=True, layout="constrained")
    before = None
    for path in sorted(glob.glob(os.path.join(folder, "fields-*.h5"))):
        u, x, t = fields(path)
        for axes, s in zip(panels, "abc"):
            axes.plot(x, u[s], color=plt.get_cmap("viridis")(0.85 * t), linewidth=1.0)
            axes.set_ylabel(s)
        front = x[np.nonzero(u["b"] > 0.5)[0][-1]] if (u["b"] > 0.5).any() else math.nan
        speed = "" if before is None else f", speed since {(front - before[1]) / (t - before[0]):.3f}"
        print(f"t = {t:.1f}: front at {front:.3f}{speed}, largest a {u['a'].max():.5g}, b {u['b'].max():.5g}, c {u['c'].max():.5g}")
        before = (t, front)
    panels[-1].set_xlabel("x")
    panels[0].set_title("t = 0, 0.1, ..., 1 from dark to light", fontsize="small")
    program.picture(figure, "fig1")


def errors_of(program, name, splitting, iterations, power):
    local_steps, global_steps = [1e-6, 1e-5, 2e-5, 5e-5, 1e-4, 2e-4, 5e-4, 1e-3], [2e-5, 5e-5, 1e-4, 2e-4, 5e-4, 1e-3]
    local = program.study(name + "-local", "local", local_steps, iterations, splitting)
    table(f"{splitting}: local errors", local, local_steps, iterations)
    whole = program.study(name + "-global", "global", global_steps, iterations, splitting)
    table(f"{splitting}: global errors; -: refused, beyond the limit of stability", whole, global_steps, iterations)
    orders(whole, global_steps, iterations, 1e-12)
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4.5), layout="constrained")
    draw_errors(left, local, local_steps, iterations)
    logarithmic(left, "Δt", "relative error", f"{splitting}: one step from t = 0.5")
    slopes(left, local, 1e-5, [min(6, power + 1 + k) for k in iterations])
    draw_errors(right, whole, global_steps, iterations)
    logarithmic(right, "Δt", "relative error", f"{splitting}: from t = 0.5 to 0.6")
    slopes(right, whole, 2e-5, [min(5, power + k) for k in iterations])
    left.set_ylim(1e-17, 1e-1)
    right.set_ylim(1e-12, 1e-1)
    left.legend(fontsize="small")
    program.picture(figure, name)


def fig2(program):
    errors_of(program, "fig2", "lie", [0, 1, 2, 3, 4, 5], 1)


def fig3(program):
    errors_of(program, "fig3", "strang", [0, 1, 2, 3, 4], 2)


def fig4(program):
    steps = [1e-5, 2e-5, 5e-5, 1e-4, 2e-4, 5e-4, 1e-3]
    figure, panels = plt.subplots(1, 2, figsize=(10, 4.5), layout="constrained")
    for axes, splitting, iterations in zip(panels, ("lie", "strang"), ([0, 1, 2, 3, 4, 5], [0, 1, 2, 3, 4])):
        rows = program.study("fig4-" + splitting, "local", steps, iterations, splitting)
        table(f"{splitting}: errors", rows, steps, iterations)
        table(f"{splitting}: estimates (43); -: the corrections diverge", rows, steps, iterations, "estimate")
        table(f"{splitting}: dt_max,k", rows, steps, iterations, "step_limit")
        draw_errors(axes, rows, steps, iterations, linestyle="--")
        draw_errors(axes, rows, steps, iterations, "estimate", markerfacecolor="none")
        for k in iterations[1:]:
            axes.axvline(number(rows[1e-5, k]["step_limit"]), color=COLORS[k], linewidth=0.8)
        logarithmic(axes, "Δt", "relative error", f"{splitting}: estimates (open), errors (filled), Δt_max,k (vertical)")
        axes.set_ylim(1e-14, 1e-1)
        axes.legend(fontsize="small")
    program.picture(figure, "fig4")


RULE_COLORS = ["#0072B2", "#D55E00", "#56B4E9", "#E69F00", "#000000"]
RULES = {
    "(44)": "",
    "(46)": ', step_rule="kmax"',
    "(44) published": ', exponent="published"',
    "(46) published": ', step_rule="kmax", exponent="published"',
    "Lie alone (47)": ", max_iterations=0",
}


def fig5(program):
    tolerances = [1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-10, 1e-12]
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4.5), layout="constrained")
    for color, (rule, keys) in zip(RULE_COLORS, RULES.items()):
        chosen = []
        for tolerance in tolerances:
            if "alone" in rule and tolerance < 1e-7:
                continue
            folder = program.run("bz-1d", "fig5", *program.start(), f"time.end={0.502 if 'alone' in rule else 0.51}",
                                 f'method={{name="dcs", tolerance={tolerance}, initial_step=1e-7{keys}}}')
            rows = [r for r in history(folder) if r["time"] > (0.5005 if "alone" in rule else 0.503)]
            taken = [r for r in rows if r["accepted"] == 1][:-1]
            chosen.append((tolerance, statistics.median(r["dt"] for r in taken)))
            rejected = sum(r["accepted"] == 0 for r in rows)
            print(f"{rule}, tolerance {tolerance:.0e}: step {chosen[-1][1]:.4g}, k = {statistics.median(r['iterations'] for r in taken):.0f}, "
                  f"{100 * rejected / len(rows):.0f} % rejected", flush=True)
        left.plot(*zip(*chosen), color=color, marker="o", markersize=4, linewidth=1.1, label=rule)
    logarithmic(left, "tolerance η", "Δt at t = 0.5", "steps")
    left.legend(fontsize="small")
    for color, (rule, keys) in zip(RULE_COLORS, RULES.items()):
        if "alone" in rule:
            continue
        rows = [r for r in history(program.run("bz-1d", "fig5", f'method={{name="dcs", tolerance=1e-7, initial_step=1e-7{keys}}}', "time.end=0.6"))
                if r["accepted"] == 1][:-1]
        right.plot([r["time"] for r in rows], [r["dt"] for r in rows], color=color, linewidth=0.8, label=rule)
    right.axvline(0.5, color="#999999", linewidth=0.8)
    right.set(xlabel="t", ylabel="Δt", yscale="log")
    right.set_title("steps for η = 1e-7", fontsize="small")
    right.legend(fontsize="small")
    program.picture(figure, "fig5")


def injected(path, points):
    """The fields on every so many-th point."""
    u, x, _ = fields(path)
    stride = (len(x) - 1) // (points - 1)
    return {s: v[::stride] for s, v in u.items()}


def fig6(program):
    finest = 16001
    start = os.path.join(program.out, f"start-{finest}.h5")
    on_finest = [f"grid.points=[{finest}]", "space.order=4"]
    if not os.path.exists(start):
        tight = 'method={name="sbdf", relative_tolerance=1e-8, absolute_tolerance=1e-12}'
        os.replace(last_file(program.run("bz-1d", "fig6", *on_finest, tight, "time.end=0.5")), start)
    begin = [f'initial={{file="{start}"}}', "time.start=0.5"]
    inner = ["reaction_solver.tolerance=1e-12", "diffusion_solver.tolerance=1e-12"]

    def step(points, order, k, dt):
        folder = program.run("bz-1d", "fig6", *begin, *inner, f"grid.points=[{points}]", f"space.order={order}", f"time.end={0.5 + dt!r}",
                             f'method={{name="dcs", step={dt!r}, iterations={k}}}')
        return last_file(folder)

    reference = fields(step(finest, 4, 4, 1e-6))[0]
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4.5), layout="constrained")
    counts = [501, 1001, 2001, 4001, 8001, 16001]
    for order, color in ((2, COLORS[0]), (4, COLORS[4])):
        errors = []
        for points in counts if order == 2 else counts[:-1]:
            at = {s: v[:: (finest - 1) // (points - 1)] for s, v in reference.items()}
            errors.append(by_max_of_a(fields(step(points, order, 4, 1e-6))[0], at))
        print(f"order {order} in space, one step of 1e-6 on {counts[:len(errors)]} points:", " ".join(f"{e:.3e}" for e in errors), flush=True)
        left.plot([1.0 / (n - 1) for n in counts[: len(errors)]], errors, color=color, marker="o", markersize=4, label=f"order {order}")
    logarithmic(left, "Δx", "relative error", "one step of 1e-6: error in space")
    left.legend(fontsize="small")
    steps = [1e-6, 1e-5, 1e-4, 1e-3]
    curves = {}
    for dt in steps:
        tight = 'method={name="dcs", tolerance=1e-11}'
        exact = injected(last_file(program.run("bz-1d", "fig6", *begin, *on_finest, tight, f"time.end={0.5 + dt!r}")), 1001)
        for order in (2, 4):
            folder = program.call("converge", "bz-1d", "fig6-steps", *begin, *inner, f"space.order={order}", "time.end=0.6", 'method={name="dcs"}',
                                  f'converge={{kind="local", steps=[{dt!r}], iterations=[0, 1, 2, 3]}}')
            with open(os.path.join(folder, "converge.json")) as f:
                in_time = [number(row["error"]) for row in json.load(f)["rows"]]
            # Beyond the limit of stability a single step is no run: the errors in time are those of an order study.
            for k in range(4):
                try:
                    curves.setdefault((k, order), []).append(by_max_of_a(fields(step(1001, order, k, dt))[0], exact))
                except subprocess.CalledProcessError:
                    curves[k, order].append(math.nan)
            print(f"order {order}, dt {dt:.0e}: in time " + " ".join(f"{e:.3e}" for e in in_time) + "; in space and time "
                  + " ".join(f"{curves[k, order][-1]:.3e}" for k in range(4)), flush=True)
    for (k, order), errors in curves.items():
        right.plot(steps, errors, color=COLORS[k], marker="o" if order == 2 else "x", linestyle="-" if order == 2 else "--", linewidth=1.0, markersize=5,
                   label=f"k = {k}, order {order}")
    logarithmic(right, "Δt", "relative error", "1001 points: errors in space and time of one step")
    right.legend(fontsize="x-small")
    program.picture(figure, "fig6")


def fig7(program):
    steps, iterations = [1e-6, 1e-5, 2e-5, 5e-5, 1e-4, 2e-4, 5e-4], [0, 1, 2, 3, 4, 5]
    figure, panels = plt.subplots(1, 2, figsize=(10, 4.5), layout="constrained")
    # With differences of order two in the splitting, the error in space of the prediction is one power of the step, and each correction adds one.
    for axes, name, order, order_of_prediction in zip(panels, ("fourth order", "second/fourth order"), ("4", "2"), (2, 1)):
        rows = program.study("fig7", "local", steps, iterations, "lie", f"space={{order={order}, quadrature_order=4}}")
        table(f"{name}: local errors", rows, steps, iterations)
        draw_errors(axes, rows, steps, iterations)
        logarithmic(axes, "Δt", "relative error", name)
        axes.set_ylim(1e-17, 1e-1)
        slopes(axes, rows, 1e-5, [min(6, order_of_prediction + k) for k in iterations])
    panels[0].legend(fontsize="small")
    program.picture(figure, "fig7")


def window(program):
    reference = fields(last_file(program.run("bz-1d", "window-reference", CVODE, "time.end=1.0")))[0]
    for splitting in ("lie", "strang"):
        for tolerance in (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-10, 1e-12):
            folder = program.run("bz-1d", "window", f'method={{name="dcs", tolerance={tolerance}, splitting="{splitting}"}}', "time.end=1.0")
            rows = history(folder)
            accepted = sum(r["accepted"] == 1 for r in rows)
            steady = [r for r in rows if 0.1 < r["time"] < 0.9]
            rejected = sum(r["accepted"] == 0 for r in steady) / len(steady)
            e = rms_over_max(fields(last_file(folder))[0], reference)
            print(f"{splitting}, tolerance {tolerance:.0e}: {accepted} steps, {100 * rejected:.1f} % rejected in the steady wave, error at t = 1 {e:.2e}, "
                  f"bound {10 * tolerance * math.sqrt(accepted):.2e}", flush=True)


LINES = {"brusselator-1d": 1.0, "kpp-1d": 1.0, "lambda-omega-1d": 0.4, "fhn-1d": 0.5, "bz2-1d": 0.1, "gray-scott-1d": 50.0, "flame-1d": 0.8,
         "angiogenesis-1d": 0.002, "bz-1d": 0.35}


def rules(program):
    totals = {}
    for case, end in LINES.items():
        for splitting in ("lie", "strang"):
            for tolerance in (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8):
                text = f"{case}, {splitting}, tolerance {tolerance:.0e}:"
                works = []
                for name, keys in (("observed", ""), ("published", ', exponent="published"')):
                    rows = history(program.run(case, "rules", f'method={{name="dcs", tolerance={tolerance}, splitting="{splitting}"{keys}}}', f"time.end={end}"))
                    accepted = sum(r["accepted"] == 1 for r in rows)
                    works.append(sum(3 + 2 * r["iterations"] for r in rows))
                    text += f" {name} {accepted} steps, {len(rows) - accepted} rejected, {works[-1]:.0f} splitting steps;"
                    total = totals.setdefault((splitting, name), [0, 0, 0.0])
                    for i, x in enumerate((accepted, len(rows) - accepted, works[-1])):
                        total[i] += x
                print(text, f"work {works[0] / works[1]:.2f} of the published", flush=True)
    for (splitting, name), (accepted, rejected, work) in totals.items():
        print(f"{splitting}, {name}, all of them: {accepted} steps, {rejected} rejected, {work:.0f} splitting steps")


OREGONATOR = os.path.join(os.path.dirname(os.path.abspath(__file__)), "oregonator.toml")
BZ_STEPS = [1e-4, 5e-5, 2.5e-5, 1.25e-5]
VARIATIONS = {
    "Brusselator": ("brusselator-1d", ["time.end=1.0"], [0.1, 0.05, 0.025, 0.0125, 0.00625]),
    "Oregonator in two variables, custom model": (OREGONATOR, ["time.end=0.1"], [2e-3, 1e-3, 5e-4, 2.5e-4, 1.25e-4]),
    "BZ, f = 3, q = 2e-4": ("bz-1d", ["time.end=0.02", "model.parameters={epsilon=1e-2, mu=1e-5, f=3.0, q=2e-4}"], BZ_STEPS),
    "BZ, f = 1.2, q = 8e-3": ("bz-1d", ["time.end=0.02", "model.parameters={epsilon=1e-2, mu=1e-5, f=1.2, q=8e-3}"], BZ_STEPS),
    "BZ in two dimensions": ("bz-2d-spiral", ["grid.points=[64, 64]", "time.end=0.01"], BZ_STEPS),
}


def variations(program):
    for name, (case, overrides, steps) in VARIATIONS.items():
        for splitting, iterations in (("lie", [0, 1, 2, 3]), ("strang", [0, 1, 2])):
            by_reference = []
            for reference in ('{method="cvode", tolerance=1e-13}', f'{{method="sdc", step={steps[-1] / 4!r}}}'):
                folder = program.call("converge", case, "variations", *overrides, f'method={{name="dcs", splitting="{splitting}"}}',
                                      f"converge={{steps={steps}, iterations={iterations}, reference={reference}}}",
                                      "reaction_solver.tolerance=1e-11", "diffusion_solver.tolerance=1e-11")
                with open(os.path.join(folder, "converge.json")) as f:
                    by_reference.append({(row["step"], int(row["variant"][2:])): row for row in json.load(f)["rows"]})
            rows, others = by_reference
            table(f"{name}, {splitting}: global errors", rows, steps, iterations)
            orders(rows, steps, iterations, 3e-11)
            apart = max(abs(number(rows[key]["error"]) - number(others[key]["error"])) for key in rows if not math.isnan(number(rows[key]["error"])))
            print(f"  by the other reference (sdc) the errors differ by at most {apart:.1e}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("items", nargs="*", metavar="ITEM", help="fig1 ... fig7, window, rules, variations; none: all")
    parser.add_argument("--program", default="build/release/stiffront")
    parser.add_argument("--out", default="out/dcs")
    options = parser.parse_args()
    program = Program(options.program, options.out)
    items = {"fig1": fig1, "fig2": fig2, "fig3": fig3, "fig4": fig4, "fig5": fig5, "fig6": fig6, "fig7": fig7,
             "window": window, "rules": rules, "variations": variations}
    for item in options.items or items:
        if item not in items:
            parser.error(f"unknown item {item}")
        items[item](program)


if __name__ == "__main__":
    main()
