#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""What the sweeps of sbdf with corrections on coarser grids leave of an error, and whether BDF bears it (docs/sbdf-stability.md).

    drivers/generators/plane_stability.py            # 2 min, needs numpy

The error's propagation is built as a matrix on a small periodic square, with everything as in solvers/plane_correction.cpp: sweeps in
three groups, a V-cycle after the first and the second, linear interpolation, means, second-order differences on coarser grids. Printed:
its norm, its smallest and largest eigenvalue, and the largest factor per step of the recursion with BDF5, of predictor, sweeps and
history together, over all modes of the grid but the constant (which nothing damps).
"""
import numpy as np

POINTS = 16
POINTS_OF_RECURSION = 8


def second_difference(n, order):
    one = np.eye(n)
    near = np.roll(one, 1, 0) + np.roll(one, -1, 0)
    if order == 2:
        return 2.0 * one - near
    return 2.5 * one - 4.0 / 3.0 * near + (np.roll(one, 2, 0) + np.roll(one, -2, 0)) / 12.0


def zeros(start, degree):
    """Of the Chebyshev polynomial for [start, 1], the largest first."""
    return 0.5 * (1.0 + start) + 0.5 * (1.0 - start) * np.cos((2 * np.arange(degree) + 1) * np.pi / (2 * degree))


def shared_out(values, sizes):
    groups = [[] for _ in sizes]
    due = [0.0] * len(sizes)
    for value in values:
        due = [d + size / len(values) for d, size in zip(due, sizes)]
        group = max((g for g in range(len(sizes)) if len(groups[g]) < sizes[g]), key=lambda g: due[g] + (-1e-9 * g))
        groups[group].append(value)
        due[group] -= 1.0
    return groups


def smoothing(rough):
    if rough > 0.23:
        return (2, 3, 2), (2, 2)
    if rough > 0.15:
        return (3, 4, 3), (3, 3)
    return (4, 5, 4), (3, 3)


def matrix(n, order, coupling, ratio):
    """1 - gamma D Laplacian for gamma D / dx^2 = coupling, and gamma times the spectral radius."""
    one = np.eye(n)
    difference = second_difference(n, order)
    a = np.eye(n * n) + coupling * (np.kron(one, difference) + ratio * np.kron(difference, one))
    return a, coupling * (1.0 + ratio) * (4.0 if order == 2 else 16.0 / 3.0)


def ways(n):
    interpolation = np.zeros((n, n // 2))
    for i in range(n // 2):
        interpolation[2 * i, i] = 1.0
        interpolation[(2 * i + 1) % n, i] += 0.5
        interpolation[(2 * i - 1) % n, i] += 0.5
    return np.kron(interpolation, interpolation), np.kron(interpolation.T, interpolation.T) / 4.0


def cycle(n, coupling, ratio, b, rough):
    a, radius = matrix(n, 2, coupling, ratio)
    if n == 2:
        return np.linalg.solve(a, b)
    steps = smoothing(rough)[1]
    weights = 0.5 / zeros(0.8 * rough, sum(steps))
    blocks = 1.0 + 0.5 * radius
    x = np.zeros_like(b)
    for w in weights[0::2]:
        x = x + w / blocks * (b - a @ x)
    up, down = ways(n)
    x = x + up @ cycle(n // 2, coupling / 4.0, ratio, down @ (b - a @ x), rough)
    for w in weights[1::2]:
        x = x + w / blocks * (b - a @ x)
    return x


def propagation(n, order, stiffness, ratio):
    """Of the error, and the matrix of the equation."""
    rough = 0.5 * min(1.0, ratio) / (1.0 + ratio)
    coupling = stiffness / ((1.0 + ratio) * (4.0 if order == 2 else 16.0 / 3.0))
    a, radius = matrix(n, order, coupling, ratio)
    sizes = smoothing(rough)[0]
    up, down = ways(n)
    v = np.eye(n * n)
    for g, group in enumerate(shared_out(zeros(rough, sum(sizes)), sizes)):
        if g > 0:
            v = v - up @ cycle(n // 2, coupling / 4.0, ratio, down @ (a @ v), rough)
        for zero in group:
            v = v - (a @ v) / (1.0 + radius * zero)
    return v, a


def largest_factor(order, stiffness, ratio, k=5):
    n = POINTS_OF_RECURSION
    e, a = propagation(n, order, stiffness, ratio)
    derivative = np.linalg.solve(np.vander(-np.arange(k + 1.0), k + 1, increasing=True).T, np.eye(k + 1)[1])
    history = -derivative[1:] / derivative[0]
    predictor = np.linalg.solve(np.vander(-np.arange(1.0, k + 2.0), k + 1, increasing=True).T, np.eye(k + 1)[0])
    size = n * n
    exact = (np.eye(size) - e) @ np.linalg.inv(a)
    step = np.zeros((size * (k + 1), size * (k + 1)))
    for i in range(k + 1):
        step[:size, i * size:(i + 1) * size] = predictor[i] * e + (history[i] * exact if i < k else 0.0)
        if i < k:
            step[(i + 1) * size:(i + 2) * size, i * size:(i + 1) * size] = np.eye(size)
    return np.sort(np.abs(np.linalg.eigvals(step)))[::-1][1]


print("| order | (dx/dy)^2 | gamma rho | norm | eigenvalues | largest factor, BDF5 |\n|---|---|---|---|---|---|")
for order in (2, 4):
    for ratio in (1.0, 0.86, 0.8, 0.44, 0.3):
        for stiffness in (100.0, 1e4, 1e6):
            e, _ = propagation(POINTS, order, stiffness, ratio)
            eigenvalues = np.linalg.eigvals(e).real
            print(f"| {order} | {ratio} | {stiffness:.0e} | {np.linalg.norm(e, 2):.3f} | {eigenvalues.min():.3f} .. {eigenvalues.max():.3f} "
                  f"| {largest_factor(order, stiffness, ratio):.2f} |", flush=True)
