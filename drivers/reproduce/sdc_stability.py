#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Domains of stability of spectral deferred correction: Hagstrom & Zhou 2006, figures 6 to 8 and section 5, as numbers.

usage: sdc_stability.py [PROGRAM]     (default build/release/stiffront)

Prints a Markdown table of what `stiffront stability` measures beside the numbers of an independent implementation, and ends with the
largest relative difference; exit status 1 if it is above 1 %.
"""
import re
import subprocess
import sys

# nodes, m, k, L, consistent, final update, d_r, d_i: area, real axis (None: beyond 1e4), exits at -0.1, -1, -5, -10, -20, -40
ROWS = [
    ("legendre", 3, 2, 4, True, "quadrature", 253.3, 59.75, [2.755, 3.291, 4.129, 4.797, 5.419, 4.483]),
    ("legendre", 4, 2, 6, True, "quadrature", 447.6, 118.47, [3.636, 4.431, 5.038, 5.829, 7.042, 8.467]),
    ("legendre", 6, 2, 10, True, "quadrature", 621.2, None, [5.357, 5.887, 7.445, 7.878, 9.196, 11.645]),
    ("legendre", 6, 2, 10, False, "quadrature", 690.0, None, [4.962, 5.471, 6.749, 8.157, 10.415, 13.354]),
    ("legendre", 8, 2, 14, True, "quadrature", 745.9, None, [6.439, 7.246, 8.942, 10.956, 11.467, 13.651]),
    ("legendre", 6, 1, 11, True, "quadrature", 839.8, 2609, [5.808, 6.250, 8.137, 9.334, 11.615, 16.297]),
    ("legendre", 6, 3, 9, True, "quadrature", 362.6, None, [4.957, 5.481, 5.993, 5.984, 6.068, 6.069]),
    ("legendre", 6, 4, 8, True, "quadrature", 162.1, 50.26, [4.461, 5.033, 4.699, 4.360, 3.643, 2.195]),
    ("legendre", 6, 5, 7, True, "quadrature", 74.8, 37.28, [3.958, 4.384, 3.571, 2.849, 1.646, 0.0]),
    ("radau", 4, 2, 5, True, "last-node", 689.1, None, [3.858, 4.079, 5.122, 6.436, 8.999, 14.022]),
    ("radau", 4, 2, 5, True, "quadrature", 389.5, None, [3.219, 3.868, 4.571, 5.236, 6.162, 7.268]),
    ("radau", 6, 2, 9, True, "last-node", 695.2, None, [4.605, 5.344, 7.100, 7.997, 9.816, 13.461]),
    ("radau", 6, 2, 9, False, "last-node", 894.7, None, [5.283, 5.696, 7.436, 9.270, 12.441, 17.855]),
    ("radau", 6, 5, 6, True, "last-node", 207.2, None, [4.265, 4.765, 4.129, 3.746, 3.365, 3.204]),
    ("legendre", 5, 2, 6, True, "quadrature", 465.9, 175.74, [4.561, 5.302, 5.703, 6.358, 7.424, 8.626]),
    ("radau", 5, 2, 6, True, "quadrature", 492.8, None, [3.776, 4.809, 5.615, 6.266, 7.455, 9.277]),
    ("lobatto", 5, 2, 6, True, "quadrature", 247.4, 49.44, [3.679, 4.318, 4.999, 5.585, 6.013, 4.426]),
    ("legendre", 5, 2, 6, True, "extrapolation", 643.4, None, None),
    ("radau", 5, 2, 6, True, "last-node", 678.7, None, None),
    ("lobatto", 5, 2, 6, True, "last-node", 577.6, None, None),
]
# Both parts of z implicit, section 5.2: nodes, m, L, final update, d_r, real axis
PRECONDITIONED = [
    ("legendre", 4, 7, "quadrature", 0.75, 814.3), ("legendre", 4, 7, "quadrature", 1.25, 140.9),
    ("legendre", 6, 11, "quadrature", 0.75, 6179), ("legendre", 6, 11, "quadrature", 1.25, 278.9),
    ("radau", 4, 6, "quadrature", 0.75, 215.4), ("radau", 4, 6, "quadrature", 1.25, 2382.6),
    ("radau", 6, 10, "quadrature", 0.75, 1314), ("radau", 6, 10, "quadrature", 1.25, 6940),
    ("lobatto", 4, 5, "quadrature", 0.75, 622.2), ("lobatto", 4, 5, "quadrature", 1.25, 30.9),
    ("lobatto", 6, 9, "quadrature", 0.75, 225.8), ("lobatto", 6, 9, "quadrature", 1.25, 86.2),
    ("lobatto", 4, 5, "last-node", 0.75, 1228.5), ("lobatto", 6, 9, "last-node", 0.75, 5336),
    ("lobatto", 6, 9, "last-node", 1.25, None), ("radau", 4, 6, "last-node", 1.25, None), ("legendre", 6, 11, "extrapolation", 0.75, None),
]


def measure(program, nodes, m, k, corrections, consistent, final_update, part=None):
    command = [program, "stability", f"nodes=gauss-{nodes}", f"node_count={m}", f"starting_order={k}", f"corrections={corrections}",
               f"consistent={str(consistent).lower()}", f"final_update={final_update}"]
    if part is not None:
        command += ["--implicit-real", str(part), "--implicit-imaginary", str(part)]
    text = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    values = [None if found.startswith(">") else float(found) for found in re.findall(r"^(?:stable|first).*?\s{2,}(> \d+|[\d.e+-]+)$", text, re.M)]
    return values[0], values[1], values[2:]


def main():
    program = sys.argv[1] if len(sys.argv) > 1 else "build/release/stiffront"
    worst = 0.0

    def compare(ours, theirs):
        nonlocal worst
        if (ours is None) != (theirs is None):
            worst = float("inf")
        elif theirs:
            worst = max(worst, abs(ours / theirs - 1.0))
        show = [">1e4" if x is None else f"{x:.5g}" for x in (ours, theirs)]
        return f"{show[0]} ({show[1]})"

    print("| set | final | area | real axis | exits at -0.1, -1, -5, -10, -20, -40 |\n| --- | --- | --- | --- | --- |")
    for nodes, m, k, corrections, consistent, final, area, axis, strip in ROWS:
        a, x, b = measure(program, nodes, m, k, corrections, consistent, final)
        exits = ", ".join(compare(ours, theirs) for ours, theirs in zip(b, strip)) if strip else ""
        print(f"| {nodes} m={m} k={k} L={corrections} {'c' if consistent else 'i'} | {final} | {compare(a, area)} | {compare(x, axis)} | {exits} |")
    print("\n| set, k = 1 | final | d_r = d_i | real axis |\n| --- | --- | --- | --- |")
    for nodes, m, corrections, final, part, axis in PRECONDITIONED:
        _, x, _ = measure(program, nodes, m, 1, corrections, True, final, part)
        print(f"| {nodes} m={m} | {final} | {part} | {compare(x, axis)} |")
    print(f"\nlargest relative difference: {worst:.2%}")
    return worst > 0.01


if __name__ == "__main__":
    sys.exit(main())
