#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Writes one HTML file about a run: what it was, what its numbers mean, its pictures, its tables, and a plot of its steps to look into.
The file needs nothing else: no network, no other file.

Needs h5py and matplotlib, as plot.py does. Exit status: 0 written, 2 wrong command line, 5 a file could not be read or written.
"""

import argparse
import base64
import html
import importlib.util
import io
import json
import math
import os
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
specification = importlib.util.spec_from_file_location("stiffront_plot", os.path.join(HERE, "plot.py"))
plot = importlib.util.module_from_spec(specification)
specification.loader.exec_module(plot)
np = plot.np

MOST_STEPS = 4000  # shown; of more, the extremes in equal groups, and every rejected attempt
LARGEST_ANIMATION = 6 << 20

COLUMNS = {  # of history.csv, in words
    "dt": "step size Δt",
    "error": "error estimate",
    "critical_dt": "critical step Δt⋆",
    "epsilon": "shift ε",
    "iterations": "corrections or order",
    "diffusion_stages": "diffusion stages",
    "reaction_steps": "reaction steps, all cells",
    "wall_seconds": "wall time of the attempt [s]",
}


def text(value):
    return html.escape(str(value))


def count(value):
    return f"{value:,}".replace(",", " ") if isinstance(value, int) else text(value)


def seconds(value):
    return f"{value:.3g} s" if isinstance(value, (int, float)) else text(value)


def table(rows, head=None):
    lines = ["<table>"]
    if head:
        lines.append("<tr>" + "".join(f"<th>{text(cell)}</th>" for cell in head) + "</tr>")
    lines += ["<tr>" + "".join(f"<td>{cell}</td>" for cell in row) + "</tr>" for row in rows]
    return "\n".join(lines + ["</table>"])


def picture(figure, words):
    data = io.BytesIO()
    figure.savefig(data, format="png", dpi=110)
    plot.plt.close(figure)
    encoded = base64.b64encode(data.getvalue()).decode()
    return f'<figure><img alt="{text(words)}" src="data:image/png;base64,{encoded}"><figcaption>{text(words)}</figcaption></figure>'


def fields_picture(results):
    figure = plot.plt.figure(figsize=plot.size_of_fields(results), layout="constrained")
    plot.draw_fields(figure, results)
    plot.add_units(figure, results.case)
    words = "Profiles, and profiles stacked in time" if results.dimension == 1 else "Maps at several times"
    return picture(figure, words)


def history_picture(results):
    panels = plot.history_panels(results.history, results.case, results.summary)
    figure = plot.plt.figure(figsize=(10.0, 2.8 * ((len(panels) + 1) // 2)), layout="constrained")
    plot.draw_history(figure, panels)
    plot.add_units(figure, results.case)
    return picture(figure, "Step sizes, errors and costs")


def animation(results, folder):
    """A GIF of all states; nothing for fewer than three, or if it would be too large to be sent around."""
    if len(results.paths) < 3:
        return ""
    with tempfile.TemporaryDirectory() as scratch:
        target = os.path.join(scratch, "animation.gif")
        plot.animate(folder, ",".join(results.species[:3]), target, most_frames=60)
        if os.path.getsize(target) > LARGEST_ANIMATION:
            return ""
        with open(target, "rb") as file:
            encoded = base64.b64encode(file.read()).decode()
    return f'<figure><img alt="animation" src="data:image/gif;base64,{encoded}"><figcaption>All states, one after the other</figcaption></figure>'


def chosen_steps(history):
    """Indices of the attempts to show: all, or of equal groups those with the least and the largest step and error, and all rejected."""
    n = len(history["time"])
    if n <= MOST_STEPS:
        return list(range(n))
    chosen = set(np.flatnonzero(~history["accepted"])[:MOST_STEPS].tolist()) | {0, n - 1}
    for group in np.array_split(np.arange(n), MOST_STEPS // 4):
        for column in ("dt", "error"):
            values = history[column][group] if column in history else np.full(len(group), math.nan)
            if np.isfinite(values).any():
                chosen |= {int(group[np.nanargmin(values)]), int(group[np.nanargmax(values)])}
    return sorted(chosen)


def steps_as_json(history, case):
    index = chosen_steps(history)
    data = {"accepted": [bool(history["accepted"][i]) for i in index], "attempt": index}
    for column in ["time", *COLUMNS]:
        if column in history and (column == "time" or plot.varies(history, column)):
            data[column] = [float(f"{history[column][i]:.6g}") if math.isfinite(history[column][i]) else None for i in index]
    labels = {column: plot.with_unit(label, case) for column, label in COLUMNS.items() if column in data}
    # A unit must not end the script element.
    return json.dumps({"time": plot.with_unit("time t", case), "columns": labels, "data": data, "total": len(history["time"])}, separators=(",", ":"),
                      allow_nan=False).replace("<", "\\u003c")


def key_facts(results):
    s = results.summary
    grid = s.get("grid", {})
    steps = s.get("steps", {})
    wall = s.get("wall_seconds", {})
    facts = [("status", s.get("status", "unknown")), ("model", s.get("model", "")), ("method", s.get("method", "")),
             ("grid", " × ".join(str(n) for n in grid.get("points", []))), ("time reached", f"{plot.number(s.get('time')):.6g}"),
             ("steps", f"{count(steps.get('accepted', 0))} accepted, {count(steps.get('rejected', 0))} rejected"),
             ("wall time", seconds(plot.number(wall.get("total")) + max(0.0, plot.number(wall.get("output"))))),
             ("processes", s.get("ranks", "")), ("peak memory", f"{plot.number(s.get('peak_memory_mib')):.0f} MiB a process"),
             ("checksum of the final state", s.get("checksum", ""))]
    return '<dl class="facts">' + "".join(f"<div><dt>{text(k)}</dt><dd>{text(v)}</dd></div>" for k, v in facts) + "</dl>"


def bars(seconds_of):
    shown = [(k, v) for k, v in seconds_of.items() if k != "total" and isinstance(v, (int, float)) and v > 0]
    largest = max((v for _, v in shown), default=0.0)
    rows = [(text(k), f'<span class="bar" style="width:{200 * v / largest:.0f}px"></span>', f"{v:.3g} s") for k, v in shown]
    rows.append(("total without output", "", seconds(seconds_of.get("total"))))
    return table(rows)


def tables(results):
    s = results.summary
    parts = ["<h3>Wall time of the slowest process</h3>", bars(s.get("wall_seconds", {})), "<h3>Work, all processes</h3>",
             table([(text(k.replace("_", " ")), count(v)) for k, v in s.get("work", {}).items() if v])]
    ranks = s.get("rank_work", [])
    if len(ranks) > 1:
        rows = [(i, count(r.get("reaction_newton_iterations", 0)), seconds(r.get("diffusion_seconds")), seconds(r.get("reaction_seconds")),
                 seconds(r.get("communication_seconds"))) for i, r in enumerate(ranks)]
        parts += ["<h3>Each process</h3>", table(rows, ["rank", "Newton iterations", "diffusion", "reaction", "communication"])]
    parts += ["<h3>Made by</h3>", table([(k, text(s[k])) for k in ("version", "git_hash", "compiler", "flags") if k in s])]
    return "\n".join(parts)


def advice(results):
    s = results.summary
    lines = [s[k] for k in ("reason", "note") if s.get(k)] + list(s.get("advice", []))
    return "<ul>" + "".join(f"<li>{text(line)}</li>" for line in lines) + "</ul>" if lines else "<p>Nothing stands out.</p>"


def report(folder, asked):
    results = plot.Results(folder, asked)
    title = results.title or os.path.basename(os.path.abspath(folder))
    parts = [f"<h1>{text(title)}</h1>", key_facts(results), "<h2>What the numbers mean</h2>", advice(results), "<h2>Solution</h2>",
             fields_picture(results), animation(results, folder)]
    script = ""
    if results.history:
        parts += ["<h2>Steps</h2>", '<div id="steps"><noscript>The plot of the steps needs JavaScript.</noscript></div>', history_picture(results)]
        with open(os.path.join(HERE, "report.js")) as file:
            script = f'<script type="application/json" id="history">{steps_as_json(results.history, results.case)}</script>\n<script>\n{file.read()}</script>'
    parts += ["<h2>Account</h2>", tables(results), "<h2>The case</h2>",
              f"<details open><summary>every entry, defaults included</summary><pre>{text(results.case_text)}</pre></details>"]
    with open(os.path.join(HERE, "report.css")) as file:
        style = file.read()
    body = "\n".join(parts)
    return (f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n<meta name="viewport" content="width=device-width">\n'
            f"<title>{text(title)}</title>\n<style>\n{style}</style>\n</head>\n<body>\n<main>\n{body}\n</main>\n{script}\n</body>\n</html>\n")


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="stiffront report", description="Writes one HTML file about the run in an output folder.")
    parser.add_argument("folder", metavar="DIR", help="output folder of a run")
    parser.add_argument("--species", metavar="S", help="show only these, separated by commas")
    parser.add_argument("-o", "--output", metavar="F", help="file to write (default: DIR/report.html)")
    arguments = parser.parse_args(arguments)
    target = arguments.output or os.path.join(arguments.folder, "report.html")
    plot.plt.rcParams.update({"axes.grid": False, "font.size": 9})
    try:
        page = report(arguments.folder, arguments.species)
        with open(target, "w", encoding="utf-8") as file:
            file.write(page)
    except plot.PlotError as error:
        print(f"stiffront report: {error}", file=sys.stderr)
        return error.status
    except OSError as error:
        print(f"stiffront report: {error}", file=sys.stderr)
        return 5
    print(target)
    return 0


if __name__ == "__main__":
    sys.exit(main())
