#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Method auto on problems nobody tuned it for, against an optimised CVODE with GMRES and block Jacobi (in one dimension banded, too).

    drivers/bench/kept_aside.py [--stress] [--problems excitable-1d,...] [--repeats 3] [--least] [--out out/kept-aside]

At every tolerance from 1e-3 to 1e-8, two claims: the error of auto (root mean square over the largest modulus, worst species, against
CVODE at a tight tolerance) is at most ten times the tolerance, and auto needs no more time than the best CVODE for the error it
reached. Exit status 1 if a claim fails. --stress: the models of stress_table instead. Custom models are read from kept_aside/*.toml by the program, and compiled into the peers.
"""
import argparse
import os
import statistics
import sys

import comparison
from comparison import Bench, Problem, seconds_at


def case(name):
    return os.path.join(comparison.ROOT, "drivers", "bench", "kept_aside", name + ".toml")


def line(points, upper):
    return f"grid={{points=[{points}],lower=[0.0],upper=[{upper}]}}"


PROBLEMS = [
    Problem("excitable-1d", case("excitable"), [line(1001, "100.0"), 'initial={u="if(x < 4, 1.5, -1.03)", v="-0.67"}'], model="excitable"),
    Problem("excitable-2d", case("excitable"), ["time.end=1"], model="excitable", reference_tolerance=1e-10),
    Problem("forced-1d", case("forced-excitable"), [line(801, "40.0")], model="forced-excitable"),
    Problem("forced-2d", case("forced-excitable"), ["time.end=2"], model="forced-excitable", reference_tolerance=1e-10),
    Problem("activator-inhibitor-1d", case("gierer-meinhardt"), [line(501, "1.0")], model="gierer-meinhardt"),
    Problem("activator-inhibitor-2d", case("gierer-meinhardt"), ["time.end=5"], model="gierer-meinhardt", reference_tolerance=1e-10),
    Problem("brusselator-2e7-1d", "brusselator-stiff-1d", ["model.parameters.B=2e7"]),
    Problem("brusselator-2e7-2d", "brusselator-stiff-1d",
            ["model.parameters.B=2e7", "grid={points=[101,101],lower=[0.0,0.0],upper=[1.0,1.0]}",
             'initial={u="1+0.5*cos(pi*x)*cos(2*pi*y)",v="3+0.5*cos(2*pi*x)*cos(pi*y)"}'], reference_tolerance=1e-12),
    Problem("flame-1d", "flame-1d", ["model.parameters.Ze=20", "grid.points=[1001]", "time.end=4"]),
    Problem("flame-2d", "flame-1d", ["model.parameters.Ze=15", "grid={points=[201,101],lower=[0.0,0.0],upper=[20.0,10.0]}", "time.end=2",
                                     'initial={fuel="max(0,1-exp(5+cos(0.6*y)-x))",theta="min(1,exp(5+cos(0.6*y)-x))"}'],
            reference_tolerance=1e-10),
    Problem("chain-flame-1d", case("chain-flame"), [line(801, "20.0")], model="chain-flame"),
    Problem("chain-flame-2d", case("chain-flame"), ["time.end=1.5"], model="chain-flame", reference_tolerance=1e-10),
    Problem("eight-species-1d", case("eight-species"), [line(501, "1.0")], model="eight-species"),
    Problem("eight-species-2d", case("eight-species"), ["time.end=2"], model="eight-species", reference_tolerance=1e-10),
    Problem("diurnal-1d", case("diurnal"), [line(401, "20.0")], model="diurnal"),
    Problem("diurnal-2d", case("diurnal"), [], model="diurnal", reference_tolerance=1e-10),
]
STRESS = [
    Problem("bruss1e4", "brusselator-stiff-1d", []),
    Problem("bruss1e6", "brusselator-stiff-1d", ["model.parameters.B=1e6"]),
    Problem("grayscott", "gray-scott-1d", []),
    Problem("fhn", "fhn-1d", []),
    Problem("flame10", "flame-1d", []),
    Problem("flame40", "flame-1d", ["model.parameters.Ze=40", "model.parameters.Le=0.8", "model.diffusion.fuel=1.25", "grid.upper=[10.0]",
                                    "grid.points=[1001]", "time.end=0.5"]),
    Problem("angio", "angiogenesis-1d", []),
    Problem("ignite", "ignition-1d", []),
    Problem("lamom20", "lambda-omega-1d", []),
    Problem("lamom200", "lambda-omega-1d", ["model.parameters.omega=200"]),
    Problem("slave100", "slaved-oscillator-1d", ["model.parameters.damping=100"]),
    Problem("slave20", "slaved-oscillator-1d", []),
    Problem("slave5", "slaved-oscillator-1d", ["model.parameters.damping=5", "model.parameters.omega=500"]),
    Problem("pulse", "pulse-1d", []),
]
TOLERANCES = [1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8]


def measure(bench, problem, repeats, least):
    auto = {t: [] for t in TOLERANCES}
    solvers = ["gmres", "band"] if problem.dimension == 1 else ["gmres"]
    peers = {s: {t: [] for t in [1e-2, *TOLERANCES, 1e-9]} for s in solvers}
    for _ in range(repeats):
        for t, runs in auto.items():
            runs.append(bench.ours(problem, [f'method={{name="auto", tolerance={t!r}}}'], 120))
        for solver, settings in peers.items():
            for t, runs in settings.items():
                runs.append(bench.peer("optimised", "cvode_peer", problem, t, [f"linear_solver={solver}"], 60))

    def digest(runs):
        if any(r is None for r in runs):
            return None
        seconds = [r["seconds"] for r in runs]
        return {**runs[0], "seconds": min(seconds) if least else statistics.median(seconds)}

    return ({t: digest(r) for t, r in auto.items()},
            {s: {t: digest(r) for t, r in settings.items()} for s, settings in peers.items()})


def report(problem, auto, peers):
    """A Markdown row; what failed."""
    cells, failures = [], []
    curves = {s: [(r["error"], r["seconds"]) for r in settings.values() if r] for s, settings in peers.items()}
    for t, r in auto.items():
        if r is None:
            cells.append("failed")
            failures.append(f"{problem.name} at {t:g}: the run failed")
            continue
        times = {s: seconds_at(curve, r["error"]) for s, curve in curves.items()}
        times = {s: x for s, x in times.items() if x is not None}
        ratios = {s: x / r["seconds"] for s, x in times.items()}
        cells.append(f"{r['error'] / t:.2g} " + ("/".join(f"{x:.3g}" for x in ratios.values()) or "-"))
        if r["error"] > 10 * t:
            failures.append(f"{problem.name} at {t:g}: error {r['error']:.2g}")
        for s, x in ratios.items():
            if x < 1:
                failures.append(f"{problem.name} at {t:g}: {s} needs {x:.2g} times the time of auto ({r['seconds']:.4g} s)")
    return f"| {problem.name} | " + " | ".join(cells) + " |", failures


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--problems", help="names, comma-separated: " + ", ".join(p.name for p in PROBLEMS))
    parser.add_argument("--stress", action="store_true", help="the models of stress_table")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--least", action="store_true", help="the least instead of the median of the repetitions")
    parser.add_argument("--program", default=os.path.join(comparison.ROOT, "build", "release", "stiffront"))
    parser.add_argument("--out", default="out/kept-aside")
    options = parser.parse_args()
    bench = Bench(options.program, options.out, comparison.build_peers(os.path.join(comparison.ROOT, "build", "bench-peers")))
    print("error over tolerance, and how many times the time of auto CVODE needs for that error (GMRES, in 1-D /band)\n")
    print("| problem | " + " | ".join(f"{t:g}" for t in TOLERANCES) + " |\n|" + " --- |" * (len(TOLERANCES) + 1))
    failures = []
    for problem in STRESS if options.stress else PROBLEMS:
        if options.problems and problem.name not in options.problems.split(","):
            continue
        problem.prepare(bench)
        auto, peers = measure(bench, problem, options.repeats, options.least)
        row, failed = report(problem, auto, peers)
        print(row, flush=True)
        failures += failed
    print("\n" + ("\n".join(failures) or "both claims hold everywhere"))
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
