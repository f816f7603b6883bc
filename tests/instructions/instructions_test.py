#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""The kernels take no more than 5 % more instructions than instructions.csv says: a guard against slow regressions that needs no clock.

    instructions_test.py PROGRAM COMPILER [--update]

PROGRAM is counted_runs, compiled for x86-64-v3 whatever the machine (valgrind does not know AVX-512). COMPILER is its name and
version; counts are those of one compiler. Status 77 (skipped) where valgrind, AVX2 or that compiler is missing. --update writes the
counts measured.
"""
import csv
import glob
import os
import re
import shutil
import subprocess
import sys
import tempfile

BASELINE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "instructions.csv")
ALLOWED = 1.05


def skip(why):
    print("skipped: " + why)
    sys.exit(77)


def measure(program):
    if not shutil.which("valgrind"):
        skip("valgrind is not installed (Debian: apt-get install valgrind)")
    with open("/proc/cpuinfo", encoding="utf-8") as f:
        if " avx2" not in f.read():
            skip("this processor has no AVX2")
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, "out")
        run = subprocess.run(["valgrind", "-q", "--tool=callgrind", f"--callgrind-out-file={out}", "--collect-atstart=no",
                              "--toggle-collect=counted_region", "--dump-after=counted_region", "--combine-dumps=no", program],
                             capture_output=True, text=True, check=False)
        names = run.stdout.split()
        if run.returncode != 0 or not names:
            sys.exit(f"{program} under valgrind ended with status {run.returncode}\n{run.stderr}")
        counts = []
        for k in range(1, len(names) + 1):
            with open(f"{out}.{k}", encoding="utf-8") as f:
                counts.append(int(re.search(r"^(?:totals|summary): (\d+)", f.read(), re.M).group(1)))
        return dict(zip(names, counts))


def main():
    program, compiler = sys.argv[1], sys.argv[2]
    update = "--update" in sys.argv
    known = {}
    if not update:
        with open(BASELINE, encoding="utf-8") as f:
            rows = list(csv.reader(f))
        if rows[0][1] != compiler:
            skip(f"the counts are those of {rows[0][1]}, this is {compiler}")
        known = {name: int(count) for name, count in rows[1:]}
    counts = measure(program)
    if update:
        with open(BASELINE, "w", newline="", encoding="utf-8") as f:
            csv.writer(f, lineterminator="\n").writerows([["run", compiler], *counts.items()])
    failed = set(known) ^ set(counts) if known else set()
    for name, count in counts.items():
        ratio = count / known[name] if name in known else 1.0
        print(f"{name:16} {count:12} {100 * (ratio - 1):+6.2f} %")
        if ratio > ALLOWED:
            failed.add(name)
    if failed:
        print(f"more than {100 * (ALLOWED - 1):.0f} % above instructions.csv, or not in both: {', '.join(sorted(failed))}.\n"
              "If the work is worth it: tests/instructions/instructions_test.py PROGRAM COMPILER --update, and say why in the commit.")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
