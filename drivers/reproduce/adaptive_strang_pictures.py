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


def over_time(axes, title, y_label):
    axes.set_yscale("log")
    axes.set_xlabel("time")
    axes.set_ylabel(y_label)
    axes.set_title(title)
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8)


def bz_tables(numbers, out):
    """Figs 5, 6: steps and estimated errors without and with the critical step; the errors of Tables 2, 3."""
    figure, panels = plt.subplots(2, 3, figsize=(15, 9))
    for row, kind, title in zip(panels, ("Table 2", "Table 3"), ("without", "with")):
        for colour, run in zip(COLOURS, [r for r in numbers if r["kind"] == kind]):
            time = [h["time"] for h in run["history"]]
            row[0].plot(time, [h["dt"] for h in run["history"]], color=colour, label=f"step, eta = {run['eta']:g}")
            if kind == "Table 3":
                row[0].plot(time, [h["critical_dt"] for h in run["history"]], ":", color=colour, label=f"dt*, eta = {run['eta']:g}")
            row[1].plot(time, [h["error"] for h in run["history"]], color=colour, label=f"estimate, eta = {run['eta']:g}")
            row[1].axhline(run["eta"], color=colour, lw=0.8, ls=":")
        over_time(row[0], f"BZ, {title} the critical step", "step")
        over_time(row[1], f"BZ, {title} the critical step; dotted: eta", "estimated local error")
    etas = sorted({r["eta"] for r in numbers})
    for axes, kinds, title in ((panels[0][2], ("Table 2", "Table 3"), "BZ, Tables 2 and 3"),
                               (panels[1][2], ("Table 3", "default"), "BZ, with the limit for the error at the end")):
        for colour, kind in zip(COLOURS, kinds):
            runs = [r for r in numbers if r["kind"] == kind]
            for marker, species in zip("osd", "abc"):
                axes.plot([r["eta"] for r in runs], [r["errors"][species] for r in runs], marker + "--", color=colour, mfc="none",
                          label=f"{species}, {kind}")
        axes.plot(etas, etas, color=STRANG, lw=0.8, label="eta")
        loglog(axes, "eta", "error at the end", title)
        axes.legend(fontsize=8)
    return [save(figure, out, "bz-tables-steps.png")]


def discharge(numbers, out):
    """Figs 7, 8."""
    figure, panels = plt.subplots(1, 2, figsize=(11, 4.8), sharey=True)
    for state in numbers["reference"]:
        after = 0.005 < (state["time"] * 1e6) % 1.0 < 0.5
        panels[1 if after else 0].plot(state["x"], state["ne"], label=f"{state['time'] * 1e6:.4g} us")
    for axes, title in zip(panels, ("before pulses", "after pulses")):
        axes.set_yscale("log")
        axes.set_xlabel("x (cm)")
        axes.set_ylabel("electron density (cm^-3)")
        axes.set_title("Discharge, " + title)
        axes.grid(alpha=0.3)
        axes.legend(fontsize=8)
    paths = [save(figure, out, "discharge-densities.png")]

    run = next(r for r in numbers["runs"] if r["kind"] == "full strategy" and r["eta"] == 1e-3)
    figure, panels = plt.subplots(2, 2, figsize=(12, 8))
    for axes, (low, high, title) in zip(panels.flat, ((0.0, 10.0, "ten periods"), (5.0, 5.01, "a pulse"), (5.01, 6.0, "after it"))):
        for accepted, colour, label in ((1, COLOURS[0], "accepted"), (0, COLOURS[1], "rejected")):
            here = [h for h in run["history"] if low - 1e-7 <= h["time"] * 1e6 < high - 1e-7 and h["accepted"] == accepted]
            axes.plot([h["time"] * 1e6 for h in here], [h["dt"] for h in here], "o", ms=3, color=colour, label=label)
        here = [h for h in run["history"] if low - 1e-7 <= h["time"] * 1e6 < high - 1e-7 and h["critical_dt"] < 1e-5]
        axes.plot([h["time"] * 1e6 for h in here], [h["critical_dt"] for h in here], ".", ms=2, color=COLOURS[2], label="dt*")
        over_time(axes, f"Discharge, eta = 1e-3: {title}", "step (s)")
        axes.set_xlabel("time (us)")
    axes = panels[1, 1]
    times = [s["time"] * 1e6 for s in numbers["reference"][1:]]
    for colour, kind in zip(COLOURS, ("eps = 0.05", "full strategy", "default")):
        runs = [r for r in numbers["runs"] if r["kind"] == kind]
        for style, time in (("o-", 5.01), ("s--", 6.0)):
            at = min(range(len(times)), key=lambda i, t=time: abs(times[i] - t))
            axes.plot([r["eta"] for r in runs], [r["errors"][at] for r in runs], style, color=colour, label=f"{kind}, {time} us")
    loglog(axes, "eta", "error, L2/L2, worst species", "Discharge: errors after and before a pulse")
    axes.legend(fontsize=8)
    paths.append(save(figure, out, "discharge-steps.png"))
    return paths


def variants(numbers, out):
    """Errors at the end in tolerances, kept and not kept."""
    names = list(dict.fromkeys(r["variant"] for r in numbers))
    figure, axes = plt.subplots(figsize=(9, 0.32 * len(names) + 1.8))
    for marker, eta in zip("osd^", sorted({r["eta"] for r in numbers}, reverse=True)):
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
