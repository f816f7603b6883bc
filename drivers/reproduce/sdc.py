#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The numbers and pictures of Hagstrom & Zhou, Commun. Appl. Math. Comput. Sci. 1(1), 2006, made with this program.

    drivers/reproduce/sdc.py [ITEM ...] [--program build/release/stiffront] [--out out/sdc]

accuracy      Figs 1, 2: Dahlquist's equation, order by nodes, starting order, consistent and inconsistent corrections (1 minute)
efficiency    Figs 3, 4, 5: van der Pol, errors against evaluations of the right-hand side (1 minute)
brusselator   Table 1, Fig. 14, the limits of the step, Strang splitting, the order in time on a fixed grid (5 minutes)
angiogenesis  Table 2, Fig. 15, Strang splitting (2 minutes)
flame         Table 3, Fig. 16, Strang splitting, from the reduced model's pulsating solution (an hour; --quick: all on the coarser grid)
work          time to an accuracy on the Brusselator with smooth data: sdc, adaptive-strang, cvode (5 minutes)

Each prints its numbers and leaves them, with a picture, in the output folder. What they should be is in docs/sdc.md. Figs 6 to 13 are
stability domains: drivers/reproduce/sdc_stability.py. Needs numpy and h5py; matplotlib for the pictures.
"""
import argparse
import glob
import json
import math
import os
import subprocess

import h5py
import numpy as np

QUIET = ["output.checkpoint.every_seconds=0", "limits.stall_limit_s=0"]
TEXTBOOK = ["diffusion_solver.name=crank-nicolson", "diffusion_solver.tolerance=1e-10", "reaction_solver.name=trapezoidal",
            "reaction_solver.tolerance=1e-10"]
VAN_DER_POL = (-1.91423981220481877556, 0.448031279557519709566)


class Program:
    def __init__(self, path, out):
        self.path, self.out = path, out
        os.makedirs(out, exist_ok=True)

    def run(self, case, name, *overrides):
        """The folder of a run, or None if it failed."""
        folder = os.path.join(self.out, name)
        done = subprocess.run([self.path, "run", case, "-o", folder, "--quiet", "--force", *QUIET, *overrides],
                              stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        if done.returncode == 4:
            return None
        if done.returncode != 0:
            raise SystemExit(done.stderr)
        return folder

    def save(self, name, numbers):
        with open(os.path.join(self.out, name + ".json"), "w") as f:
            json.dump(numbers, f, indent=1)

    def picture(self, name, draw):
        try:
            import matplotlib
            matplotlib.use("Agg")
            import matplotlib.pyplot as plt
        except ImportError:
            print("  (no matplotlib: no picture)")
            return
        figure = plt.figure(figsize=(8, 5.5))
        draw(figure, plt)
        path = os.path.join(self.out, name + ".png")
        figure.tight_layout()
        figure.savefig(path, dpi=120)
        plt.close(figure)
        print(f"  picture: {path}")


def states(folder):
    """Time, values by species and x of every state of a run, in order of time."""
    result = []
    for path in sorted(glob.glob(os.path.join(folder, "fields-*.h5"))):
        with h5py.File(path, "r") as f:
            result.append((float(f.attrs["time"]), {s: f[s][...] for s in f if s not in ("x", "y")}, f["x"][...]))
    return sorted(result, key=lambda state: state[0])


def summary(folder):
    with open(os.path.join(folder, "summary.json")) as f:
        return json.load(f)


def sdc(nodes="gauss-radau", **keys):
    rest = ", ".join(f"{k}={json.dumps(v)}" for k, v in keys.items())
    return f'method={{name="sdc", nodes="{nodes}", {rest}}}'


def largest_errors(folder, reference):
    """The largest of |error| / max |solution| over points and common output times but the first, and the time it is met, by species."""
    return largest_errors_of(states(folder)[1:], reference)


def largest_errors_of(solution, reference):
    worst = {}
    known = {round(t, 7): (u, x) for t, u, x in reference}
    for t, u, x in solution:
        if round(t, 7) not in known:
            continue
        v, x_v = known[round(t, 7)]
        step = (len(x_v) - 1) // (len(x) - 1)
        for s in u:
            e = float(np.abs(u[s] - v[s][::step]).max() / np.abs(v[s]).max())
            if e > worst.get(s, (0.0, 0.0))[0]:
                worst[s] = (e, t)
    return worst


def text(errors):
    return ", ".join(f"{s} {e:.3g} (t = {t:g})" for s, (e, t) in errors.items())


def curves(program, name, title, lines, x_label, slope=None):
    def draw(figure, plt):
        axes = figure.add_subplot()
        for label, points in lines.items():
            if points:
                axes.loglog(*zip(*points), "o-", markersize=3, label=label)
        if slope:
            first = [p for p in next(iter(lines.values())) if p[1] > 1e-11]
            x = np.array([first[0][0], first[-1][0]])
            axes.loglog(x, first[0][1] * (x / x[0]) ** -slope, "k:", label=f"order {slope}")
        axes.set(title=title, xlabel=x_label, ylabel="error")
        axes.legend(fontsize=8)
        axes.grid(True, alpha=0.3)

    program.picture(name, draw)


# Figs 1 and 2

def dahlquist_error(program, steps, **keys):
    folder = program.run("dahlquist", "dahlquist", sdc(splitting="imex", implicit="reaction", step=20.0 / steps, **keys), "output.every=0")
    if folder is None:
        return math.inf
    u = states(folder)[-1][1]
    return abs(complex(u["re"][0], u["im"][0]) - np.exp(-1.0))


def accuracy(program):
    numbers = {}
    for figure, nodes, order, ending in ((1, "gauss-legendre", lambda m: 2 * m, "extrapolation"), (2, "gauss-radau", lambda m: 2 * m - 1, "last-node")):
        counts = (40, 60, 80, 120, 160)
        by_nodes, by_start = {}, {}
        for m in (4, 5, 6, 7, 8):
            by_nodes[f"m = {m}"] = [(n, dahlquist_error(program, n, nodes=nodes, node_count=m, starting_order=3, corrections=order(m) - 3,
                                                        final_update=ending)) for n in counts]
        for k in (1, 2, 3, 4, 5):
            for consistent in (True, False):
                by_start[f"k = {k}, {'c' if consistent else 'i'}"] = [
                    (n, dahlquist_error(program, n, nodes=nodes, node_count=6, starting_order=k, corrections=order(6) - k, consistent=consistent,
                                        final_update=ending)) for n in counts]
        for lines in (by_nodes, by_start):
            for label, points in lines.items():
                (n0, e0), (n1, e1) = points[-2:]
                slope = math.log(e0 / e1) / math.log(n1 / n0)
                print(f"Fig. {figure} {nodes} {label}: " + ", ".join(f"{n}: {e:.2e}" for n, e in points) + f"; slope {slope:.2f}", flush=True)
        curves(program, f"fig{figure}-nodes", f"{nodes}, third-order start", by_nodes, "steps")
        curves(program, f"fig{figure}-starts", f"6 nodes, {nodes}", by_start, "steps", order(6))
        numbers[f"fig{figure}"] = {"nodes": by_nodes, "starts": by_start}
    program.save("accuracy", numbers)


# Figs 3 to 5

def van_der_pol(program, steps, **keys):
    folder = program.run("van-der-pol", "van-der-pol", sdc(splitting="imex", implicit="reaction", step=4.0 / steps, **keys), "output.every=0")
    u = states(folder)[-1][1]
    error = max(abs(u["u1"][0] - VAN_DER_POL[0]), abs(u["u2"][0] - VAN_DER_POL[1]))
    return summary(folder)["work"]["rhs_evaluations"], float(error)


def efficiency(program):
    def lines(rows):
        result = {}
        for label, counts, keys in rows:
            result[label] = [van_der_pol(program, n, **keys) for n in counts]
            print(f"  {label}: " + ", ".join(f"{f}: {e:.2e}" for f, e in result[label]), flush=True)
        return result

    legendre, radau = "gauss-legendre", "gauss-radau"
    print("Fig. 3, evaluations: error")
    fig3 = lines([(f"Radau, m = {m}", (8, 16, 32, 64), dict(nodes=radau, node_count=m, starting_order=1, corrections=4)) for m in (3, 4, 5, 6)] +
                 [(f"Legendre, m = {m}", (8, 16, 32, 64), dict(nodes=legendre, node_count=m, starting_order=1, corrections=5,
                                                               final_update="extrapolation")) for m in (3, 4, 5, 6)])
    print("Fig. 4, evaluations: error")
    fig4 = lines([(f"Legendre, order {2 * m}", (4, 8, 16, 32), dict(nodes=legendre, node_count=m, starting_order=1, corrections=2 * m - 1))
                  for m in (2, 3, 4, 6)] +
                 [(f"Radau, order {2 * m - 1}", (4, 8, 16, 32), dict(nodes=radau, node_count=m, starting_order=1, corrections=2 * m - 2))
                  for m in (3, 4, 6)])
    print("Fig. 5, evaluations: error")
    fig5 = lines([(f"Radau, order 11, k = {k}", (4, 8, 16), dict(nodes=radau, node_count=6, starting_order=k, corrections=11 - k))
                  for k in (1, 2, 3, 4, 5)] +
                 [(f"Legendre, order 12, k = {k}", (4, 8, 16), dict(nodes=legendre, node_count=6, starting_order=k, corrections=12 - k))
                  for k in (1, 2, 3, 4, 5)])
    for name, title, result in (("fig3", "order 5 and 6, first-order start", fig3), ("fig4", "full order of the quadrature, first-order start", fig4),
                                ("fig5", "starting orders", fig5)):
        curves(program, name, title, result, "evaluations of the right-hand side")
    program.save("efficiency", {"fig3": fig3, "fig4": fig4, "fig5": fig5})


# Table 1

def seventh(step, gamma=2.0):
    return sdc(node_count=4, starting_order=4, corrections=3, step=step, gamma_diffusion=gamma)


def brusselator_case(intervals):
    return ["brusselator-sdc-1d", f"grid.points=[{intervals + 1}]"]


def brusselator(program):
    def run(intervals, name, *overrides):
        case, points = brusselator_case(intervals)
        return program.run(case, name, points, *overrides)

    numbers = {}
    reference = states(run(500, "brusselator-reference", seventh(1e-3)))
    for n, step in ((50, 0.2), (100, 0.1)):
        errors = largest_errors(run(n, f"brusselator-{n}", seventh(step)), reference)
        print(f"Table 1: dT = {step:g}, dx = 1/{n}: {text(errors)}", flush=True)
        strang = largest_errors(run(n, f"brusselator-strang-{n}", f'method={{name="strang", step={step / 16!r}}}', *TEXTBOOK), reference)
        print(f"  Strang splitting, dt = {step / 16:g}: {text(strang)}", flush=True)
        numbers[f"dx = 1/{n}"] = {"sdc": errors, "strang": strang}
    for n, gamma, candidates in ((50, 2.0, range(1, 6)), (100, 2.0, range(1, 7)), (150, 2.0, range(5, 12)), (150, 1.0, range(96, 106))):
        good = {q: run(n, "brusselator-limit", seventh(1.0 / q, gamma), "output.every=0") is not None for q in candidates}
        limit = min(q for q in candidates if all(good[p] for p in candidates if p >= q))
        print(f"largest stable step, gamma_d = {gamma:g}, dx = 1/{n}: 1/{limit}", flush=True)
        numbers[f"limit gamma_d = {gamma:g}, dx = 1/{n}"] = limit
    for n in (50, 100):
        smooth = ["initial={profile=\"brusselator-sine\"}"]
        fine = states(run(n, f"brusselator-smooth-reference-{n}", sdc(node_count=7, starting_order=4, corrections=9, step=0.0125, gamma_diffusion=2.0),
                          *smooth))
        for corrections, acceleration in ((3, False), (8, False), (6, True)):
            before = None
            for step in (0.2, 0.1, 0.05, 0.025):
                method = sdc(node_count=4, starting_order=4, corrections=corrections, acceleration=acceleration, step=step, gamma_diffusion=2.0)
                solution = states(run(n, "brusselator-smooth", method, *smooth))
                errors = {f"{s}, t = 10": e for s, (e, _) in largest_errors_of(solution[-1:], fine).items()}
                errors |= {f"{s}, all t": e for s, (e, _) in largest_errors_of(solution[1:], fine).items()}
                orders = "" if before is None else "; orders " + ", ".join(f"{math.log2(before[k] / errors[k]):.2f}" for k in errors)
                what = f"sin 2 pi x, dx = 1/{n} fixed, L = {corrections}{', accelerated' if acceleration else ''}, dT = {step:g}"
                print(f"{what}: " + ", ".join(f"{k} {e:.3g}" for k, e in errors.items()) + orders, flush=True)
                numbers[what] = errors
                before = errors
    program.save("brusselator", numbers)
    surface(program, "fig14", "Brusselator, v", states(run(200, "brusselator-figure", seventh(0.05), "output.every=0.1")), "v")


def surface(program, name, title, sequence, species):
    def draw(figure, plt):
        axes = figure.add_subplot()
        x = sequence[0][2]
        t = [state[0] for state in sequence]
        mesh = axes.pcolormesh(x, t, np.array([state[1][species] for state in sequence]), shading="gouraud")
        figure.colorbar(mesh)
        axes.set(title=title, xlabel="x", ylabel="t")

    program.picture(name, draw)


# Table 2

def angiogenesis(program):
    case = "angiogenesis-chemotaxis-1d"
    method = lambda step: sdc(node_count=4, starting_order=2, corrections=5, step=step, gamma_diffusion=2.0, gamma_advection=0.0)
    reference = states(program.run(case, "angiogenesis-reference", "grid.points=[1001]", method(5e-4), "output.every=0"))
    numbers = {}
    for n, steps in ((100, 42), (200, 84)):
        points = [f"grid.points=[{n + 1}]", "output.every=0"]
        errors = largest_errors(program.run(case, f"angiogenesis-{n}", *points, method(0.7 / steps)), reference)
        strang = largest_errors(program.run(case, f"angiogenesis-strang-{n}", *points, f'method={{name="strang", step={0.7 / (24 * steps)!r}}}',
                                            *TEXTBOOK), reference)
        print(f"Table 2: {steps} steps, dx = 1/{n}: {text(errors)}\n  Strang splitting, {24 * steps} steps: {text(strang)}", flush=True)
        numbers[f"dx = 1/{n}"] = {"sdc": errors, "strang": strang}
    program.save("angiogenesis", numbers)
    surface(program, "fig15", "Angiogenesis, rho", states(program.run(case, "angiogenesis-figure", "output.every=0.01")), "rho")


# Table 3

def flame_start(program):
    """The pulsating solution of the reduced model at t = 40, with W in equilibrium, as a file the full model starts from."""
    path = os.path.join(program.out, "flame-start.h5")
    if os.path.exists(path):
        return path
    _, u, x = states(program.run("reduced-pulsating-flame-1d", "flame-reduced", "output.every=0"))[-1]
    z = 0.5 * (u["Theta"] - 1.0) / (0.5 + 0.5 * u["Theta"])
    u["W"] = np.sqrt(np.maximum(0.0, 1e-4 * u["Y"] * np.exp(38.0 * z)))
    with h5py.File(path, "w") as f:
        f.attrs["time"], f.attrs["step"] = 0.0, 0
        f.attrs["species"] = ["Y", "W", "Theta"]
        f.attrs["dimension"] = 1
        f.attrs["points"], f.attrs["periodic"] = np.array([len(x)]), np.array([0])
        f.attrs["lower"], f.attrs["upper"] = np.array([5.0]), np.array([35.0])
        f["x"] = x
        for s in ("Y", "W", "Theta"):
            f[s] = u[s]
    return path


def flame_order(program, method):
    """Errors on one grid over the reference's collapse from t = 18.88 to 19.52, when all is fastest: sweeps, plain and accelerated."""
    start = min(glob.glob(os.path.join(program.out, "flame-reference", "fields-*.h5")), key=lambda path: abs(time_of(path) - 18.88))
    settings = ["grid.points=[2501]", f'initial={{file="{start}"}}', "time.end=0.64", "output.every=0.032"]
    solution = lambda step, **keys: states(program.run("pulsating-flame-1d", "flame-collapse", method(step, **keys), *settings))
    reference = solution(4e-4, node_count=6, corrections=12)
    numbers = {}
    for corrections in (5, 8):
        for acceleration in (False, True):
            before = None
            for step in (3.2e-3, 1.6e-3, 8e-4):
                errors = {s: e for s, (e, _) in largest_errors_of(solution(step, corrections=corrections, acceleration=acceleration)[1:], reference).items()}
                orders = "" if before is None else "; orders " + ", ".join(f"{s} {math.log2(before[s] / errors[s]):.2f}" for s in errors)
                print(f"collapse, L = {corrections}{', accelerated' if acceleration else ''}, dT = {step:g}: " +
                      ", ".join(f"{s} {e:.3g}" for s, e in errors.items()) + orders, flush=True)
                numbers[f"L = {corrections}, accelerated {acceleration}, dT = {step:g}"] = errors
                before = errors
    return numbers


