#!/usr/bin/python3
"""Draws the rows of study_error.py: errors against the time of the processor, start and output included, log-log, a
panel for each error, the Pareto front marked.

A run is on the front when none is both faster and more exact. Iterations are written at the points. Errors below a
panel's least or above its most are drawn there.
"""

import argparse
import csv
import math
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

COLOURS = {"report's Jacobi": "#D55E00", "plain Jacobi": "#E69F00", "Jacobi 0.5, walls": "#CC79A7",
           "Chebyshev alone": "#56B4E9", "Anderson": "#009E73", "default": "#0072B2",
           "default, Poly6": "#000000", "default, Wendland": "#999999"}
MOST = 100.0
# Scene, column, what is exact, title, least error drawn.
PANELS = (
    ("cube", "compression_mean", 0, "falling cube: mean compression", 1e-7),
    ("column", "compression_mean", 0, "column of 40 layers: mean compression", 1e-7),
    ("dam_break", "compression_mean", 0, "dam break: mean compression", 1e-7),
    ("fountain", "compression_mean", 0, "fountain: mean compression", 1e-7),
    ("wave", "period_ratio", 1, "wave: error of its period", 1e-4),
    ("wave", "loss_per_half", 0, "wave: lost per half-period", 1e-3),
    ("wave", "tilt_left", 0, "wave: tilt left standing", 1e-4),
    ("wave", "energy_gain", 0, "wave: energy gain", 1e-5),
    ("pool", "rest_kinetic_per_mass", 0, "pool at rest: KE/m (m²/s²)", 1e-7),
    ("pool", "rest_com_error", 0, "pool at rest: centre of mass", 1e-5),
    ("pool", "later_gain", 0, "pool at rest: energy gain after 1 s", 1e-5),
    ("jets", "momentum_error", 0, "jets: momentum", 1e-17),
)


def read(path):
    with open(path, newline="", encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


def errors(rows, column, exact, least):
    """The rows that have this error, with it and their time as numbers. What is no number, as the period of a wave that
    never swings back, is as wrong as can be drawn."""
    found = []
    for row in rows:
        if row[column] != "":
            error = abs(float(row[column]) - exact)
            error = MOST if math.isnan(error) else min(max(error, least), MOST)
            found.append(row | {"time": float(row["cpu_seconds"]), "error": error})
    return found


def pareto(rows):
    front = []
    for row in sorted(rows, key=lambda row: (row["time"], row["error"])):
        if not front or row["error"] < front[-1]["error"]:
            front.append(row)
    return front


def draw(panel, rows, title):
    for name, colour in COLOURS.items():
        line = sorted((row for row in rows if row["method"] == name), key=lambda row: int(row["iterations"]))
        panel.plot([row["time"] for row in line], [row["error"] for row in line], "o-", color=colour, markersize=4,
                   linewidth=1, label=name)
        for row in line:
            panel.annotate(row["iterations"], (row["time"], row["error"]), textcoords="offset points", xytext=(4, 3),
                           fontsize=7, color=colour)
    others = [row for row in rows if row["method"] not in COLOURS]
    panel.plot([row["time"] for row in others], [row["error"] for row in others], "x", color="0.45", markersize=5,
               label="default, one factor changed")
    front = pareto(rows)
    panel.plot([row["time"] for row in front], [row["error"] for row in front], "s", markersize=9, markerfacecolor="none",
               markeredgecolor="black", label="Pareto front")
    panel.set(xscale="log", yscale="log", title=title)
    panel.grid(which="major", color="0.9", linewidth=0.6)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("rows", type=Path, help="CSV file of study_error.py")
    parser.add_argument("output", type=Path, help="PNG file to write")
    arguments = parser.parse_args()
    rows = read(arguments.rows)
    panels = [panel for panel in PANELS if any(row["scene"] == panel[0] for row in rows)]
    lines = math.ceil(len(panels) / 4)
    plt.rcParams.update({"font.size": 9, "axes.spines.top": False, "axes.spines.right": False})
    size = (17, 1 + 3.6 * lines)
    figure, axes = plt.subplots(lines, 4, figsize=size, layout="constrained", squeeze=False)
    for axis in axes.flat[len(panels):]:
        axis.set_axis_off()
    for axis, (scene, column, exact, title, least) in zip(axes.flat, panels):
        draw(axis, errors([row for row in rows if row["scene"] == scene], column, exact, least), title)
    for axis in axes[-1]:
        axis.set_xlabel("time of the processor (s)")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="lower center", ncol=9, frameon=False)
    figure.get_layout_engine().set(rect=(0, 0.5 / size[1], 1, 1 - 0.5 / size[1]))
    figure.savefig(arguments.output, dpi=110)
    print(arguments.output)
    return 0


if __name__ == "__main__":
    sys.exit(main())
