#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Reference solutions for the cases of this folder, independent of this project but for the difference scheme: scipy's Radau with relative
tolerance 1e-12 on the same second-order semi-discretisation. Prints the values that custom_reference_test.cpp holds.

Needs python3-scipy. Usage: reference_solutions.py [NAME ...]
"""

import sys

import numpy as np
from scipy.integrate import solve_ivp
from scipy.sparse import lil_matrix


def barkley(t, x, u):
    return [u[0] * (1 - u[0]) * (u[0] - (u[1] + 0.06) / 0.75) / 0.02, u[0] - u[1]]


def hires(t, x, u):
    a, b, c, d, e, f, g, h = u
    return [-1.71 * a + 0.43 * b + 8.32 * c + 0.0007, 1.71 * a - 8.75 * b, -10.03 * c + 0.43 * d + 0.035 * e,
            8.32 * b + 1.71 * c - 1.12 * d, -1.745 * e + 0.43 * f + 0.43 * g,
            -280 * f * h + 0.69 * d + 1.71 * e - 0.43 * f + 0.69 * g, 280 * f * h - 1.81 * g, -280 * f * h + 1.81 * g]


def arrhenius(t, x, u):
    k = 2.5e9 * np.exp(-1.2e5 / (8.31446261815324 * u[0]))
    return [1500 * k * u[1] - 2 * (u[0] - 300), -k * u[1]]


def forced(t, x, u):
    source = (2.0 if t < 0.7 else 0.0) * x
    return [5 * u[0] * (1 - u[0]) * (u[0] - 0.2) - u[1] + 0.8 * np.sin(6 * t) * np.exp(-10 * (x - 1) ** 2) + source,
            0.3 * (u[0] - u[1]) + 0.1 * np.cos(3 * t)]


# name: points, length, periodic, times from jump to jump, diffusion, rates, initial state, points shown
CASES = {
    "barkley": (101, 20.0, False, [0.0, 2.0], [1.0, 0.0], barkley,
                lambda x: [np.where(x < 2, 0.5, 0) + 0.25 * (1 - np.tanh((x - 2) * 3)), 0.2 * np.exp(-x**2 / 4)],
                [0, 25, 50, 75, 100]),
    "hires": (41, 1.0, False, [0.0, 30.0], [1e-3, 1e-3, 1e-3, 2e-3, 1e-3, 1e-3, 0.0, 5e-4], hires,
              lambda x: [np.exp(-20 * (x - 0.3) ** 2)] + [0 * x] * 6 + [0.0057 * (1 + x)], [0, 10, 20, 30, 40]),
    "arrhenius": (101, 0.1, False, [0.0, 0.05], [2e-4, 1e-4], arrhenius,
                  lambda x: [300 + 1300 * np.exp(-(x / 0.01) ** 2), 1 - np.exp(-(x / 0.01) ** 2)], [0, 30, 36, 40, 44]),
    "forced": (81, 3.0, True, [0.0, 0.7, 2.0], [0.05, 0.01], forced,
               lambda x: [np.sin(2 * np.pi * x / 3) ** 2, 0 * x], [0, 20, 40, 60, 80]),
}


def solve(points, length, periodic, times, diffusion, rates, initial):
    species = len(diffusion)
    h = length / (points if periodic else points - 1)
    x = h * np.arange(points)

    def second_difference(v):
        w = np.empty_like(v)
        w[1:-1] = v[:-2] - 2 * v[1:-1] + v[2:]
        w[0] = v[-1] - 2 * v[0] + v[1] if periodic else 2 * (v[1] - v[0])
        w[-1] = v[-2] - 2 * v[-1] + v[0] if periodic else 2 * (v[-2] - v[-1])
        return w / h**2

    def right_side(t, z):
        u = z.reshape(points, species).T
        f = np.array(rates(t, x, u), dtype=float)
        for s, d in enumerate(diffusion):
            f[s] += d * second_difference(u[s])
        return f.T.ravel()

    pattern = lil_matrix((points * species, points * species))
    for i in range(points):
        for j in (i - 1, i, i + 1):
            if periodic or 0 <= j < points:
                j %= points
                pattern[i * species:(i + 1) * species, j * species:(j + 1) * species] = 1

    z = np.array(initial(x), dtype=float).T.ravel()
    for begin, end in zip(times[:-1], times[1:]):
        before_jump = np.nextafter(end, begin)
        result = solve_ivp(lambda t, y: right_side(min(t, before_jump), y), (begin, end), z, method="Radau", rtol=1e-12,
                           atol=1e-13, jac_sparsity=pattern)
        assert result.success, result.message
        z = result.y[:, -1]
    return z.reshape(points, species).T


for name in sys.argv[1:] or CASES:
    *problem, shown = CASES[name]
    print(name)
    for row in solve(*problem):
        print("    {" + ", ".join(f"{row[i]:.12g}" for i in shown) + f"}}  largest {np.abs(row).max():.4g}")
