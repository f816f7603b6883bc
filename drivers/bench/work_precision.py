#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Work and error of every method of the program, through `stiffront run`, and of the peers Debian has, on the same problems.

    drivers/bench/work_precision.py [--problems A,spiral-256,...] [--codes sbdf,cvode-gmres,...] [--repeats 3] [--out out/work-precision]

Without options: problem A, the spiral on 256^2 and on 1001^2, sbdf and auto against an optimised CVODE with GMRES: some five minutes of an idle
machine. --all: every problem and every code (hours on a slow machine: runs above --longest seconds are given up, and with them the
tighter ones of that code).

Runs alternate: all codes and tolerances once, then again. Seconds are those of the time loop (summary.json, or around the call of the peer's
integrator), medians of the repetitions; --least takes the least instead, for machines with other work. Left behind: work_precision.csv,
a picture of each problem, and work_precision.md with the ratios at errors 1e-4, 1e-6 and 1e-8.

SUNDIALS is built from Debian's source package with -O3 (peers/sundials.sh), since the packages are compiled without optimisation;
cvode-gmres-debian is the package, for the size of that effect alone. Needs Debian's python3-h5py, python3-numpy, python3-matplotlib.
"""
import argparse
import csv
import os
import statistics

import comparison
from comparison import Bench, Problem, seconds_at

def strip(length):
    """A strip near x = 0 ignited in a recovering medium; where it ends is said between points, so that no rounding moves it."""
    x = f"(x/{length})"
    rest = "q*(f+1)/(f-1)"
    b = f"if({x} >= 0.0024 && {x} < 0.0099, 0.8, {rest})"
    c = f"({rest} + if({x} < 0.05, atan(40*{x} - 0.1) + if({x} < 0.0024, 2*pi, 0), atan(1.9))/(8*pi*f))"
    return f'initial={{a="f*{c}/(q + {b})", b="{b}", c="{c}"}}'


PROBLEMS = [
    Problem("A", "bz-1d", ["time.end=1"], develop=[strip(1), "time.end=0.5"], error_species=0, reference_tolerance=1e-12),
    Problem("B", "bz-1d-long", ["time.end=0.2"], develop=[strip(80), "time.end=0.5"], error_species=0, reference_tolerance=1e-12),
    Problem("spiral-256", "bz-2d-spiral", ["time.end=0.5"], develop=["time.end=1"], error_species=0, reference_tolerance=1e-10),
    Problem("spiral-1001", "bz-2d-spiral", ["grid.points=[1001,1001]", "time.end=0.01"], develop=["grid.points=[256,256]", "time.end=1"],
            error_species=0, reference_tolerance=1e-9),
    Problem("spiral-1001-ignition", "bz-2d-spiral", ["grid.points=[1001,1001]", "time.end=0.01"], error_species=0, reference_tolerance=1e-9),
    Problem("brusselator-2d", "brusselator-2d", [], reference_tolerance=1e-11),
    Problem("gray-scott-2d", "gray-scott-2d", ["time.end=200"], reference_tolerance=1e-11),
    Problem("flame-ze40", "flame-1d", ["model.parameters.Ze=40", "model.parameters.Le=0.8", "model.diffusion.fuel=1.25",
                                       "grid.upper=[10.0]", "grid.points=[1001]", "time.end=0.5"]),
]
JUDGED = ["A", "spiral-256", "spiral-1001"]


class Code:
    """A way to solve: settings from the loosest to the tightest, each a name and what runs it."""

    def __init__(self, name, ours, settings, dimension=2, kind="optimised"):
        self.name, self.ours, self.settings, self.dimension, self.kind = name, ours, settings, dimension, kind


def method(text, values):
    return [(f"{v:g}", [text.replace("#", repr(v)).replace("%", repr(v / 100))]) for v in values]


def decades(first, last, per_decade=1):
    return [10.0 ** -(k / per_decade) for k in range(first * per_decade, last * per_decade + 1)]


def peer(program, options, values):
    return [(f"{v:g}", (program, v, options)) for v in values]


CODES = [
    Code("sbdf", True, method('method={name="sbdf", relative_tolerance=#}', decades(1, 7, 2))),
    Code("auto", True, method('method={name="auto", tolerance=#}', decades(2, 7))),
    Code("adaptive-strang", True, method('method={name="adaptive-strang", tolerance=#}', decades(2, 5))),
    Code("strang", True, method('method={name="strang", step=#}', [4e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4])),
    Code("dcs", True, method('method={name="dcs", tolerance=#}', decades(3, 6))),
    Code("sdc", True, method('method={name="sdc", tolerance=#}', decades(3, 8))),
    Code("cvode (method)", True, method('method={name="cvode", relative_tolerance=#, absolute_tolerance=%}', decades(2, 9))),
    Code("cvode-gmres", False, peer("cvode_peer", ["linear_solver=gmres"], decades(2, 8))),
    Code("cvode-band", False, peer("cvode_peer", ["linear_solver=band"], decades(3, 9)), dimension=1),
    Code("arkode-imex", False, peer("arkode_peer", ["order=4"], decades(2, 7))),
    Code("petsc-bdf", False, peer("petsc_peer", [], decades(2, 8))),
    Code("cvode-gmres-debian", False, peer("cvode_peer", ["linear_solver=gmres"], decades(2, 6, 1)[::2]), kind="debian"),
]


def measure(bench, problem, codes, repeats, longest, minimum):
    """{code: {setting: result}}, the seconds over all repetitions."""
    results = {c.name: {} for c in codes}
    for repeat in range(repeats):
        for code in codes:
            if code.dimension < problem.dimension or (code.name == "cvode-band" and "periodic=1" in problem.arguments):
                continue
            for name, setting in code.settings:
                known = results[code.name].get(name)
                if repeat and known is None:
                    continue
                if code.ours:
                    result = bench.ours(problem, setting, longest + 20)
                else:
                    program, tolerance, options = setting
                    result = bench.peer(code.kind, program, problem, tolerance, options, longest + 20)
                if result is None:
                    print(f"{problem.name:16} {code.name:18} {name:8} failed", flush=True)
                    if any(results[code.name].values()):
                        break
                    continue  # too loose to work, perhaps
                result["all_seconds"] = (known or {"all_seconds": []})["all_seconds"] + [result["seconds"]]
                results[code.name][name] = result
                if repeat:
                    continue
                print(f"{problem.name:16} {code.name:18} {name:8} {result['seconds']:10.4f} s  error {result['error']:.2e}  "
                      f"{result['steps']} steps, {result['rejected']} rejected", flush=True)
                if result["seconds"] > longest:
                    break
    for settings in results.values():
        for result in settings.values():
            result["seconds"] = min(result["all_seconds"]) if minimum else statistics.median(result["all_seconds"])
    return results


def curve(settings):
    return [(r["error"], r["seconds"]) for r in settings.values()]


def draw(problem, results, path):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    plt.rcParams["svg.fonttype"] = "none"
    plt.rcParams["svg.hashsalt"] = "stiffront"
    figure, axes = plt.subplots(figsize=(6.4, 4.4))
    markers = "osv^D<>PX*hd"
    for k, (name, settings) in enumerate(results.items()):
        points = [p for p in curve(settings) if 0 < p[0] < 1]
        if points:
            axes.loglog(*zip(*points), "-" if name in ("sbdf", "auto") else "--", marker=markers[k % len(markers)], markersize=4,
                        linewidth=1.8 if name == "sbdf" else 1.0, label=name)
    axes.set_xlabel("error")
    axes.set_ylabel("seconds of the time loop")
    axes.invert_xaxis()
    axes.grid(True, which="major", linewidth=0.4)
    axes.set_title(problem.name, fontsize=10)
    axes.legend(fontsize=7)
    figure.tight_layout()
    figure.savefig(path, metadata={"Date": None})
    plt.close(figure)


def ratios(results, errors=(1e-4, 1e-6, 1e-8)):
    """Rows of the Markdown table: seconds of every code at the errors, and how many times those of sbdf."""
    base = [seconds_at(curve(results["sbdf"]), e) if "sbdf" in results else None for e in errors]
    rows = []
    for name, settings in results.items():
        cells = []
        for error, own in zip(errors, base):
            seconds = seconds_at(curve(settings), error)
            if seconds is None:
                cells.append("-")
            else:
                cells.append(f"{seconds:.3g}" + (f" ({seconds / own:.3g}×)" if own and name != "sbdf" else ""))
        if settings:
            rows.append(f"| {name} | " + " | ".join(cells) + " |")
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--problems", help="names, comma-separated: " + ", ".join(p.name for p in PROBLEMS))
    parser.add_argument("--codes", help="names, comma-separated: " + ", ".join(c.name for c in CODES))
    parser.add_argument("--all", action="store_true", help="all problems, all codes")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--longest", type=float, default=20.0, help="seconds of a run beyond which tighter ones are not tried")
    parser.add_argument("--least", action="store_true", help="the least instead of the median of the repetitions")
    parser.add_argument("--program", default=os.path.join(comparison.ROOT, "build", "release", "stiffront"))
    parser.add_argument("--out", default="out/work-precision")
    options = parser.parse_args()
    names = options.problems.split(",") if options.problems else ([p.name for p in PROBLEMS] if options.all else JUDGED)
    chosen = options.codes.split(",") if options.codes else ([c.name for c in CODES] if options.all else ["sbdf", "auto", "cvode-gmres"])
    codes = [c for c in CODES if c.name in chosen]
    bench = Bench(options.program, options.out, comparison.build_peers(os.path.join(comparison.ROOT, "build", "bench-peers")))
    tables = []
    with open(os.path.join(options.out, "work_precision.csv"), "w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(["problem", "code", "setting", "seconds", "least_seconds", "error", "steps", "rejected", "repeats"])
        for problem in (p for p in PROBLEMS if p.name in names):
            problem.prepare(bench)
            results = measure(bench, problem, codes, options.repeats, options.longest, options.least)
            for name, settings in results.items():
                for setting, r in settings.items():
                    rows.writerow([problem.name, name, setting, f"{r['seconds']:.6g}", f"{min(r['all_seconds']):.6g}", f"{r['error']:.4g}",
                                   r["steps"], r["rejected"], len(r["all_seconds"])])
            file.flush()
            draw(problem, results, os.path.join(options.out, f"{problem.name}.svg"))
            tables += [f"\n{problem.name}: seconds at an error (and how many times those of sbdf)\n", "| | 1e-4 | 1e-6 | 1e-8 |", "| --- | --- | --- | --- |",
                       *ratios(results)]
            with open(os.path.join(options.out, "work_precision.md"), "w", encoding="utf-8") as table:
                table.write("\n".join(tables).lstrip() + "\n")
    print("\n".join(tables))


if __name__ == "__main__":
    main()
