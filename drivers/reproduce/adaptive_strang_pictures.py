# SPDX-License-Identifier: BSD-3-Clause
"""The pictures of adaptive_strang.py, from the numbers of its items."""
import os

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (the backend must be chosen first)

COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00"]
STRANG = "#222222"


def loglog(axes, x_label, y_label, title):
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel(x_label)
    axes.set_ylabel(y_label)
    axes.set_title(title)
    axes.grid(alpha=0.3)


def save(figure, out, name):
    path = os.path.join(out, name)
    figure.tight_layout()
    figure.savefig(path, dpi=110)
    plt.close(figure)
    return path


def kpp(numbers, out):
    """Figs 1, 2."""
    figure, panels = plt.subplots(1, 3, figsize=(15, 4.8))
    for axes, k in zip(panels, (1, 10, 100)):
        rows = [r for r in numbers["local"] if r["k"] == k]
        dt = [r["dt"] for r in rows]
        axes.plot(dt, [r["strang"] for r in rows], "o-", color=STRANG, label="Strang, against the coupled solver")
        for colour, epsilon in zip(COLOURS, rows[0]["distance"]):
            axes.plot(dt, [r["distance"][epsilon] for r in rows], "s--", color=colour, label=f"estimate, eps = {epsilon}")
        for colour, c in zip(COLOURS, [c for c in numbers["critical"] if c["k"] == k]):
            axes.axvline(c["measured"], color=colour, lw=0.8)
            axes.axvline(c["predicted"], color=colour, lw=0.8, ls=":")
        loglog(axes, "step", "local L2 error", f"KPP, k = {k} (lines: dt*, dotted: predicted)")
    panels[0].legend(fontsize=8)
    return [save(figure, out, "kpp-local-errors.png")]


