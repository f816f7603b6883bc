#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Draws what a run left in its output folder: profiles or maps of the species, step sizes, errors and costs; or an animation; or the
errors of an order study.

Needs h5py and matplotlib (Debian: python3-h5py python3-matplotlib).
Exit status: 0 drawn, 2 wrong command line, 3 no such species, 5 a file could not be read or written.
"""

import argparse
import csv
import json
import math
import os
import re
import sys

try:
    import h5py
    import matplotlib
    import matplotlib.animation
    import numpy as np
except ImportError as missing:
    # The first python3 on the path is often not Debian's, and only Debian's sees Debian's modules.
    tried = os.environ.get("STIFFRONT_PLOT_TRIED", "").split(":") + [os.path.realpath(sys.executable)]
    os.environ["STIFFRONT_PLOT_TRIED"] = ":".join(tried)
    for folder in ["/usr/bin"] + os.environ.get("PATH", "").split(":"):
        candidate = os.path.join(folder, "python3")
        if os.access(candidate, os.X_OK) and os.path.realpath(candidate) not in tried:
            os.execv(candidate, [candidate, os.path.abspath(sys.argv[0])] + sys.argv[1:])
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


def apart(numbers, distance):
    """Those of increasing numbers that are at least so far from the one kept before."""
    kept = numbers[:1]
    for value in numbers[1:]:
        if value - kept[-1] >= distance:
            kept.append(value)
    return kept


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


def error_scale(case):
    """What the column of errors counts in: (label, value of the tolerance there or None). Multistep methods give errors in units of
    their tolerance."""
    method = case.get("method", {})
    for key in ("relative_tolerance", "tolerance"):
        if isinstance(method.get(key), (int, float)) and method.get("name") in ("sbdf", "cvode", "auto"):
            return f"error estimate / tolerance {method[key]:g}", 1.0
    tolerance = method.get("tolerance")
    return "error estimate", tolerance if isinstance(tolerance, (int, float)) else None


def has_errors(history):
    return "error" in history and bool((np.isfinite(history["error"]) & (history["error"] > 0)).any())


def draw_errors(axes, history, case):
    if not has_errors(history):
        note(axes, "this method estimates no error")
        axes.set_axis_off()
        return
    label, tolerance = error_scale(case)
    draw_attempts(axes, history, "error", label)
    if tolerance is not None:
        axes.axhline(tolerance, color=REFERENCE, linestyle="--", linewidth=1.0,
                     label="tolerance" if label != "error estimate" else f"tolerance {tolerance:g}")
    axes.legend(fontsize="small")


def varies(history, column):
    values = history.get(column)
    return values is not None and np.isfinite(values).any() and np.nanmax(values) > 0


def means(time, values, bins):
    """Means over equal spans of time in which there is something."""
    edges = np.linspace(time[0], time[-1], bins + 1)
    place = np.clip(np.searchsorted(edges, time, side="right") - 1, 0, bins - 1)
    count = np.bincount(place, minlength=bins)
    filled = count > 0
    total = np.bincount(place, weights=values, minlength=bins)
    return 0.5 * (edges[:-1] + edges[1:])[filled], total[filled] / count[filled]


def draw_shift(axes, history):
    """The shift of the embedded splitting, which is chosen so that the critical step stays above the step."""
    good = history["accepted"] & np.isfinite(history["epsilon"])
    axes.step(history["time"][good], history["epsilon"][good], color=ACCEPTED, linewidth=1.0, where="post")
    axes.set_ylim(0, 0.52)
    axes.axhline(0.5, color=REFERENCE, linestyle="--", linewidth=1.0)
    axes.set_xlabel("t")
    axes.set_ylabel("shift ε")
    axes.set_title("shift of the embedded splitting, below 1/2", fontsize="small")


def draw_cost(axes, history, case):
    """Stages, corrections or orders: what an accepted step takes."""
    good = history["accepted"]
    time = history["time"][good]
    name = case.get("method", {}).get("name", "")
    drawn = False
    if varies(history, "iterations"):
        label = "order" if name in ("sbdf", "cvode", "auto") else "corrections"
        axes.step(time, history["iterations"][good], color=ACCEPTED, linewidth=0.9, where="post", label=label)
        drawn = True
    if varies(history, "diffusion_stages"):
        label, at, stages = "diffusion stages", time, history["diffusion_stages"][good]
        if len(stages) > 400:  # estimates of the critical step come every few steps: a line through all would be a band
            at, stages = means(time, stages, 200)
            label += ", mean"
        axes.plot(at, stages, color=REJECTED, linewidth=1.0, linestyle=(0, (4, 1)), label=label)
        drawn = True
    axes.set_xlabel("t")
    axes.set_ylabel("per step")
    if not drawn:
        note(axes, "nothing is counted per step")
        axes.set_axis_off()
        return
    highest = max(np.nanmax(history[c][good]) for c in ("iterations", "diffusion_stages") if varies(history, c))
    if highest > 50:
        axes.set_yscale("symlog", linthresh=10)
    axes.set_ylim(bottom=0)
    axes.set_title("what a step takes", fontsize="small")
    axes.legend(fontsize="small")


def draw_wall_time(axes, history):
    seconds = np.nancumsum(history["wall_seconds"])
    axes.plot(history["time"], seconds, color=ACCEPTED, linewidth=1.2)
    axes.set_xlabel("t")
    axes.set_ylabel("wall time [s]")
    axes.set_ylim(bottom=0)
    axes.set_title(f"{seconds[-1]:.3g} s for {len(seconds)} attempts", fontsize="small")


def draw_rank_work(axes, ranks, imbalance):
    """Seconds of every rank, one bar each."""
    numbers = np.arange(len(ranks))
    bottom = np.zeros(len(ranks))
    for key, label, color in (("diffusion_seconds", "diffusion", ACCEPTED), ("reaction_seconds", "reaction", REJECTED),
                              ("communication_seconds", "communication", "#CCCCCC")):
        seconds = np.array([number(rank.get(key)) for rank in ranks])
        seconds[~np.isfinite(seconds)] = 0.0
        if seconds.any():
            axes.bar(numbers, seconds, bottom=bottom, color=color, label=label)
            bottom += seconds
    axes.set_xlabel("rank")
    axes.set_ylabel("time [s]")
    if len(ranks) <= 16:
        axes.set_xticks(numbers)
    axes.set_title(f"work of each rank, imbalance of the reaction {imbalance:.2f}", fontsize="small")
    axes.margins(y=0.25)
    axes.legend(fontsize="small", ncols=3)


def read_summary(folder):
    try:
        with open(os.path.join(folder, "summary.json")) as file:
            return json.load(file)
    except (OSError, ValueError):
        return {}


def history_panels(history, case, summary):
    """Functions that draw a panel each, in the order they are shown."""
    panels = [lambda axes: draw_step_sizes(axes, history), lambda axes: draw_errors(axes, history, case)]
    if varies(history, "epsilon"):
        panels.append(lambda axes: draw_shift(axes, history))
    if varies(history, "iterations") or varies(history, "diffusion_stages"):
        panels.append(lambda axes: draw_cost(axes, history, case))
    if varies(history, "wall_seconds"):
        panels.append(lambda axes: draw_wall_time(axes, history))
    ranks = summary.get("rank_work", [])
    if len(ranks) > 1 and any(number(rank.get("reaction_seconds")) > 0 for rank in ranks):
        panels.append(lambda axes: draw_rank_work(axes, ranks, number(summary.get("imbalance"))))
    return panels


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
        times = apart([state.time for state in shown], 0.12 * (norm.vmax - norm.vmin))
        bar.set_ticks(times, labels=[f"{time:.3g}" for time in times])
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


class Results:
    """A folder of results: its states, history and summary."""

    def __init__(self, folder, asked):
        if not os.path.isdir(folder):
            raise PlotError(5, f"{folder}: no such folder")
        self.paths = field_files(folder)
        if not self.paths:
            raise PlotError(5, f"{folder}: no results here (fields-NNNNNN.h5)")
        try:
            with h5py.File(self.paths[0], "r") as first:
                known, self.case = species_of(first), case_of(first)
                self.dimension = len(first[known[0]].shape)
                text = first.attrs.get("case", "")
                self.case_text = text.decode() if isinstance(text, bytes) else str(text)
        except (OSError, KeyError, IndexError) as error:
            raise PlotError(5, f"{self.paths[0]}: {error}")
        if self.dimension > 2:
            raise PlotError(5, f"{folder}: {self.dimension}-dimensional results are not drawn here; open fields.xdmf in ParaView")
        self.species = choose_species(known, asked)
        self.history = read_history(os.path.join(folder, "history.csv"))
        self.summary = read_summary(folder)
        self.title = self.case.get("title", "")


def with_unit(label, case):
    """The label of an axis; one that is the name of a quantity gets its unit."""
    quantity = {"y": "x", "step size Δt": "t", "time t": "t"}.get(label, label)
    unit = case.get("model", {}).get("units", {}).get(quantity)
    return f"{label} [{unit}]" if unit else label


def add_units(figure, case):
    for axes in figure.get_axes():
        for get, put in ((axes.get_xlabel, axes.set_xlabel), (axes.get_ylabel, axes.set_ylabel)):
            put(with_unit(get(), case))


def save(figure, target):
    try:
        figure.savefig(target, dpi=150)
    except (OSError, ValueError) as error:
        raise PlotError(5, f"{target}: {error}")


def size_of_fields(results):
    """Width and height in inches of the part of a picture that shows states."""
    if results.dimension == 1:
        return 10.0, 2.6 * len(results.species) + 0.6
    return max(3.0 * min(len(results.paths), MOST_MAPS) + 1.5, 8.0), 2.9 * len(results.species) + 0.6


def draw_fields(figure, results):
    (draw_fields_1d if results.dimension == 1 else draw_fields_2d)(figure, results.paths, results.species)


def draw_history(figure, panels):
    rows = (len(panels) + 1) // 2
    axes = figure.subplots(rows, 2, squeeze=False).ravel()
    for draw_panel, place in zip(panels, axes):
        draw_panel(place)
    for place in axes[len(panels):]:
        place.set_axis_off()


def draw(folder, asked, target):
    results = Results(folder, asked)
    width, field_height = size_of_fields(results)
    panels = history_panels(results.history, results.case, results.summary) if results.history else []
    history_height = 2.8 * ((len(panels) + 1) // 2)
    figure = plt.figure(figsize=(width, field_height + history_height), layout="constrained")
    if panels:
        upper, lower = figure.subfigures(2, 1, height_ratios=[field_height, history_height])
        draw_history(lower, panels)
    else:
        upper = figure
    draw_fields(upper, results)
    if results.title:
        figure.suptitle(results.title)
    add_units(figure, results.case)
    save(figure, target)


def animate(folder, asked, target, most_frames=200, frames_per_second=12):
    """All states, one after the other, on axes that stay: a GIF, or with ffmpeg an MP4."""
    results = Results(folder, asked)
    states = read_states(evenly(results.paths, most_frames), results.species)
    if len(states) < 2:
        raise PlotError(5, f"{folder}: an animation needs two states or more; see [output] every")
    film = target.lower().endswith(".mp4")
    if film and not matplotlib.animation.FFMpegWriter.isAvailable():
        raise PlotError(5, f"{target}: MP4 needs ffmpeg (Debian: apt-get install ffmpeg); without it write a .gif")
    count = len(results.species)
    columns = min(count, 3)
    rows = (count + columns - 1) // columns
    figure = plt.figure(figsize=(4.0 * columns, (3.4 if results.dimension == 2 else 2.8) * rows + 0.4), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False).ravel()
    for place in axes[count:]:
        place.set_axis_off()
    drawn = []
    for place, name in zip(axes, results.species):
        low, high = span([state.values[name] for state in states])
        if results.dimension == 1:
            set_value_axis(place, low, high)
            if not spans_decades(low, high) and high > low:
                place.set_ylim(low - 0.04 * (high - low), high + 0.04 * (high - low))
            place.set_xlabel("x")
            place.set_ylabel(name)
            place.margins(x=0)
            drawn.append(place.plot(states[0].x, states[0].values[name], color=ACCEPTED, linewidth=1.3)[0])
        else:
            image = draw_map(figure, place, states[0], name, Normalize(low, high if high > low else low + (abs(low) or 1.0)))
            place.set_title(name, fontsize="small")
            figure.colorbar(image, ax=place, shrink=0.85)
            drawn.append(image)
    add_units(figure, results.case)
    clock = figure.suptitle("t = 0")

    def show(index):
        state = states[index]
        for artist, name in zip(drawn, results.species):
            if results.dimension == 1:
                artist.set_data(state.x, state.values[name])
            else:
                values = state.values[name]
                step_y, step_x = (max(1, math.ceil(n / MOST_PIXELS)) for n in values.shape)
                artist.set_data(values[::step_y, ::step_x])
        clock.set_text(f"{results.title + ': ' if results.title else ''}t = {state.time:.4g}")
        return drawn

    film_of_states = matplotlib.animation.FuncAnimation(figure, show, frames=len(states), blit=False)
    writer = (matplotlib.animation.FFMpegWriter(fps=frames_per_second, codec="h264", extra_args=["-pix_fmt", "yuv420p", "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2"])
              if film else matplotlib.animation.PillowWriter(fps=frames_per_second))
    try:
        film_of_states.save(target, writer=writer, dpi=80)
    except (OSError, ValueError, RuntimeError) as error:
        raise PlotError(5, f"{target}: {error}")


def draw_own_estimates(axes, rows, color, marker):
    """What dcs says of its own errors, and as a vertical line the step limit its smallest step shows."""
    points = sorted((number(row["step"]), number(row.get("estimate")), number(row.get("step_limit"))) for row in rows if "estimate" in row)
    finite = [point for point in points if math.isfinite(point[1]) and point[1] > 0]
    if finite:
        axes.plot([p[0] for p in finite], [p[1] for p in finite], color=color, marker=marker, markersize=5, markerfacecolor="none",
                  linewidth=0.8, linestyle="--")
    if points and math.isfinite(points[0][2]) and points[0][2] < 10 * points[-1][0]:
        axes.axvline(points[0][2], color=color, linewidth=0.8)


def draw_convergence(folder, target):
    """converge.json: error against step, one line a variant, with the order its last two points show."""
    path = os.path.join(folder, "converge.json")
    try:
        with open(path) as file:
            study = json.load(file)
        rows = study["rows"]
        variants = list(dict.fromkeys(str(row["variant"]) for row in rows))
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise PlotError(5, f"{path}: {error}")
    figure = plt.figure(figsize=(6.5, 4.8), layout="constrained")
    axes = figure.subplots()
    colors = plt.get_cmap("viridis")(np.linspace(0.0, 0.85, max(len(variants), 2)))
    for variant, color, marker in zip(variants, colors, "osD^v<>Ph*" * 5):
        points = sorted((number(row["step"]), number(row["error"])) for row in rows if str(row["variant"]) == variant)
        points = [point for point in points if math.isfinite(point[1]) and point[1] > 0]
        if not points:
            continue
        steps, errors = zip(*points)
        label = variant
        if len(points) > 1:
            order = math.log(errors[1] / errors[0]) / math.log(steps[1] / steps[0])
            label += f", order {order:.2f}"
        axes.plot(steps, errors, color=color, marker=marker, markersize=5, linewidth=1.2, label=label)
        draw_own_estimates(axes, [row for row in rows if str(row["variant"]) == variant], color, marker)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel("step size Δt")
    axes.set_ylabel("relative error, discrete L2")
    axes.grid(True, which="major", color="#DDDDDD", linewidth=0.6)
    axes.set_title(f"{study.get('kind', '')} error; reference: {study.get('reference', '')}", fontsize="small")
    if any("estimate" in row for row in rows):
        axes.plot([], [], color=REFERENCE, marker="o", markerfacecolor="none", linestyle="--", linewidth=0.8, label="estimated by the method")
        axes.plot([], [], color=REFERENCE, linewidth=0.8, label="step from which on a correction improves nothing")
    axes.legend(fontsize="small")
    save(figure, target)


def draw_stability(folder, target):
    """stability.json: where the spectral radius of the amplification matrix is at most one, with its level lines."""
    path = os.path.join(folder, "stability.json")
    try:
        with open(path) as file:
            domain = json.load(file)
        radius = np.array(domain["spectral_radius"], dtype=float)
        (left, right), (bottom, top) = domain["raster"]["alpha"], domain["raster"]["beta"]
        method = domain["method"]
        title = (f"{method['nodes']}, {method['node_count']} nodes, k = {method['starting_order']}, L = {method['corrections']}, "
                 f"{method['final_update']}, {'consistent' if method['consistent'] else 'inconsistent'}; area {domain['area']:.1f}")
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise PlotError(5, f"{path}: {error}")
    rows, columns = radius.shape
    alpha = left + (right - left) * (np.arange(columns) + 0.5) / columns
    beta = bottom + (top - bottom) * (np.arange(rows) + 0.5) / rows
    figure = plt.figure(figsize=(7.2, 5.0), layout="constrained")
    axes = figure.subplots()
    axes.contourf(alpha, beta, radius, levels=[0.0, 1.0 + 1e-8], colors=["#BFD7EA"])
    axes.contour(alpha, beta, radius, levels=[1.0 + 1e-8], colors=["#0B3954"], linewidths=1.4)
    lines = axes.contour(alpha, beta, radius, levels=[0.1, 0.3, 0.5, 0.7, 0.9], colors=["#557A95"], linewidths=0.6)
    axes.clabel(lines, fontsize="x-small")
    axes.set_xlabel("Re z")
    axes.set_ylabel("Im z")
    axes.set_title(title, fontsize="small")
    save(figure, target)


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="stiffront plot", description="Draws the results in an output folder.")
    parser.add_argument("folder", metavar="DIR", help="output folder of a run")
    parser.add_argument("--species", metavar="S", help="draw only these, separated by commas")
    parser.add_argument("-o", "--output", metavar="F", help="picture: .png or .svg (default: DIR/plot.png); or an animation: .gif, .mp4")
    arguments = parser.parse_args(arguments)
    folder = arguments.folder
    is_study = os.path.exists(os.path.join(folder, "converge.json")) and not field_files(folder)
    is_domain = not is_study and os.path.exists(os.path.join(folder, "stability.json")) and not field_files(folder)
    target = arguments.output or os.path.join(folder, "converge.png" if is_study else "stability.png" if is_domain else "plot.png")
    plt.rcParams.update({"svg.fonttype": "none", "axes.grid": False, "font.size": 9})
    try:
        if is_study:
            draw_convergence(folder, target)
        elif is_domain:
            draw_stability(folder, target)
        elif target.lower().endswith((".gif", ".mp4")):
            animate(folder, arguments.species, target)
        else:
            draw(folder, arguments.species, target)
    except PlotError as error:
        print(f"stiffront plot: {error}", file=sys.stderr)
        return error.status
    print(target)
    return 0


if __name__ == "__main__":
    sys.exit(main())
