#!/usr/bin/python3
"""Draws the pump speed of a scene's fountains against time, before a long run.

The curves are the program's own: this script runs `trevi SCENE --preview FILE.csv`, which reads the music as a run would
and simulates nothing; or give it such a .csv file. Gaps are times at which a pump is off. Where a fountain plays notes,
they are in a second panel. A speed v rises to v²/2g in empty air (right-hand axis).
"""

import argparse
import csv
import math
import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
from matplotlib.ticker import FuncFormatter  # noqa: E402

COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000"]  # Okabe and Ito
ROOT = Path(__file__).resolve().parent.parent
NAMES = "C C# D D# E F F# G G# A A# B".split()
GRAVITY = 9.8
MOST_TICKS = 14


class BadInput(Exception):
    pass


def curves_of(scene, trevi, overrides):
    """The program's curves of a scene, as text. It says itself what is wrong with a scene."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "preview.csv"
        command = [str(trevi), str(scene), "--preview", str(file)]
        for override in overrides:
            command += ["--set", override]
        try:
            result = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
        except OSError as error:
            raise BadInput(f"{trevi}: {error.strerror}; build the program first, or name it with --trevi") from error
        if result.returncode != 0:
            raise BadInput(result.stderr.strip() or f"{trevi} failed with exit code {result.returncode}")
        return file.read_text(encoding="utf-8")


def read_curves(text, name):
    """Times, and for each fountain its notes and speeds; a speed is nan while its pump is off."""
    rows = list(csv.reader(text.splitlines()))
    if len(rows) < 2 or rows[0][:1] != ["time"] or len(rows[0]) < 3 or rows[0][1] != "note_0":
        raise BadInput(f"{name}: not a file that trevi --preview wrote")
    try:
        columns = list(zip(*(map(float, row) for row in rows[1:]), strict=True))
    except ValueError as error:
        raise BadInput(f"{name}: a row is not all numbers ({error})") from error
    times, rest = columns[0], columns[1:]
    fountains = []
    for notes, speeds in zip(rest[::2], rest[1::2]):
        fountains.append((notes, [speed if speed > 0 else math.nan for speed in speeds]))
    return times, fountains


def grouped(fountains):
    """Fountains with the same curve are drawn once: {label: (notes, speeds)}."""
    groups = {}
    for k, curve in enumerate(fountains):
        groups.setdefault(repr(curve), (curve, []))[1].append(str(k))
    return {("fountain " if len(ks) == 1 else "fountains ") + ", ".join(ks): curve for curve, ks in groups.values()}


def note_name(number):
    rounded = round(number)
    return f"{NAMES[rounded % 12]}{rounded // 12 - 1}"


def draw(times, curves, title, output):
    plt.rcParams.update({"font.size": 10, "axes.spines.top": False, "axes.spines.right": False,
                         "legend.frameon": False, "legend.fontsize": 9})
    with_notes = any(math.isfinite(note) for notes, _ in curves.values() for note in notes)
    figure, axes = plt.subplots(2 if with_notes else 1, 1, figsize=(9, 5.6 if with_notes else 3.4), sharex=True,
                                squeeze=False, layout="constrained")
    speed_axes = axes[0, 0]
    for (label, (notes, speeds)), colour in zip(curves.items(), COLOURS * len(curves)):
        speed_axes.plot(times, speeds, color=colour, linewidth=1.5, label=label, drawstyle="steps-post")
        if with_notes:
            axes[1, 0].plot(times, notes, color=colour, linewidth=2.5, drawstyle="steps-post", solid_capstyle="butt")
    speed_axes.set_ylabel("pump speed (m/s)")
    speed_axes.set_ylim(bottom=0)
    height = speed_axes.secondary_yaxis("right", functions=(lambda v: v * np.abs(v) / (2 * GRAVITY),
                                                            lambda h: np.sign(h) * np.sqrt(2 * GRAVITY * np.abs(h))))
    height.set_ylabel("height v²/2g (m)")
    height.spines["right"].set_visible(True)
    if with_notes:
        axes[1, 0].set_ylabel("note")
        played = sorted({round(note) for notes, _ in curves.values() for note in notes if math.isfinite(note)})
        axes[1, 0].set_yticks(played[::1 + len(played) // MOST_TICKS])
        axes[1, 0].yaxis.set_major_formatter(FuncFormatter(lambda number, _: note_name(number)))
    for panel in axes[:, 0]:
        panel.grid(color="0.9", linewidth=0.6)
        panel.set_axisbelow(True)
        panel.margins(x=0.01)
    speed_axes.legend(loc="lower left", bbox_to_anchor=(0, 1), ncol=4, borderaxespad=0.2)
    speed_axes.set_title(title, loc="right", fontsize=10)
    axes[-1, 0].set_xlabel("time (s)")
    output.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(output, dpi=150)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", type=Path, help="scene file (.toml), or what trevi --preview wrote (.csv)")
    parser.add_argument("--output", type=Path, metavar="PNG", help="picture (default: <scene>_music.png here)")
    parser.add_argument("--set", dest="overrides", action="append", default=[], metavar="TABLE.KEY=VALUE",
                        help="as for trevi; repeatable")
    parser.add_argument("--trevi", type=Path, default=ROOT / "build/release/trevi", help="the program")
    arguments = parser.parse_args()
    scene = arguments.scene
    output = arguments.output or Path(f"{scene.stem}_music.png")
    try:
        ready = scene.suffix == ".csv"
        text = scene.read_text(encoding="utf-8") if ready else curves_of(scene, arguments.trevi, arguments.overrides)
        times, fountains = read_curves(text, scene)
        draw(times, grouped(fountains), scene.stem, output)
    except (BadInput, OSError) as error:
        print(f"preview_music.py: {error}", file=sys.stderr)
        return 2
    print(output)
    return 0


if __name__ == "__main__":
    sys.exit(main())