def bz_local(numbers, out):
    """Figs 3, 4."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.8))
    dt = [r["dt"] for r in numbers]
    left.plot(dt, [r["strang"] for r in numbers], "o-", color=STRANG, label="Strang, against the coupled solver")
    left.plot(dt, [r["distance"] for r in numbers], "s--", color=COLOURS[0], label="estimate, eps = 0.05")
    loglog(left, "step", "local error, worst species", "BZ: local errors")
    left.legend(fontsize=8)
    right.plot(dt, [r["strang"] for r in numbers], "o-", color=STRANG, label="Strang, against the coupled solver")
    right.plot(dt, [r["predicted"] for r in numbers], "d--", color=COLOURS[1], label="Strang, predicted by the two estimators")
    right.plot(dt, [numbers[0]["c0"] * h**3 for h in dt], ":", color=COLOURS[2], label="C0 of the smallest step, dt^3")
    loglog(right, "step", "local error of Strang splitting", "BZ: predicted Strang error")
    right.legend(fontsize=8)
    return [save(figure, out, "bz-local-errors.png")]


def bz_tables(numbers, out):
    """Figs 5, 6: steps without and with the critical step, and the errors of Tables 2, 3."""
    figure, panels = plt.subplots(1, 3, figsize=(15, 4.8))
    for axes, critical in zip(panels, (False, True)):
        for colour, run in zip(COLOURS, [r for r in numbers if r["critical_step"] == critical]):
            time = [h["time"] for h in run["history"]]
            axes.plot(time, [h["dt"] for h in run["history"]], color=colour, label=f"step, eta = {run['eta']:g}")
            if critical:
                axes.plot(time, [h["critical_dt"] for h in run["history"]], ":", color=colour, label=f"dt*, eta = {run['eta']:g}")
        axes.set_yscale("log")
        axes.set_xlabel("time")
        axes.set_ylabel("step")
        axes.set_title("BZ, " + ("with" if critical else "without") + " the critical step")
        axes.grid(alpha=0.3)
        axes.legend(fontsize=8)
    axes = panels[2]
    for colour, critical in zip(COLOURS, (False, True)):
        runs = [r for r in numbers if r["critical_step"] == critical]
        for marker, species in zip("osd", "abc"):
            axes.plot([r["eta"] for r in runs], [r["errors"][species] for r in runs], marker + "--", color=colour,
                      label=f"{species}, {'with' if critical else 'without'} dt*")
    etas = sorted({r["eta"] for r in numbers})
    axes.plot(etas, etas, color=STRANG, lw=0.8, label="eta")
    loglog(axes, "eta", "error at the end", "BZ, Tables 2 and 3")
    axes.legend(fontsize=8)
    return [save(figure, out, "bz-tables-steps.png")]


def discharge(numbers, out):
    """Figs 7, 8."""
    figure, panels = plt.subplots(1, 2, figsize=(11, 4.8), sharey=True)
    for state in numbers["reference"]:
        phase = (state["time"] * 1e6) % 1.0
        ends_pulse = 0.005 < phase < 0.5
        if state["time"] == 0.0 or round(state["time"] * 1e6) in (5, 6):
            continue
        period = int(state["time"] * 1e6 + 1e-6) - (0 if ends_pulse else 1)
        axes = panels[0] if ends_pulse else panels[1]
        axes.plot(state["x"], state["ne"], label=f"period {period}")
    for axes, title in zip(panels, ("end of the pulse", "end of the period")):
        axes.set_yscale("log")
        axes.set_xlabel("x (cm)")
        axes.set_ylabel("electron density (cm^-3)")
        axes.set_title("Discharge, " + title)
        axes.grid(alpha=0.3)
        axes.legend(fontsize=8)
    paths = [save(figure, out, "discharge-densities.png")]

    run = next(r for r in numbers["runs"] if r["critical_step"] and r["eta"] == 1e-3)
    figure, panels = plt.subplots(2, 2, figsize=(12, 8))
    for axes, (low, high, title) in zip(panels.flat, ((0.0, 1e-5, "ten periods"), (3e-6, 4e-6, "the fourth period"),
                                                      (3e-6, 3.01e-6, "its pulse"))):
        for accepted, colour, label in ((1, COLOURS[0], "accepted"), (0, COLOURS[1], "rejected")):
            here = [h for h in run["history"] if low - 1e-13 <= h["time"] <= high and h["accepted"] == accepted]
            axes.plot([h["time"] for h in here], [h["dt"] for h in here], "o", ms=3, color=colour, label=label)
        here = [h for h in run["history"] if low - 1e-13 <= h["time"] <= high and h["critical_dt"] < 1e-5]
        axes.plot([h["time"] for h in here], [h["critical_dt"] for h in here], ".", ms=2, color=COLOURS[2], label="dt*")
        axes.set_yscale("log")
        axes.set_xlabel("time (s)")
        axes.set_ylabel("step (s)")
        axes.set_title(f"Discharge, eta = 1e-3: {title}")
        axes.grid(alpha=0.3)
        axes.legend(fontsize=8)
    axes = panels[1, 1]
    for colour, critical in zip(COLOURS, (False, True)):
        for marker, r in zip("osd", [r for r in numbers["runs"] if r["critical_step"] == critical]):
            axes.plot([s["time"] for s in numbers["reference"][1:]], r["errors"], marker + "--", color=colour,
                      label=f"eta = {r['eta']:g}, {'full strategy' if critical else 'eps = 0.05'}")
    axes.set_yscale("log")
    axes.set_xlabel("time (s)")
    axes.set_ylabel("error, L2/L2, worst species")
    axes.set_title("Discharge: errors at ends of pulses and periods")
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8)
    paths.append(save(figure, out, "discharge-steps.png"))
    return paths


def variants(numbers, out):
    """Errors at the end in tolerances, kept and not kept."""
    names = list(dict.fromkeys(r["variant"] for r in numbers))
    figure, axes = plt.subplots(figsize=(9, 0.32 * len(names) + 1.8))
    for marker, eta in zip("osd", sorted({r["eta"] for r in numbers}, reverse=True)):
        rows = [r for r in numbers if r["eta"] == eta]
        where = [names.index(r["variant"]) for r in rows]
        axes.plot([r["kept"] for r in rows], where, marker, color=COLOURS[0], ms=5, label=f"eta = {eta:g}")
        axes.plot([r["free"] for r in rows], where, marker, mfc="none", mec=COLOURS[1], ms=5, label=f"eta = {eta:g}, final_error = 0")
    axes.axvline(5.0, color=STRANG, lw=0.8)
    axes.set_xscale("log")
    axes.set_yticks(range(len(names)), names, fontsize=8)
    axes.invert_yaxis()
    axes.set_xlabel("error at the end / eta (line: 5)")
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5))
    return [save(figure, out, "variants-errors.png")]


def draw(item, numbers, out):
    """Draws one item. Returns the paths of the pictures."""
    return {"kpp": kpp, "bz-local": bz_local, "bz-tables": bz_tables, "discharge": discharge, "variants": variants}[item](numbers, out)
