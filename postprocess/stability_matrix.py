#!/usr/bin/python3
"""Draws the verdicts of study_stability.py: a row for each group of cases, a coloured field for each case and preset."""

import argparse
import csv
import sys
from collections import Counter
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
from matplotlib.patches import Patch, Rectangle  # noqa: E402

COLOURS = {"stable": "#7FBF7B", "dissipative": "#F0E442", "energy gain": "#E69F00", "blow-up": "#C0392B",
           "refused": "#BBBBBB"}

TITLES = {"report": "the report's preset", "default": "default", "poly6": "fluid.density_kernel = \"poly6\""}


def read(path):
    with open(path, newline="", encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


def draw(panel, rows, groups, widest):
    for y, group in enumerate(groups):
        for x, row in enumerate(row for row in rows if row["group"] == group):
            panel.add_patch(Rectangle((x, y), 0.96, 0.9, color=COLOURS[row["verdict"]]))
            panel.text(x + 0.48, y + 0.47, row["case"], ha="center", va="center", fontsize=6.5)
    panel.set(xlim=(0, widest), ylim=(len(groups), 0), xticks=[])
    panel.set_yticks([y + 0.45 for y in range(len(groups))], groups)
    for side in panel.spines.values():
        side.set_visible(False)
    panel.tick_params(length=0)


def max_cases(rows):
    """In a group, of one preset."""
    return max(Counter((row["group"], row["preset"]) for row in rows).values())


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("rows", type=Path, help="CSV file of study_stability.py")
    parser.add_argument("output", type=Path, help="PNG file to write")
    arguments = parser.parse_args()
    rows = read(arguments.rows)
    groups = list(dict.fromkeys(row["group"] for row in rows))
    widest = max_cases(rows)
    size = (2.2 + len(TITLES) * 0.62 * widest, 1 + 0.26 * len(groups))
    figure, panels = plt.subplots(1, len(TITLES), figsize=size, sharey=True, layout="constrained")
    for panel, (preset, title) in zip(panels, TITLES.items()):
        draw(panel, [row for row in rows if row["preset"] == preset], groups, widest)
        panel.set_title(title)
    figure.legend(handles=[Patch(color=colour, label=name) for name, colour in COLOURS.items()],
                  loc="lower center", ncol=5, frameon=False)
    figure.get_layout_engine().set(rect=(0, 0.4 / size[1], 1, 1 - 0.4 / size[1]))
    figure.savefig(arguments.output, dpi=110)
    print(arguments.output)
    return 0


if __name__ == "__main__":
    sys.exit(main())
