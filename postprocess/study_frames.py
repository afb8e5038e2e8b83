#!/usr/bin/python3
"""Bytes that a particle takes on disk in each kind of frame: of a dam of water, a cube 100 particles wide, that breaks in a
tank 2.5 times as long and 1.25 times as high. The frame of the fifth step is weighed. The rows go to a CSV file.
"""

import tempfile
from pathlib import Path

from study import launch, parser_of, write_table

SIDE = 100  # particles
ALL = 'fields = ["velocity", "density", "id"]\n'
KINDS = {
    "all, [output.vtkhdf]": None,
    "all": "",
    "all, VTU": 'format = "vtu"\n',
    "all, float32": 'precision = "single"\n',
    "all, float32, VTU": 'precision = "single"\nformat = "vtu"\n',
    "positions alone, float32": 'precision = "single"\nfields = []\n',
    "every 8th": "one_in = 8\n",
    "every 8th, float32": 'one_in = 8\nprecision = "single"\n',
    "surface": "surface = true\n",
    "surface, float32": 'surface = true\nprecision = "single"\n',
    "cells": 'what = "cells"\n',
}


def scene_text(side):
    text = f"""[domain]
max = [{2.5 * side * 0.02}, {side * 0.02}, {1.25 * side * 0.02}]
min = [0, 0, 0]
[fluid]
spacing = 0.02
[[particles]]
type = "block"
min = [0, 0, 0]
max = [{side * 0.02}, {side * 0.02}, {side * 0.02}]
[time]
dt = 0.002
end = 0.01
[gravity]
acceleration = [0, 0, -9.81]
[output.vtkhdf]
every_steps = 5
"""
    for kind in KINDS.values():
        if kind is None:
            continue
        fields = "" if "fields" in kind or "cells" in kind else ALL
        text += f"[[output.frames]]\nevery_steps = 5\n{kind}{fields}"
    return text


def bytes_below(folder):
    return sum(path.stat().st_size for path in folder.rglob("*_000005*") if path.is_file())


def main():
    parser = parser_of(__doc__, "CSV")
    parser.add_argument("--side", type=int, default=SIDE, help="particles along an edge of the cube (default %(default)s)")
    arguments = parser.parse_args()
    particles = arguments.side ** 3
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        scene, run = Path(folder) / "frames.toml", Path(folder) / "run"
        scene.write_text(scene_text(arguments.side))
        code, message = launch(arguments.trevi, scene, run, (), 1800)
        if code != 0:
            raise SystemExit(message)
        sets = iter(range(len(KINDS)))
        for name, kind in KINDS.items():
            size = (run / "particles_000005.hdf").stat().st_size if kind is None else bytes_below(run / f"frames_{next(sets)}")
            rows.append({"frames": name, "particles": particles, "bytes": size,
                         "bytes_per_particle": f"{size / particles:.3f}"})
            print(rows[-1])
    write_table(arguments.output, rows)


if __name__ == "__main__":
    main()
