#!/usr/bin/python3
"""Draws the rows of study_error.py: error against run time, log-log, a panel for each scene, the Pareto front marked.

A run is on the front when none is both faster and more exact. Iterations are written at the points.
"""

import argparse
import csv
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

COLOURS = {"report's Jacobi": "#D55E00", "plain Jacobi": "#E69F00", "Jacobi 0.5, walls": "#CC79A7",
           "Chebyshev alone": "#56B4E9", "Anderson": "#009E73", "default": "#0072B2",
           "default, Spiky": "#000000"}
TITLES = {"cube": "falling cube", "column": "column of 40 layers", "dam_break": "dam break", "fountain": "fountain"}
LEAST = 1e-7  # smaller errors are drawn here


def read(path):
    with open(path, newline="", encoding="utf-8") as stream:
        return [row | {"time": float(row["wall_seconds"]), "error": max(float(row["compression_mean"]), LEAST)}
                for row in csv.DictReader(stream)]


def pareto(rows):
    front = []
    for row in sorted(rows, key=lambda row: (row["time"], row["error"])):
        if not front or row["error"] < front[-1]["error"]:
            front.append(row)
    return front


def draw(panel, rows):
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
    panel.set(xscale="log", yscale="log", title=TITLES[rows[0]["scene"]])
    panel.grid(which="major", color="0.9", linewidth=0.6)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("rows", type=Path, help="CSV file of study_error.py")
    parser.add_argument("output", type=Path, help="PNG file to write")
    arguments = parser.parse_args()
    rows = read(arguments.rows)
    scenes = [scene for scene in TITLES if any(row["scene"] == scene for row in rows)]
    plt.rcParams.update({"font.size": 9, "axes.spines.top": False, "axes.spines.right": False})
    figure, panels = plt.subplots(2, 2, figsize=(9, 7.2), layout="constrained")
    for panel, scene in zip(panels.flat, scenes):
        draw(panel, [row for row in rows if row["scene"] == scene])
    for panel in panels.flat[len(scenes):]:
        panel.set_axis_off()
    for panel in panels[-1]:
        panel.set_xlabel("run time (s)")
    figure.supylabel("mean compression")
    figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="lower center", ncol=4, frameon=False)
    figure.get_layout_engine().set(rect=(0, 0.09, 1, 1 - 0.09))
    figure.savefig(arguments.output, dpi=110)
    print(arguments.output)
    return 0


if __name__ == "__main__":
    sys.exit(main())
