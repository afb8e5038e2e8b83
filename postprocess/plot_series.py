#!/usr/bin/python3
"""Draws the mean density of one or several runs against the frame, as Fig. 2 and Fig. 6 of the report do.

The rest density is the dashed line; the density of interior particles alone, where no free surface pulls the mean down,
is the second curve. With --energy a second panel shows kinetic, potential and total energy. Several runs are compared
in one drawing, each in its own colour.
"""

import argparse
import math
import re
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
from matplotlib.lines import Line2D  # noqa: E402

from trevi_run import RunError, Table  # noqa: E402

COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000"]  # Okabe and Ito
LINES = {
    "rest density": {"color": "0.35", "linestyle": "--", "linewidth": 1},
    "mean": {"linewidth": 1.5},
    "interior only": {"linewidth": 1, "alpha": 0.55},
    "total": {"linewidth": 1.2},
    "kinetic": {"linewidth": 1.2, "linestyle": "--"},
    "potential": {"linewidth": 1.2, "linestyle": ":"},
}
DENSITIES, ENERGIES = list(LINES)[:3], list(LINES)[3:]


class BadInput(Exception):
    pass


def read_series(path):
    """Columns of a series.csv by name."""
    file = path / "series.csv" if path.is_dir() else path
    try:
        columns = Table(file)
    except RunError as error:
        raise BadInput(f"{error}; a curve needs a run whose scene has [output.series]") from error
    if not {"step", "density_mean"} <= set(columns):
        raise BadInput(f"{file}: has no columns step and density_mean")
    if len(columns["step"]) < 2:
        raise BadInput(f"{file}: {len(columns['step'])} row(s); a curve needs at least two steps")
    if not has_values(columns, "density_mean"):
        raise BadInput(f"{file}: density_mean holds no number, only nan")
    return columns


def has_values(columns, name):
    return any(math.isfinite(value) for value in columns.get(name, ()))


def rest_density_of(scene):
    """rest_density of a scene file; the default of the solver where it is absent. Any Python 3, so without tomllib."""
    match = re.search(r"^\s*rest_density\s*=\s*([0-9.eE+]+)", scene.read_text(encoding="utf-8"), re.M)
    return float(match[1]) if match else 1000.0


def coloured(runs):
    return [(name, columns, colour) for (name, columns), colour in zip(runs.items(), COLOURS * len(runs))]


def draw_density(axes, runs, rest_density):
    axes.axhline(rest_density, zorder=1, **LINES["rest density"])
    for name, columns, colour in coloured(runs):
        axes.plot(columns["step"], columns["density_mean"], **LINES["mean"] | {"color": colour})
        if has_values(columns, "density_interior"):
            axes.plot(columns["step"], columns["density_interior"], **LINES["interior only"] | {"color": colour})
        else:
            print(f"{name}: no interior density, so no second curve", file=sys.stderr)
    axes.set_ylabel("density (kg/m³)")


def draw_energy(axes, runs):
    for name, columns, colour in coloured(runs):
        if not (has_values(columns, "kinetic_energy") and has_values(columns, "potential_energy")):
            print(f"{name}: no energies, so none drawn", file=sys.stderr)
            continue
        kinetic = [value / 1000 for value in columns["kinetic_energy"]]
        potential = [value / 1000 for value in columns["potential_energy"]]
        curves = {"total": [k + p for k, p in zip(kinetic, potential)], "kinetic": kinetic, "potential": potential}
        for kind, values in curves.items():
            axes.plot(columns["step"], values, **LINES[kind] | {"color": colour})
    axes.set_ylabel("energy (kJ)")


def add_legends(axes, runs):
    """Above each panel its kinds of line; with several runs, which differ by colour, their names above them all."""
    first_colour = COLOURS[0] if len(runs) == 1 else "0.35"
    for panel, kinds in zip(axes, (DENSITIES, ENERGIES)):
        handles = [Line2D([], [], **{"color": first_colour} | LINES[kind], label=kind) for kind in kinds]
        panel.legend(handles=handles, loc="lower left", bbox_to_anchor=(0, 1), ncol=3, borderaxespad=0.2)
    if len(runs) > 1:
        handles = [Line2D([], [], color=colour, linewidth=3, label=name) for name, _, colour in coloured(runs)]
        columns = max(1, min(4, 64 // (8 + max(map(len, runs)))))
        kinds = axes[0].get_legend()
        axes[0].add_artist(kinds)
        axes[0].legend(handles=handles, loc="lower left", bbox_to_anchor=(0, 1.09), ncol=columns, borderaxespad=0.2)


def frame_label(runs):
    """The frame axis in words, with its time step where all runs share one."""
    steps = {columns["dt"][-1] for columns in runs.values() if has_values(columns, "dt")}
    label = f"frame (one each {1000 * steps.pop():.3g} ms)" if len(steps) == 1 else "frame"
    return label + "\n\nThe mean is below the rest density where particles\nat a free surface miss neighbours."


def draw(runs, rest_density, with_energy, output):
    plt.rcParams.update({"font.size": 10, "axes.spines.top": False, "axes.spines.right": False,
                         "axes.formatter.useoffset": False, "legend.frameon": False, "legend.fontsize": 9})
    panels = 2 if with_energy else 1
    figure, axes = plt.subplots(panels, 1, figsize=(6.4, 1.2 + 2.8 * panels), sharex=True, squeeze=False,
                                layout="constrained")
    draw_density(axes[0, 0], runs, rest_density)
    if with_energy:
        draw_energy(axes[1, 0], runs)
    for panel in axes[:, 0]:
        panel.grid(color="0.9", linewidth=0.6)
        panel.set_axisbelow(True)
        panel.margins(x=0.01)
    add_legends(axes[:, 0], runs)
    axes[-1, 0].set_xlabel(frame_label(runs))
    output.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(output, dpi=200)


def short_names(paths):
    """A name for each run, its directory's, or the whole path where two are alike."""
    directories = [path.resolve() if path.is_dir() else path.resolve().parent for path in paths]
    names = [directory.name for directory in directories]
    return [name if names.count(name) == 1 else str(path) for name, path in zip(names, paths)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("runs", nargs="+", type=Path, metavar="RUN", help="a run's directory, or series.csv")
    parser.add_argument("--output", type=Path, metavar="PNG", help="picture (default: density.png in the first RUN)")
    parser.add_argument("--rest-density", type=float, metavar="RHO", help="kg/m³ (default: the scene's, or 1000)")
    parser.add_argument("--scene", type=Path, help="scene file to take the rest density from")
    parser.add_argument("--energy", action="store_true", help="add a panel with the energies")
    arguments = parser.parse_args()
    first = arguments.runs[0]
    output = arguments.output or (first if first.is_dir() else first.parent) / "density.png"
    try:
        runs = dict(zip(short_names(arguments.runs), map(read_series, arguments.runs)))
        rest_density = arguments.rest_density or (rest_density_of(arguments.scene) if arguments.scene else 1000.0)
        draw(runs, rest_density, arguments.energy, output)
    except (BadInput, OSError) as error:
        print(f"plot_series.py: {error}", file=sys.stderr)
        return 2
    print(output)
    return 0


if __name__ == "__main__":
    sys.exit(main())