def time_of(path):
    with h5py.File(path, "r") as f:
        return float(f.attrs["time"])


def flame(program, quick):
    start = [f'initial={{file="{flame_start(program)}"}}', "output.every=0.032"]
    numbers = {}

    def run(intervals, name, method, *more):
        return program.run("pulsating-flame-1d", name, f"grid.points=[{intervals + 1}]", method, *start, *more)

    def method(step, **keys):
        return sdc(**({"node_count": 4, "starting_order": 2, "corrections": 5, "step": step, "gamma_diffusion": 2.0, "gamma_advection": 2.0} | keys))

    rows = ((2500, 3.2e-3), (2500, 1.6e-3)) if quick else ((2500, 3.2e-3), (5000, 1.6e-3))
    n, step = (2500, 4e-4) if quick else (10000, 8e-4)
    reference = states(run(n, "flame-reference", method(step)))
    before = None
    for n, step in rows:
        errors = largest_errors(run(n, f"flame-{n}-{step:g}", method(step)), reference)
        orders = "" if before is None else "; orders " + ", ".join(f"{s} {math.log2(before[s][0] / errors[s][0]):.2f}" for s in errors)
        print(f"Table 3: dT = {step:g}, dx = {30.0 / n:g}: {text(errors)}{orders}", flush=True)
        numbers[f"dT = {step:g}, dx = {30.0 / n:g}"] = errors
        before = errors
        strang = largest_errors(run(n, f"flame-strang-{n}", f'method={{name="strang", step={step / 24!r}}}', *TEXTBOOK), reference)
        print(f"  Strang splitting, dt = {step / 24:g}: {text(strang)}", flush=True)
        numbers[f"strang dt = {step / 24:g}"] = strang
    numbers["order"] = flame_order(program, method)
    program.save("flame", numbers)
    surface(program, "fig16", "Pulsating flame, Theta", reference, "Theta")


