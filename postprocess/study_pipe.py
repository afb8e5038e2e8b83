#!/usr/bin/python3
"""Flow that walls hold: between plates and in a pipe, against the parabolas of Poiseuille; between a cylinder that turns and one
at rest, against Taylor and Couette.

All are 1 m wide and repeat along x; nu = 0.2 m²/s, wendland_c2 with h = 4 spacings. Plates and pipe are pulled such that the middle
comes to 1 m/s; the inner cylinder, of 0.4 m, turns with 1 m/s. Round ones are filled with rings of particles, as a lattice leaves
a gap at a round wall. When the flow is steady: the root mean square and the largest of what velocities along the flow differ
from the exact ones by, m/s, and the mean over that of the exact ones; for cylinders, the torque on the one at rest over the exact
one in the second half of the run. The rows go to a CSV file.
"""

import tempfile
from pathlib import Path

import h5py
import numpy as np

from study import in_turn, launch, parser_of, states_of, write_table
from trevi_run import Run

NU, WIDTH = 0.2, 1.0  # m²/s, m
INNER = 0.2  # m, the radius of the cylinder that turns
TIMES = {"plates": 3.0, "pipe": 1.5, "cylinders": 0.5}  # s, until 0.3, 0.1 and 0.01 % of the start are left
PULLS = {"plates": 1.6, "pipe": 3.2, "cylinders": 0.0}  # m/s²
PIPE = """[[obstacle]]
type = "cylinder"
inside = true
center = [1.0, 0.5, 0.5]
axis = [1.0, 0.0, 0.0]
radius = 0.5
height = 20.0
"""
TURNING = f"""[[obstacle]]
type = "cylinder"
center = [1.0, 0.5, 0.5]
axis = [1.0, 0.0, 0.0]
radius = {INNER}
height = 20.0
angular_velocity = [{1 / INNER}, 0.0, 0.0]
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
        if flow == "cylinders":
            block += TURNING
    return (f'{box}[fluid]\nspacing = {s!r}\nkernel_radius = {h!r}\ndensity_kernel = "wendland_c2"\n{block}'
            f"[gravity]\nacceleration = [{PULLS[flow]}, 0.0, 0.0]\n[viscosity]\nnu = {NU}\nno_slip = true\n"
            f"[time]\ndt = 0.01\nend = {TIMES[flow]}\n[output.series]\n[output.checkpoint]\nkeep = 1\n")


def rings(across, inner=0.0):
    """Positions at distances inner + (k + 1/2) s from the axis, s apart along each ring and from ring to ring."""
    s, points = WIDTH / across, []
    for layer in range(12):
        for k in range(round((WIDTH / 2 - inner) / s)):
            radius = inner + (k + 0.5) * s
            count = max(1, round(2 * np.pi * radius / s))
            angle = 2 * np.pi * (np.arange(count) + 0.5 * (layer % 2)) / count
            x = np.full(count, (layer + 0.5) * s)
            points.append(np.column_stack([x, 0.5 + radius * np.cos(angle), 0.5 + radius * np.sin(angle)]))
    return np.concatenate(points)


def write_rings(across, path, inner=0.0):
    with h5py.File(path, "w") as stream:
        stream["particles/position"] = rings(across, inner).astype(np.float32)


def along_and_exact(flow, position, velocity):
    """Velocities along the flow of all particles, and what they are in the exact one."""
    across = position[:, 1:] - 0.5
    if flow == "plates":
        return velocity[:, 0], 1 - 4 * across[:, 1]**2
    radius, outer = np.hypot(*across.T), WIDTH / 2
    if flow == "pipe":
        return velocity[:, 0], 1 - 4 * radius**2
    along = (across[:, 0] * velocity[:, 2] - across[:, 1] * velocity[:, 1]) / radius
    return along, INNER / (outer**2 - INNER**2) * (outer**2 / radius - radius)


def torque_over_exact(folder, length):
    """The mean of the torque on the outer cylinder over that of Taylor and Couette."""
    table = Run(folder).obstacles
    torques = table["torque_x_0"][table["time"] > TIMES["cylinders"] / 2]
    outer = WIDTH / 2
    exact = 4 * np.pi * 1000 * NU * INNER * outer**2 / (outer**2 - INNER**2) * length
    return round(float(np.mean(torques)) / exact, 4)


def measure(trevi, flow, across):
    with tempfile.TemporaryDirectory() as folder:
        scene = Path(folder) / "scene.toml"
        scene.write_text(scene_of(flow, across), encoding="utf-8")
        write_rings(across, Path(folder) / "rings.h5", INNER if flow == "cylinders" else 0.0)
        code, message = launch(trevi, scene, Path(folder) / "run", [], time_limit=36000)
        if code != 0:
            raise SystemExit(message)
        position, velocity = states_of(Path(folder) / "run")[-1]
        torque = torque_over_exact(Path(folder) / "run", 12 * WIDTH / across) if flow == "cylinders" else ""
    along, exact = along_and_exact(flow, position, velocity)
    return {"flow": flow, "across": across, "particles": len(along),
            "rms_error": round(float(np.sqrt(np.mean((along - exact)**2))), 4),
            "largest_error": round(float(np.abs(along - exact).max()), 4),
            "mean_over_exact": round(float(along.mean() / exact.mean()), 4), "torque_over_exact": torque}


def main():
    parser = parser_of(__doc__, "CSV")
    parser.add_argument("--finest", type=int, default=40, help="particles across of the finest runs")
    parser.add_argument("--rings", type=int, metavar="N", help="only write the rings of a pipe N across, as HDF5, to the output")
    arguments = parser.parse_args()
    if arguments.rings:
        write_rings(arguments.rings, arguments.output)
        return
    rows = []
    cases = [(flow, across) for across in (10, 20, 40, 80) if across <= arguments.finest for flow in TIMES]
    for row in in_turn(lambda case: measure(arguments.trevi, *case), cases):
        rows.append(row)
        print(row, flush=True)
    write_table(arguments.output, rows)


if __name__ == "__main__":
    main()
