#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Parallel efficiency of two ranks on two idle cores against the same program on one.

    drivers/bench/efficiency.py [--program build/release/stiffront] [--repeats 5] [--foreign 0.04] [--seconds 140] [NAME ...]

The spiral at 1024^2 and 256^2 and the wave on 1001 points, for adaptive-strang and sbdf: medians of alternating runs, wall-clock seconds of the
time loop without output. Runs during which other processes took more than the given part of the processors do not count and are repeated, as
long as there is time.
"""
import argparse
import json
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time

STRANG = 'method={ name = "adaptive-strang", tolerance = 1e-3 }'
SBDF = 'method={ name = "sbdf", relative_tolerance = 1e-3 }'
CASES = {
    "1024-strang": ["bz-2d-spiral", "grid.points=[1024, 1024]", STRANG, "time.end=2e-4"],
    "1024-sbdf": ["bz-2d-spiral", "grid.points=[1024, 1024]", SBDF, "time.end=5e-3"],
    "256-strang": ["bz-2d-spiral", "grid.points=[256, 256]", STRANG, "time.end=1e-2"],
    "256-sbdf": ["bz-2d-spiral", "grid.points=[256, 256]", SBDF, "time.end=0.2"],
    "1001-strang": ["bz-1d", STRANG, "time.end=1"],
    "1001-sbdf": ["bz-1d", SBDF, "time.end=1"],
}


def busy_seconds():
    """Of all processors since the machine started."""
    with open("/proc/stat", encoding="ascii") as f:
        user, nice, system, _, _, irq, soft, *_ = (int(n) for n in f.readline().split()[1:])
    return (user + nice + system + irq + soft) / os.sysconf("SC_CLK_TCK")


def own_seconds():
    usage = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(u.ru_utime + u.ru_stime for u in usage)


def run(program, ranks, arguments, out):
    """(seconds, part of the processors that others had)"""
    began, busy, own = time.monotonic(), busy_seconds(), own_seconds()
    command = ["mpirun", "-n", str(ranks), program, "run", *arguments, "output.every=0", "-o", out, "--force", "--quiet"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(f"{' '.join(command)}\n{done.stdout}{done.stderr}")
    elapsed = time.monotonic() - began
    foreign = (busy_seconds() - busy - (own_seconds() - own)) / (elapsed * os.cpu_count())
    with open(os.path.join(out, "summary.json"), encoding="utf-8") as f:
        return json.load(f)["wall_seconds"]["total"], foreign


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default="build/release/stiffront")
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--foreign", type=float, default=0.04)
    parser.add_argument("--seconds", type=float, default=140)
    parser.add_argument("names", nargs="*", default=list(CASES), metavar="NAME", help=", ".join(CASES))
    options = parser.parse_args()
    end = time.monotonic() + options.seconds
    with tempfile.TemporaryDirectory() as scratch:
        for name in options.names or CASES:
            found = {1: [], 2: []}
            refused = 0
            while time.monotonic() < end and min(len(f) for f in found.values()) < options.repeats:
                for ranks, seconds in found.items():
                    total, foreign = run(options.program, ranks, CASES[name], os.path.join(scratch, "run"))
                    if foreign <= options.foreign:
                        seconds.append(total)
                    else:
                        refused += 1
            if not all(found.values()):
                print(f"{name:12} no undisturbed runs ({refused} disturbed)", flush=True)
                continue
            one, two = (statistics.median(found[n]) for n in (1, 2))
            print(f"{name:12} 1 rank {one:.4f} s, 2 ranks {two:.4f} s, efficiency {one / (2 * two):.3f} "
                  f"({len(found[1])} and {len(found[2])} runs, {refused} more disturbed)", flush=True)


main()
