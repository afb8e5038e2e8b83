#!/usr/bin/python3
"""Draws the rows of study_water.py: periods, losses, rest and energy over depth, motion over time step and viscosity.

Grey lines are the marks. Figures below a panel's lower end are drawn at it.
"""

import argparse
import csv
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

COLOURS = {1.5: "#CC79A7", 2: "#0072B2", 2.5: "#009E73", 3: "#E69F00", 4: "#D55E00"}  # by kernel radius over spacing
STYLES = {"pools": "o-", "pools, disturbed": "x--", "wells": "s", "wells, disturbed": "D"}
MARKERS = {1: "o", 0.5: "s", 0.25: "^"}  # by amplitude, spacings
LEAST_MOTION, LEAST_GAIN, LEAST_OFF = 1e-8, 1e-5, 1e-2
STANDARD = 60  # steps per second


def read(path):
    with open(path, newline="", encoding="utf-8") as stream:
        return [{name: number(value) for name, value in row.items()} for row in csv.DictReader(stream)]


def number(text):
    try:
        return float(text)
    except ValueError:
        return text


def series(panel, rows, x, y, least=None, **style):
    """A line through the rows that have the figure y."""
    points = sorted((row[x], abs(row[y]) if least else row[y]) for row in rows if isinstance(row[y], float))
    if points:
        panel.plot([p[0] for p in points], [max(p[1], least) if least else p[1] for p in points],
                   style.pop("format", "o-"), markersize=4, linewidth=1, **style)


def of(rows, **wanted):
    return [row for row in rows if all(row[name] == value for name, value in wanted.items())]


def waves(panel, rows, figure, title, marks):
    factor = 1 if figure == "period_ratio" else 100  # the others in %
    rows = [row | {figure: factor * row[figure]} for row in of(rows, group="waves") if isinstance(row[figure], float)]
    plain = [row for row in of(rows, steps_per_second=STANDARD, length=4)]
    for ratio, colour in COLOURS.items():
        for amplitude, marker in MARKERS.items():
            series(panel, of(plain, ratio=ratio, amplitude=amplitude), "layers", figure, format=f"{marker}-", color=colour,
                   label=f"h {ratio:g}, A {amplitude:g}")
    others = [row for row in rows if row not in plain]
    series(panel, others, "layers", figure, format="+", color="0.3", label="other tanks, time steps")
    for values in marks:
        panel.plot(*values, color="0.6", linewidth=4, alpha=0.5, zorder=0)
    panel.set(xscale="log", xlim=(4, 50), xlabel="layers", title=title)
    panel.set_xticks([5, 10, 20, 40], ["5", "10", "20", "40"], minor=False)
    panel.set_xticks([], minor=True)


def depths(panel, rows, figure, title, bounds):
    """bounds: the least figure drawn, and the mark."""
    least, mark = bounds
    for group, style in STYLES.items():
        for ratio, colour in COLOURS.items():
            chosen = of(rows, group=group, ratio=ratio, steps_per_second=STANDARD)
            series(panel, chosen, "layers", figure, least, format=style, color=colour,
                   label=f"{group}, h {ratio:g}")
    panel.axhline(mark, color="0.6", linewidth=4, alpha=0.5, zorder=0)
    panel.set(xscale="log", yscale="log", xlabel="layers", title=title)


def time_steps(panel, rows):
    colours = {5: "#D55E00", 9: "#E69F00", 10: "#0072B2"}
    for group in ("pools", "pools, disturbed"):
        for layers, colour in colours.items():
            chosen = of(rows, group=group, ratio=2, layers=layers, length=1.0)
            series(panel, chosen, "steps_per_second", "kinetic_per_mass", LEAST_MOTION, format=STYLES[group], color=colour,
                   label=f"{group}, {layers} layers")
    panel.axhline(1e-3, color="0.6", linewidth=4, alpha=0.5, zorder=0)
    panel.set(xscale="log", yscale="log", xlabel="steps per second", title="motion at rest, KE/m (m²/s²)")


def viscosity(panel, rows):
    rows = of(rows, group="viscosity")
    for rate, colour in ((60, "#0072B2"), (240, "#56B4E9")):
        chosen = [row for row in of(rows, steps_per_second=rate) if row["amplitude"] == ""]
        series(panel, chosen, "nu", "kinetic_per_mass", LEAST_MOTION, color=colour, label=f"KE/m of a pool, 1/{rate} s")
    lossy = [row for row in rows if isinstance(row["loss_per_half"], float)]
    series(panel, lossy, "nu", "loss_per_half", LEAST_MOTION, color="#D55E00", label="share of a wave lost per half-period")
    panel.axhline(1e-5, color="#0072B2", linewidth=4, alpha=0.3, zorder=0)
    panel.axhline(0.15, color="#D55E00", linewidth=4, alpha=0.3, zorder=0)
    panel.set_xscale("symlog", linthresh=3e-4)
    panel.set(yscale="log", xlim=(-5e-5, 2e-2), xlabel="nu (m²/s)", title="10 layers with viscosity")
    panel.set_xticks([0, 1e-3, 1e-2], ["0", "0.001", "0.01"])


def legend(panel, columns):
    handles = dict(zip(*reversed(panel.get_legend_handles_labels())))
    panel.legend(handles.values(), handles, fontsize=6, ncol=columns, framealpha=0.8)


def draw(rows, path):
    plt.rcParams.update({"font.size": 9, "axes.spines.top": False, "axes.spines.right": False})
    figure, panels = plt.subplots(2, 4, figsize=(17, 8), layout="constrained")
    (period, loss, left, rest), (steps, off, gain, calm) = panels
    waves(period, rows, "period_ratio", "half-period / linear theory", [((4, 50), (0.98, 0.98)), ((4, 50), (1.02, 1.02))])
    waves(loss, rows, "loss_per_half", "lost per half-period (%)", [((10, 40, 40, 50), (10, 10, 5, 5))])
    waves(left, rows, "tilt_left", "tilt left standing (% of the first swing)", [((4, 50), (2, 2))])
    depths(rest, rows, "kinetic_per_mass", "motion at rest, KE/m (m²/s²)", (LEAST_MOTION, 1e-3))
    depths(gain, rows, "energy_gain", "energy gain from the start (share)", (LEAST_GAIN, 1e-3))
    depths(off, rows, "com_error_spacings", "centre of mass off (spacings)", (LEAST_OFF, 0.1))
    time_steps(steps, rows)
    viscosity(calm, rows)
    for panel in panels.flat:
        panel.grid(which="major", color="0.9", linewidth=0.6)
        legend(panel, 2 if panel not in (steps, calm) else 1)
    figure.savefig(path, dpi=110)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("rows", type=Path, help="CSV file of study_water.py")
    parser.add_argument("output", type=Path, help="PNG file to write")
    arguments = parser.parse_args()
    draw(read(arguments.rows), arguments.output)
    print(arguments.output)
    return 0


if __name__ == "__main__":
    sys.exit(main())