# Time to an accuracy

def work(program):
    case, points = brusselator_case(100)
    smooth = [points, "initial={profile=\"brusselator-sine\"}", "output.every=0"]
    reference = states(program.run(case, "work-reference", sdc(node_count=7, starting_order=4, corrections=9, step=0.0125, gamma_diffusion=2.0), *smooth))
    exact = reference[-1][1]
    lines = {}

    def measure(label, settings):
        lines[label] = []
        for method in settings:
            seconds = math.inf
            for _ in range(15):  # the fastest is the least disturbed
                folder = program.run(case, "work", method, *smooth)
                if folder is None:
                    break
                seconds = min(seconds, summary(folder)["wall_seconds"]["total"])
            if folder is None:
                continue
            last = states(folder)[-1][1]
            error = max(float(np.abs(last[s] - exact[s]).max() / np.abs(exact[s]).max()) for s in last)
            lines[label].append((seconds, error))
        print(f"{label}: " + ", ".join(f"{e:.1e} in {1e3 * s:.3g} ms" for s, e in lines[label]), flush=True)

    tolerances = ["1e-4", "1e-5", "1e-6", "1e-7", "1e-8", "1e-9", "1e-10"]
    measure("sdc, order 7", [seventh(0.2), seventh(0.1), seventh(0.05), seventh(0.025)])
    measure("adaptive-strang", [f'method={{name="adaptive-strang", tolerance={t}}}' for t in tolerances[:6]])
    for solver in ("band", "gmres"):
        measure(f"cvode, {solver}", [f'method={{name="cvode", relative_tolerance={t}, linear_solver="{solver}"}}' for t in tolerances])
    program.save("work", lines)
    curves(program, "work", "Brusselator, smooth data, dx = 1/100, t = 10", lines, "seconds")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("items", nargs="*", metavar="ITEM", help="accuracy, efficiency, brusselator, angiogenesis, flame, work; none: all")
    parser.add_argument("--program", default="build/release/stiffront")
    parser.add_argument("--out", default="out/sdc")
    parser.add_argument("--quick", action="store_true", help="flame: all runs on the coarser grid")
    options = parser.parse_args()
    program = Program(options.program, options.out)
    items = {"accuracy": lambda: accuracy(program), "efficiency": lambda: efficiency(program), "brusselator": lambda: brusselator(program),
             "angiogenesis": lambda: angiogenesis(program), "flame": lambda: flame(program, options.quick), "work": lambda: work(program)}
    for item in options.items or items:
        if item not in items:
            parser.error(f"unknown item {item}")
        items[item]()


if __name__ == "__main__":
    main()
