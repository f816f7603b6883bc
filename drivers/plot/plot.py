#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Draws what a run left in its output folder: profiles or maps of the species, step sizes and errors.

Needs h5py and matplotlib (Debian: python3-h5py python3-matplotlib).
Exit status: 0 drawn, 2 wrong command line, 3 no such species, 5 a file could not be read or written.
"""

import argparse
import csv
import math
import os
import re
import sys

try:
    import h5py
    import matplotlib
    import numpy as np
except ImportError as missing:
    # The first python3 on the path is often not Debian's, and only Debian's sees Debian's modules.
    tried = os.environ.get("STIFFRONT_PLOT_TRIED", "").split(":") + [os.path.realpath(sys.executable)]
    os.environ["STIFFRONT_PLOT_TRIED"] = ":".join(tried)
    for folder in ["/usr/bin"] + os.environ.get("PATH", "").split(":"):
        candidate = os.path.join(folder, "python3")
        if os.access(candidate, os.X_OK) and os.path.realpath(candidate) not in tried:
            os.execv(candidate, [candidate, os.path.abspath(__file__)] + sys.argv[1:])
    sys.exit(f"stiffront plot: {missing}; install python3-h5py and python3-matplotlib "
             "(Debian: apt-get install python3-h5py python3-matplotlib)")

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (the backend must be chosen first)
from matplotlib.cm import ScalarMappable  # noqa: E402
from matplotlib.colors import Normalize  # noqa: E402

MAP = "cividis"  # perceptually uniform, and the same to colour-blind eyes
ACCEPTED, REJECTED, REFERENCE = "#0072B2", "#D55E00", "#555555"
MOST_SPECIES = 8
MOST_PROFILES, MOST_LINES, MOST_MAPS = 6, 40, 4
MOST_PIXELS = 1500  # per direction; finer grids are drawn with a stride


class PlotError(Exception):
    def __init__(self, status, message):
        super().__init__(message)
        self.status = status


class State:
    """One fields-NNNNNN.h5 or fields-NNNNNN-K.h5: time, coordinates and the species asked for."""

    def __init__(self, path, species):
        with h5py.File(path, "r") as file:
            self.time = float(file.attrs["time"])
            self.x = np.atleast_1d(file["x"][...])
            self.y = np.atleast_1d(file["y"][...]) if "y" in file else None
            self.values = {name: np.ma.masked_invalid(file[name][...]) for name in species}


def species_of(file):
    names = file.attrs.get("species")
    if names is None:
        return [name for name in file if name not in ("x", "y", "z") and isinstance(file[name], h5py.Dataset)]
    if isinstance(names, (str, bytes)):
        text = names.decode() if isinstance(names, bytes) else names
        return text.replace(",", " ").split()
    return [name.decode() if isinstance(name, bytes) else str(name) for name in names]


def case_of(file):
    """The case as nested dictionaries; empty if it is not there or this Python cannot read TOML."""
    try:
        import tomllib
        text = file.attrs["case"]
        return tomllib.loads(text.decode() if isinstance(text, bytes) else str(text))
    except (ImportError, KeyError, ValueError):
        return {}


def field_files(folder):
    """In order of time: of several states within one step, numbered -1, -2, ..., the last has no such number."""
    found = []
    for name in os.listdir(folder):
        parts = re.fullmatch(r"fields-(\d+)(?:-(\d+))?\.h5", name)
        if parts:
            found.append((int(parts[1]), int(parts[2]) if parts[2] else math.inf, name))
    return [os.path.join(folder, name) for _, _, name in sorted(found)]


def evenly(items, count):
    """At most count of the items, the first and the last among them."""
    if len(items) <= count:
        return list(items)
    return [items[round(i * (len(items) - 1) / (count - 1))] for i in range(count)]


def read_states(paths, species):
    states = []
    for path in paths:
        try:
            states.append(State(path, species))
        except (OSError, KeyError) as error:
            print(f"stiffront plot: skipping {path}: {error}", file=sys.stderr)
    return states


def number(text):
    try:
        return float(text)
    except (TypeError, ValueError):
        return math.nan


def read_history(path):
    """Columns as arrays; a line cut short by a killed run counts as not written. None without a file or a line."""
    if not os.path.exists(path):
        return None
    with open(path, newline="") as file:
        reader = csv.DictReader(file)
        rows = [row for row in reader if None not in row.values()]
    if not rows or not {"time", "dt", "accepted"} <= rows[0].keys():
        return None
    history = {name: np.array([number(row[name]) for row in rows]) for name in rows[0] if name and name != "accepted"}
    history["accepted"] = np.array([row["accepted"].strip().lower() in ("1", "true", "yes") for row in rows])
    return history


def span(arrays):
    """Least and largest finite value; (0, 1) if there is none."""
    finite = [array.compressed() for array in arrays if array.count()]
    if not finite:
        return 0.0, 1.0
    return min(float(a.min()) for a in finite), max(float(a.max()) for a in finite)


def spans_decades(low, high):
    """Worth a logarithmic axis. Beyond twelve decades it would show only how a front fades into nothing."""
    return low > 0 and 1e4 < high / low < 1e12


def set_value_axis(axes, low, high):
    if spans_decades(low, high):
        axes.set_yscale("log")
    elif low == high:
        margin = abs(low) * 0.1 or 1.0
        axes.set_ylim(low - margin, high + margin)


def note(axes, text):
    axes.text(0.5, 0.5, text, transform=axes.transAxes, ha="center", va="center", color=REFERENCE)


def draw_profiles(axes, states, name, norm):
    low, high = span([state.values[name] for state in states])
    for state in states:
        axes.plot(state.x, state.values[name], color=plt.get_cmap(MAP)(norm(state.time)), linewidth=1.2)
    hidden = sum(int(np.ma.count_masked(state.values[name])) for state in states)
    if hidden:
        axes.set_title(f"{hidden} values are not finite", fontsize="small", color=REJECTED)
    set_value_axis(axes, low, high)
    axes.set_xlabel("x")
    axes.set_ylabel(name)
    axes.margins(x=0)


def draw_waterfall(axes, states, name):
    """Profiles stacked by time, each hiding what lies behind it."""
    values = [state.values[name] for state in states]
    logarithmic = spans_decades(*span(values))
    if logarithmic:
        values = [np.ma.log10(array) for array in values]
    low, high = span(values)
    times = [state.time for state in states]
    spacing = (max(times) - min(times)) / (len(times) - 1) or 1.0
    scale = 2.5 * spacing / ((high - low) or 1.0)
    for i, (state, array) in enumerate(zip(states, values)):
        line = state.time + scale * (array - low)
        axes.fill_between(state.x, state.time, line, facecolor="white", edgecolor="none", zorder=2 * (len(states) - i))
        axes.plot(state.x, line, color=ACCEPTED, linewidth=0.8, zorder=2 * (len(states) - i) + 1)
    axes.set_xlabel("x")
    axes.set_ylabel("t")
    axes.set_title(f"{'log ' if logarithmic else ''}{name}: profiles stacked in time", fontsize="small")
    axes.margins(x=0)


def draw_map(figure, axes, state, name, norm):
    values = state.values[name]
    step_y, step_x = (max(1, math.ceil(n / MOST_PIXELS)) for n in values.shape)
    x, y = state.x, state.y
    half_x = 0.5 * (x[-1] - x[0]) / max(1, len(x) - 1)  # points are vertices: a pixel reaches half a spacing around one
    half_y = 0.5 * (y[-1] - y[0]) / max(1, len(y) - 1)
    image = axes.imshow(values[::step_y, ::step_x], origin="lower", cmap=MAP, norm=norm, interpolation="nearest",
                        extent=(x[0] - half_x, x[-1] + half_x, y[0] - half_y, y[-1] + half_y),
                        aspect="equal" if 0.25 < (y[-1] - y[0]) / ((x[-1] - x[0]) or 1.0) < 4 else "auto")
    axes.set_title(f"{name}, t = {state.time:.4g}", fontsize="small")
    axes.set_xlabel("x")
    axes.set_ylabel("y")
    axes.set_facecolor("#DDDDDD")  # shows through where a value is not finite
    return image


def draw_attempts(axes, history, column, label):
    """One mark an attempted step: accepted as a line of dots, rejected as crosses. Logarithmic where it can be."""
    time, values, accepted = history["time"], history[column], history["accepted"]
    drawn = np.isfinite(values) & np.isfinite(time)
    positive = drawn & (values > 0)
    if positive.any():
        drawn = positive
        axes.set_yscale("log")
    good, bad = drawn & accepted, drawn & ~accepted
    if good.any():
        axes.plot(time[good], values[good], color=ACCEPTED, marker="." if good.sum() < 300 else None, markersize=4,
                  linewidth=0.8, label="accepted")
    if bad.any():
        axes.plot(time[bad], values[bad], color=REJECTED, marker="x", markersize=5, linestyle="none", label="rejected")
    axes.set_xlabel("t")
    axes.set_ylabel(label)
    return drawn


def draw_step_sizes(axes, history):
    drawn = draw_attempts(axes, history, "dt", "step size Δt")
    critical = history.get("critical_dt")
    if critical is not None:
        known = np.isfinite(critical) & (critical > 0) & history["accepted"]
        if known.any():
            axes.plot(history["time"][known], critical[known], color=REFERENCE, linestyle=":", linewidth=1.2,
                      label="critical step Δt⋆")
    rejected = int(np.count_nonzero(~history["accepted"]))
    axes.set_title(f"{int(np.count_nonzero(history['accepted']))} steps accepted, {rejected} rejected", fontsize="small")
    if drawn.any():
        axes.legend(fontsize="small")
        if np.ptp(np.log10(history["dt"][drawn & (history["dt"] > 0)])) < 0.3:  # a fixed step: decades would mislead
            axes.set_yscale("linear")
            axes.set_ylim(0, 1.3 * np.max(history["dt"][drawn]))


def draw_errors(axes, history, tolerance):
    if "error" not in history or not np.isfinite(history["error"]).any() or not (history["error"] > 0).any():
        note(axes, "this method estimates no error")
        axes.set_axis_off()
        return
    draw_attempts(axes, history, "error", "error estimate")
    if tolerance is not None:
        axes.axhline(tolerance, color=REFERENCE, linestyle="--", linewidth=1.0, label=f"tolerance {tolerance:g}")
    axes.legend(fontsize="small")


def draw_fields_1d(figure, paths, species):
    states = read_states(evenly(paths, MOST_LINES), species)
    if not states:
        raise PlotError(5, "none of the result files can be read")
    shown = evenly(states, MOST_PROFILES)
    stacked = len(states) >= 3 and len(states[0].x) > 1
    panels = figure.subplots(len(species), 2 if stacked else 1, squeeze=False)
    norm = Normalize(min(s.time for s in states), max(s.time for s in states))
    for row, name in zip(panels, species):
        draw_profiles(row[0], shown, name, norm)
        if stacked:
            draw_waterfall(row[1], states, name)
    if len(shown) > 1:
        bar = figure.colorbar(ScalarMappable(norm, MAP), ax=list(panels[:, 0]), location="top", aspect=40, shrink=0.9)
        bar.set_label("t")
        bar.set_ticks([state.time for state in shown], labels=[f"{state.time:.3g}" for state in shown])
    else:
        panels[0, 0].set_title(f"t = {shown[0].time:.4g}", fontsize="small")


def draw_fields_2d(figure, paths, species):
    states = read_states(evenly(paths, MOST_MAPS), species)
    if not states:
        raise PlotError(5, "none of the result files can be read")
    panels = figure.subplots(len(species), len(states), squeeze=False)
    for row, name in zip(panels, species):
        low, high = span([state.values[name] for state in states])
        norm = Normalize(low, high if high > low else low + (abs(low) or 1.0))
        for axes, state in zip(row, states):
            image = draw_map(figure, axes, state, name, norm)
            axes.label_outer()
        figure.colorbar(image, ax=list(row), label=name, shrink=0.9)


def choose_species(known, asked):
    if asked is None:
        if len(known) > MOST_SPECIES:
            print(f"stiffront plot: drawing the first {MOST_SPECIES} of {len(known)} species; choose with --species",
                  file=sys.stderr)
        return known[:MOST_SPECIES]
    chosen = [name for name in asked.replace(",", " ").split()]
    for name in chosen:
        if name not in known:
            raise PlotError(3, f"--species: there is no '{name}'; there are {', '.join(known)}")
    return chosen


def draw(folder, asked, target):
    if not os.path.isdir(folder):
        raise PlotError(5, f"{folder}: no such folder")
    paths = field_files(folder)
    if not paths:
        raise PlotError(5, f"{folder}: no results here (fields-NNNNNN.h5)")
    try:
        with h5py.File(paths[0], "r") as first:
            known, case = species_of(first), case_of(first)
            dimension = len(first[known[0]].shape)
    except (OSError, KeyError, IndexError) as error:
        raise PlotError(5, f"{paths[0]}: {error}")
    species = choose_species(known, asked)
    history = read_history(os.path.join(folder, "history.csv"))
    if dimension > 2:
        raise PlotError(5, f"{folder}: {dimension}-dimensional results are not drawn here; open fields.xdmf in ParaView")

    if dimension == 1:
        width, row_height, draw_fields = 10.0, 2.6, draw_fields_1d
    else:
        width, row_height, draw_fields = 3.0 * min(len(paths), MOST_MAPS) + 1.5, 2.9, draw_fields_2d
    width = max(width, 8.0)
    field_height, history_height = row_height * len(species) + 0.6, 2.8 if history else 0.0
    figure = plt.figure(figsize=(width, field_height + history_height), layout="constrained")
    if history:
        upper, lower = figure.subfigures(2, 1, height_ratios=[field_height, history_height])
    else:
        upper = figure
    draw_fields(upper, paths, species)
    if history:
        left, right = lower.subplots(1, 2)
        draw_step_sizes(left, history)
        tolerance = case.get("method", {}).get("tolerance")
        draw_errors(right, history, tolerance if isinstance(tolerance, (int, float)) else None)
    title = case.get("title")
    if title:
        figure.suptitle(title)
    try:
        figure.savefig(target, dpi=150)
    except (OSError, ValueError) as error:
        raise PlotError(5, f"{target}: {error}")


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="stiffront plot", description="Draws the results in an output folder.")
    parser.add_argument("folder", metavar="DIR", help="output folder of a run")
    parser.add_argument("--species", metavar="S", help="draw only these, separated by commas")
    parser.add_argument("-o", "--output", metavar="F", help="picture file, .png or .svg (default: DIR/plot.png)")
    arguments = parser.parse_args(arguments)
    target = arguments.output or os.path.join(arguments.folder, "plot.png")
    plt.rcParams.update({"svg.fonttype": "none", "axes.grid": False, "font.size": 9})
    try:
        draw(arguments.folder, arguments.species, target)
    except PlotError as error:
        print(f"stiffront plot: {error}", file=sys.stderr)
        return error.status
    print(target)
    return 0


if __name__ == "__main__":
    sys.exit(main())
