#!/usr/bin/python3
"""Flow between plates and in a pipe whose walls hold it, against the parabolas of Poiseuille.

Both are 1 m wide, repeat along x, and are pulled such that the middle comes to 1 m/s; nu = 0.2 m²/s, wendland_c2 with h = 4
spacings. The pipe is filled with rings of particles, as a lattice leaves a gap at a round wall. When the flow is steady: the root
mean square and the largest of what velocities along x differ from the parabola by, m/s, and the mean over that of the parabola.
The rows go to a CSV file.
"""

import tempfile
from pathlib import Path

import h5py
import numpy as np

from study import launch, parser_of, states_of, write_table

NU, WIDTH = 0.2, 1.0  # m²/s, m
TIMES = {"plates": 3.0, "pipe": 1.5}  # s, until 0.3 % and 0.1 % of the start are left
PULLS = {"plates": 1.6, "pipe": 3.2}  # m/s²
PIPE = """[[obstacle]]
type = "cylinder"
inside = true
center = [1.0, 0.5, 0.5]
axis = [1.0, 0.0, 0.0]
radius = 0.5
height = 20.0
"""


def scene_of(flow, across):
    s = WIDTH / across
    h, length = 4 * s, 12 * s
    if flow == "plates":
        box = f'[domain]\nmin = [0.0, 0.0, 0.0]\nmax = [{length!r}, {length!r}, 1.0]\nperiodic = ["x", "y"]\n'
        block = f"[[particles]]\nmin = [0.0, 0.0, 0.0]\nmax = [{length!r}, {length!r}, 1.0]\n"
    else:
        box = f'[domain]\nmin = [0.0, {-h!r}, {-h!r}]\nmax = [{length!r}, {1 + h!r}, {1 + h!r}]\nperiodic = ["x"]\n'
        block = f'[[particles]]\ntype = "file"\npath = "rings.h5"\n{PIPE}'
    return (f'{box}[fluid]\nspacing = {s!r}\nkernel_radius = {h!r}\ndensity_kernel = "wendland_c2"\n{block}'
            f"[gravity]\nacceleration = [{PULLS[flow]}, 0.0, 0.0]\n[viscosity]\nnu = {NU}\nno_slip = true\n"
            f"[time]\ndt = 0.01\nend = {TIMES[flow]}\n[output.series]\n[output.checkpoint]\nkeep = 1\n")


def rings(across):
    """Positions at distances (k + 1/2) s from the axis, s apart along each ring and from ring to ring."""
    s, points = WIDTH / across, []
    for layer in range(12):
        for k in range(across // 2):
            radius = (k + 0.5) * s
            count = max(1, round(2 * np.pi * radius / s))
            angle = 2 * np.pi * (np.arange(count) + 0.5 * (layer % 2)) / count
            x = np.full(count, (layer + 0.5) * s)
            points.append(np.column_stack([x, 0.5 + radius * np.cos(angle), 0.5 + radius * np.sin(angle)]))
    return np.concatenate(points)


def write_rings(across, path):
    with h5py.File(path, "w") as stream:
        stream["particles/position"] = rings(across).astype(np.float32)


def measure(trevi, flow, across):
    with tempfile.TemporaryDirectory() as folder:
        scene = Path(folder) / "scene.toml"
        scene.write_text(scene_of(flow, across), encoding="utf-8")
        write_rings(across, Path(folder) / "rings.h5")
        code, message = launch(trevi, scene, Path(folder) / "run", [], time_limit=36000)
        if code != 0:
            raise SystemExit(message)
        position, velocity = states_of(Path(folder) / "run")[-1]
    if flow == "plates":
        distance = np.abs(position[:, 2] - 0.5)
    else:
        distance = np.hypot(position[:, 1] - 0.5, position[:, 2] - 0.5)
    exact, along = 1 - 4 * distance**2, velocity[:, 0]
    return {"flow": flow, "across": across, "particles": len(along),
            "rms_error": round(float(np.sqrt(np.mean((along - exact)**2))), 4),
            "largest_error": round(float(np.abs(along - exact).max()), 4),
            "mean_over_exact": round(float(along.mean() / exact.mean()), 4)}


def main():
    parser = parser_of(__doc__, "CSV")
    parser.add_argument("--finest", type=int, default=40, help="particles across of the finest runs")
    parser.add_argument("--rings", type=int, metavar="N", help="only write the rings of a pipe N across, as HDF5, to the output")
    arguments = parser.parse_args()
    if arguments.rings:
        write_rings(arguments.rings, arguments.output)
        return
    rows = []
    for across in (10, 20, 40, 80):
        for flow in ("plates", "pipe") if across <= arguments.finest else ():
            rows.append(measure(arguments.trevi, flow, across))
            print(rows[-1], flush=True)
    write_table(arguments.output, rows)


if __name__ == "__main__":
    main()
