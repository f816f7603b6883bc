#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Runs of the program on several numbers of ranks: where the time went, what was sent, how the reaction was balanced.

    drivers/bench/scaling.py [--program build/release/stiffront] [--case bz-2d-spiral] [--points 256] [--kind strong|weak]
                             [--ranks 1,2] [--repeats 3] [--out out/scaling] [KEY=VALUE ...]

strong: the same grid on all numbers of ranks; weak: --points per direction and rank (in two dimensions the ranks are laid out as square as
possible). Repetitions alternate between the numbers of ranks; of each the one with the median total is kept. On more ranks than cores seconds
mean nothing, but counts, bytes, imbalance and the checksum do. Left behind: scaling.csv and scaling.png.

Needs python3-matplotlib for the picture.
"""
import argparse
import csv
import json
import os
import shutil
import subprocess
import sys

PHASES = ("diffusion", "reaction", "communication")
COUNTS = ("diffusion_stages", "halo_exchanges", "halo_messages", "halo_bytes", "allreduces")


def square(n):
    p = int(n**0.5)
    while n % p:
        p -= 1
    return n // p, p


def run(options, ranks, overrides, out):
    command = ["mpirun", "-n", str(ranks), options.program, "run", options.case, *overrides, "-o", out, "--force", "--quiet"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(f"{' '.join(command)}\n{done.stdout}{done.stderr}")
    with open(os.path.join(out, "summary.json"), encoding="utf-8") as f:
        return json.load(f)


def row(ranks, summary):
    r = {"ranks": ranks, "points": "x".join(str(n) for n in summary["grid"]["points"]), "steps": summary["steps"]["accepted"],
         "rejected": summary["steps"]["rejected"], "total": summary["wall_seconds"]["total"]}
    for phase in PHASES:
        seconds = [w[f"{phase}_seconds"] for w in summary["rank_work"]]
        r |= {f"{phase}_min": min(seconds), f"{phase}_mean": sum(seconds) / len(seconds), f"{phase}_max": max(seconds)}
    r |= {c: summary["work"][c] for c in COUNTS}
    balance = summary.get("balance", {})
    r["imbalance"] = summary["imbalance"]
    for key in ("imbalance_before", "imbalance_after", "messages", "bytes", "cells"):
        r[f"balance_{key}"] = balance.get(key, "")
    r["checksum"] = summary["checksum"]
    return r


def picture(rows, kind, path):
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(10, 4))
    ranks = [r["ranks"] for r in rows]
    left.loglog(ranks, [r["total"] for r in rows], "ko-", label="total")
    for phase in PHASES:
        line, = left.loglog(ranks, [max(r[f"{phase}_mean"], 1e-6) for r in rows], "o-", label=phase)
        left.fill_between(ranks, [max(r[f"{phase}_min"], 1e-6) for r in rows], [max(r[f"{phase}_max"], 1e-6) for r in rows],
                          color=line.get_color(), alpha=0.2)
    left.set(xlabel="ranks", ylabel="seconds (band: least and most of a rank)", title=f"{kind} scaling")
    left.legend()
    right.semilogx(ranks, [float(r["balance_imbalance_before"] or r["imbalance"]) for r in rows], "o-", label="before balancing")
    right.semilogx(ranks, [float(r["balance_imbalance_after"] or r["imbalance"]) for r in rows], "o-", label="after")
    right.set(xlabel="ranks", ylabel="reaction: largest over mean work", ylim=(0.9, None))
    right.legend()
    figure.tight_layout()
    figure.savefig(path, dpi=120)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default="build/release/stiffront")
    parser.add_argument("--case", default="bz-2d-spiral")
    parser.add_argument("--points", type=int, default=256)
    parser.add_argument("--kind", choices=("strong", "weak"), default="strong")
    parser.add_argument("--ranks", default="1,2")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--out", default="out/scaling")
    parser.add_argument("overrides", nargs="*", metavar="KEY=VALUE")
    options = parser.parse_args()
    numbers = [int(n) for n in options.ranks.split(",")]
    shutil.rmtree(options.out, ignore_errors=True)
    os.makedirs(options.out)
    two = options.case.find("2d") >= 0
    found = {n: [] for n in numbers}
    for repeat in range(options.repeats):
        for n in numbers:
            px, py = square(n) if two else (n, 1)
            factor = (px, py) if options.kind == "weak" else (1, 1)
            points = [options.points * factor[0], options.points * factor[1]] if two else [options.points * factor[0]]
            overrides = [f"grid.points={points}", f"grid.processes={[px, py] if two else [px]}", *options.overrides]
            if options.kind == "weak":
                # The same spacing on all, so that the steps are the same.
                upper = [float(factor[0]), float(factor[1])] if two else [float(factor[0])]
                overrides.append(f"grid.upper={upper}")
            found[n].append(row(n, run(options, n, overrides, os.path.join(options.out, f"run-{n}"))))
    rows = [sorted(found[n], key=lambda r: r["total"])[len(found[n]) // 2] for n in numbers]
    with open(os.path.join(options.out, "scaling.csv"), "w", newline="", encoding="utf-8") as f:
        writer = csv.DictWriter(f, rows[0].keys())
        writer.writeheader()
        writer.writerows(rows)
    picture(rows, options.kind, os.path.join(options.out, "scaling.png"))
    for r in rows:
        print(f"{r['ranks']:5} ranks {r['points']:>11}: {r['total']:.4f} s, {r['halo_exchanges']} exchanges, {r['halo_bytes']} bytes, "
              f"{r['allreduces']} reductions, imbalance {r['balance_imbalance_before'] or r['imbalance']} -> "
              f"{r['balance_imbalance_after'] or r['imbalance']}, balance bytes {r['balance_bytes'] or 0}, {r['checksum']}")
    if options.kind == "strong" and len({r["checksum"] for r in rows}) > 1:
        sys.exit("the checksums differ")


main()
